#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/path/path.hpp"

/// The arc length of a path, L(s), and its inverse, s(L), which the real-time loop evaluates in O(1).

namespace inbetween {

/// One piece of the inverse: t as a quintic in u over a stretch of one segment, u in [0, 1].
/// The distance d that has been travelled enters as
///   plain:        u = (d - origin) * inverse_step                      (shift: the low part of origin)
///   root_after:   u = sqrt(d - origin) * inverse_step - shift          (origin: where the path stands still)
///   root_before:  u = shift - sqrt(origin - d) * inverse_step
/// The two square roots fit the neighbourhood of a point with P' = 0 (tension 1, a cusp), where t is
/// smooth in sqrt(d) and not in d.
template <Precise Real>
struct ArcPiece {
  enum class Kind : std::uint8_t { plain, root_after, root_before };

  Real origin = 0;
  Real shift = 0;
  Real inverse_step = 0;
  std::array<Real, 6> c{};
  std::int32_t segment = 0;
  Kind kind = Kind::plain;

  /// At either end of the piece for a distance beside it: where pieces are shorter than the last bit of
  /// the distance, the one looked up may be a neighbour of the one meant.
  [[nodiscard]] Real t_at(const TwoSum<Real>& distance) const {
    const Real raw = parameter(distance);
    const Real u = raw > 0 ? (raw < 1 ? raw : Real(1)) : Real(0);
    return c[0] + u * (c[1] + u * (c[2] + u * (c[3] + u * (c[4] + u * c[5]))));
  }

 private:
  [[nodiscard]] Real parameter(const TwoSum<Real>& distance) const {
    if (kind == Kind::plain) [[likely]] {
      return ((distance.high - origin) + (distance.low - shift)) * inverse_step;
    }
    const Real gap = (distance.high - origin) + distance.low;
    // A gap of the wrong sign is rounding at the very point where the path stands still.
    if (kind == Kind::root_after) return std::sqrt(gap > 0 ? gap : Real(0)) * inverse_step - shift;
    return shift - std::sqrt(gap < 0 ? -gap : Real(0)) * inverse_step;
  }
};

/// The memory of an arc length, owned by the caller. See ArcLengthStorage for sizes.
template <Precise Real>
struct ArcLengthMemory {
  std::span<ArcPiece<Real>> pieces;        ///< about 8 a segment at delta 1e-4, 20 at 1e-6, 80 at 1e-9
  std::span<Real> begins;                  ///< as many as pieces
  std::span<std::int32_t> buckets;         ///< any number >= 1; as many as pieces is best
  std::span<std::int32_t> first_pieces;    ///< segments + 1
  std::span<TwoSum<Real>> segment_begins;  ///< segments + 1
};

/// How a piece is accepted.
enum class Acceptance : std::uint8_t {
  estimated,  ///< the residual at its two extremes, with a safety factor of 4
  certified,  ///< a bound by Bernstein coefficients that holds on the whole piece; about 8 times the cost
};

template <Precise Real>
struct ArcLengthOptions {
  /// Largest relative error of the speed at which the inverse travels the path.
  Real delta = Precision<Real>::default_delta;
  Acceptance acceptance = Acceptance::estimated;
};

/// Arc length in weighted object space, |diag(weights) dP|. Refers to the caller's memory, not to the path.
template <Precise Real>
class ArcLength {
 public:
  /// Adaptive division in t. A piece's length is 6-point Gauss-Legendre of sigma = |P'|; its inverse
  /// is the quintic Hermite interpolant from t' = 1 / sigma and t'' = -q' / (2 q^2), q = sigma^2; it
  /// is accepted when |q t'^2 - 1| <= 2 delta, or when its error is below one rounding of the
  /// total length. Segments are normalised by a power of two, so neither offset nor scale matters.
  ///
  /// Accuracy: |speed / speed as asked - 1| <= delta over every step longer than 1e-6 of the length;
  /// a shorter step is within delta * step + 8 ulp(length), and in single precision every step: t
  /// itself is rounded to 2^-24.
  /// Errors: accuracy (delta below Precision<Real>::smallest_delta or not below 0.1; with the key where
  /// the acceptance asked for cannot be reached), out_of_range (a length that is not 0 and below
  /// Precision<Real>::smallest_square_root), capacity.
  /// Cost: about 0.1 us a piece on a desktop machine.
  static Result<ArcLength> make(const Path<Real>& path, const ArcLengthOptions<Real>& options,
                                const ArcLengthMemory<Real>& memory);

  /// Total length in weighted axis units; 0 for a path that stays where it is.
  [[nodiscard]] Real total() const { return segment_begins_.back().high; }
  /// Length from the start to key `index`, 0..segment_count.
  [[nodiscard]] const TwoSum<Real>& segment_begin(std::int32_t index) const {
    return segment_begins_[static_cast<std::size_t>(index)];
  }
  [[nodiscard]] std::int32_t piece_count() const { return static_cast<std::int32_t>(pieces_.size()); }
  /// The pieces in the order of distance, and the distance at which each begins.
  [[nodiscard]] std::span<const ArcPiece<Real>> pieces() const { return pieces_; }
  [[nodiscard]] std::span<const Real> begins() const { return begins_; }
  [[nodiscard]] Real delta() const { return delta_; }

  /// The point at a distance from the start: the start itself at 0, and at or beyond the total length
  /// the end of the path, both exact.
  /// Cost: O(1); near a cusp, where many pieces share a bucket, a bisection among them.
  [[nodiscard]] PathPoint<Real> locate(const TwoSum<Real>& distance) const {
    if (distance.high <= 0) return {0, 0};
    if (distance.minus(segment_begins_.back()) >= 0) return {segment_count(), 0};
    const ArcPiece<Real>& piece = pieces_[piece_at(distance.high)];
    // Rounding of the distance may point a few ulp beyond the segment; the point is its end.
    const Real t = piece.t_at(distance);
    return {piece.segment, t < 0 ? Real(0) : (t > 1 ? Real(1) : t)};
  }

  /// The same for many distances at once, bit for bit; quickest where they rise, because then one piece
  /// is evaluated for a run of them without looking anything up. All spans have the same size.
  void locate(std::span<const Real> distance_high, std::span<const Real> distance_low,
              std::span<PathPoint<Real>> points) const;

  /// The distance from the start to a point, by quadrature within its piece: full precision of Real.
  [[nodiscard]] TwoSum<Real> distance(const Path<Real>& path, const PathPoint<Real>& point) const;

 private:
  ArcLength() = default;
  [[nodiscard]] std::int32_t segment_count() const {
    return static_cast<std::int32_t>(segment_begins_.size()) - 1;
  }
  [[nodiscard]] std::size_t piece_at(Real distance) const {
    const std::size_t last = buckets_.size() - 1;
    const Real scaled = distance * buckets_per_length_;
    std::size_t bucket = scaled > 0 ? static_cast<std::size_t>(scaled) : 0;
    if (bucket > last) bucket = last;
    auto low = static_cast<std::size_t>(buckets_[bucket]);
    auto high = bucket < last ? static_cast<std::size_t>(buckets_[bucket + 1]) : pieces_.size() - 1;
    while (high - low > 3) {  // the piece is in [low, high]
      const std::size_t middle = (low + high + 1) / 2;
      if (begins_[middle] <= distance) {
        low = middle;
      } else {
        high = middle - 1;
      }
    }
    while (low < high && begins_[low + 1] <= distance) ++low;
    return low;
  }

  std::span<const ArcPiece<Real>> pieces_;
  std::span<const Real> begins_;
  std::span<const std::int32_t> buckets_;
  std::span<const std::int32_t> first_pieces_;
  std::span<const TwoSum<Real>> segment_begins_;
  Real buckets_per_length_ = 0;
  Real delta_ = 0;
};

/// Memory for a path of up to `Segments` segments with `Pieces` pieces in all.
template <Precise Real, std::size_t Segments, std::size_t Pieces = 24 * Segments>
struct ArcLengthStorage {
  std::array<ArcPiece<Real>, Pieces> pieces;
  std::array<Real, Pieces> begins;
  std::array<std::int32_t, Pieces> buckets;
  std::array<std::int32_t, Segments + 1> first_pieces;
  std::array<TwoSum<Real>, Segments + 1> segment_begins;

  [[nodiscard]] ArcLengthMemory<Real> memory() {
    return {pieces, begins, buckets, first_pieces, segment_begins};
  }
};

extern template class ArcLength<double>;
extern template class ArcLength<float>;

}  // namespace inbetween
