#pragma once

#include <algorithm>
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

/// c[0] + c[1] u + ... + c[7] u^7, with few steps that wait for one another (Estrin 1960).
template <class Number>
[[nodiscard]] Number septic(const std::array<Number, 8>& c, const Number& u) {
  const Number square = u * u;
  const Number high = (square * square) * ((c[4] + c[5] * u) + square * (c[6] + c[7] * u));
  return (c[0] + c[1] * u) + (square * (c[2] + c[3] * u) + high);
}

/// One piece of the inverse: t as a septic in u over a part of one segment, u in [0, 1]. A segment has many;
/// a piece of a trajectory, a polynomial in time, is something else. The distance d that has been travelled
/// enters as
///   plain:        u = (d - origin) * inverse_step                      (shift: the low part of origin)
///   root_after:   u = sqrt(d - origin) * inverse_step - shift          (origin: where the path stands still)
///   root_before:  u = shift - sqrt(origin - d) * inverse_step
/// The two square roots fit the neighbourhood of a point with P' = 0 (tension 1, a cusp), where t is
/// smooth in sqrt(d) and not in d.
struct ArcPiece {
  enum class Kind : std::uint8_t { plain, root_after, root_before };

  double origin = 0;
  double shift = 0;
  double inverse_step = 0;
  std::array<double, 8> c{};
  std::int32_t segment = 0;
  Kind kind = Kind::plain;

  /// From the origin to a distance near it: the difference of both is rounded to a share of itself.
  [[nodiscard]] double offset(const TwoSum& distance) const {
    const double high = distance.high - origin;
    return kind == Kind::plain ? high + (distance.low - shift) : high + distance.low;
  }
  /// t so far from the origin. At either end of the piece for a distance beside it: where pieces are shorter
  /// than the last bit of the distance, the one looked up may be a neighbour of the one meant. Rounding of
  /// the distance may point a few ulp beyond the segment; the point is its end.
  [[nodiscard]] double t_at(double offset) const {
    return kind == Kind::plain ? plain_t(offset) : t_of(root(offset));
  }
  /// t_at() of a plain piece.
  [[nodiscard]] double plain_t(double offset) const { return t_of(offset * inverse_step); }

 private:
  [[nodiscard]] static double within(double x) { return x > 0 ? (x < 1 ? x : 1.0) : 0.0; }
  [[nodiscard]] double t_of(double raw) const { return within(septic(c, within(raw))); }
  [[nodiscard]] double root(double gap) const {
    // A gap of the wrong sign is rounding at the very point where the path stands still.
    if (kind == Kind::root_after) return std::sqrt(gap > 0 ? gap : 0.0) * inverse_step - shift;
    return shift - std::sqrt(gap < 0 ? -gap : 0.0) * inverse_step;
  }
};

/// The memory of an arc length, owned by the caller. See ArcLengthStorage for sizes.
struct ArcLengthMemory {
  std::span<ArcPiece> pieces;            ///< about 12 a segment at delta 1e-4, 17 at 1e-6, 36 at 1e-9
  std::span<double> begins;              ///< as many as pieces: of the piece behind each
  std::span<std::int32_t> buckets;       ///< any number >= 1; up to 4 a piece make locate() quicker
  std::span<std::int32_t> first_pieces;  ///< segments + 1
  std::span<TwoSum> segment_begins;      ///< segments + 1
};

class SegmentSpeed;  // of a segment; inside the core

struct DistanceAndSpeed {
  TwoSum distance;
  double speed = 0;  ///< by t
};

/// How a piece is accepted.
enum class Acceptance : std::uint8_t {
  estimated,  ///< the residual at its two extremes, with a safety factor of 4
  certified,  ///< a bound by Bernstein coefficients that holds on the whole piece; about 8 times the cost
};

struct ArcLengthOptions {
  /// Largest relative error of the speed at which the inverse travels the path.
  double delta = Precision::default_delta;
  Acceptance acceptance = Acceptance::estimated;
};

/// Arc length in weighted object space, |diag(weights) dP|. Refers to the caller's memory, not to the path.
class ArcLength {
 public:
  /// Adaptive division in t. A piece's length is 7-point Gauss-Legendre of sigma = |P'|; its inverse is the
  /// septic Hermite interpolant from t' = 1 / sigma, t'' = -q' / (2 q^2) and t''' = (q'^2 - q q'' / 2) /
  /// sigma^7, q = sigma^2; it is accepted when |q t'^2 - 1| <= 2 delta, or when its error is below one
  /// rounding of the total length. Segments are normalised by a power of two, so neither offset nor scale
  /// matters.
  ///
  /// Accuracy: |speed / speed as asked - 1| <= delta over every step longer than 1e-6 of the length;
  /// a shorter step is within delta * step + 8 ulp(length).
  /// Errors: accuracy (delta below Precision::smallest_delta or not below 0.1; with the key where
  /// the acceptance asked for cannot be reached), out_of_range (a length that is not 0 and below
  /// Precision::smallest_square_root), capacity.
  /// Cost: about 0.1 us a piece on a desktop machine.
  static Result<ArcLength> make(const Path& path, const ArcLengthOptions& options,
                                const ArcLengthMemory& memory);

  /// Total length in weighted axis units; 0 for a path that stays where it is.
  [[nodiscard]] double total() const { return end_.high; }
  /// Length from the start to key `index`, 0..segment_count.
  [[nodiscard]] const TwoSum& segment_begin(std::int32_t index) const {
    return segment_begins_[static_cast<std::size_t>(index)];
  }
  [[nodiscard]] std::int32_t piece_count() const { return static_cast<std::int32_t>(pieces_.size()); }
  /// In the order of distance.
  [[nodiscard]] std::span<const ArcPiece> pieces() const { return pieces_; }
  [[nodiscard]] double delta() const { return delta_; }
  /// The distance at which a piece begins; its t there is c[0].
  [[nodiscard]] TwoSum begin_of(std::size_t piece) const {
    if (pieces_[piece].kind == ArcPiece::Kind::plain) return {pieces_[piece].origin, pieces_[piece].shift};
    return {piece > 0 ? next_begins_[piece - 1] : 0.0, 0};
  }

  /// The point at a distance from the start, begin + length: the start itself at 0, and at or beyond the
  /// total length the end of the path, both exact. `length` is rounded like a number of its own size, not
  /// like the distance. Cost: O(1); near a cusp, where many pieces share a bucket, a bisection among them.
  [[nodiscard]] PathPoint locate(const TwoSum& begin, double length = 0) const {
    const double distance = begin.high + length;
    if (distance <= 0) [[unlikely]]
      return {0, 0};
    if (is_at_end(distance, begin, length)) [[unlikely]]
      return {segment_count(), 0};
    const ArcPiece& piece = pieces_[piece_at(distance)];
    return {piece.segment, piece.t_at(piece.offset(begin) + length)};
  }

  /// The same for many lengths from one begin, bit for bit; quickest where they rise, because then one piece
  /// is evaluated for a run of them without looking anything up. Both spans have the same size. Returns
  /// whether the points are known to be in order: rounding may put one before that in front of it.
  bool locate(const TwoSum& begin, std::span<const double> lengths, std::span<PathPoint> points) const;

  /// The distance from the start to a point, by quadrature within its piece: full precision of double.
  [[nodiscard]] TwoSum distance(const Path& path, const PathPoint& point) const;
  /// The same by the speed on the point's segment, for who asks for it several times, and |diag(weights)
  /// dP/dt| there.
  [[nodiscard]] DistanceAndSpeed distance(const SegmentSpeed& speed, const PathPoint& point) const;

 private:
  ArcLength() = default;
  [[nodiscard]] std::int32_t segment_count() const {
    return static_cast<std::int32_t>(segment_begins_.size()) - 1;
  }
  [[nodiscard]] bool is_at_end(double distance, const TwoSum& begin, double length) const {
    return distance >= end_.high && begin.minus(end_) + length >= 0;
  }
  /// The last piece that begins at or before a distance above 0. A distance of two parts may be before the
  /// end when its `high` is not: behind the last bucket nothing is looked up.
  [[nodiscard]] std::size_t piece_at(double distance) const {
    if (distance >= end_.high) [[unlikely]]
      return pieces_.size() - 1;
    const auto bucket = static_cast<std::size_t>(static_cast<std::int32_t>(distance * buckets_per_length_));
    auto piece = static_cast<std::size_t>(buckets_[bucket]);
    // A branch that is seldom taken costs less than an addition that waits for the comparison.
    if (next_begins_[piece] <= distance) [[unlikely]] {
      ++piece;
      for (int passed = 1; next_begins_[piece] <= distance; ++piece) {
        if (++passed > 3) [[unlikely]]
          return piece_in_crowd(piece, bucket, distance);
      }
    }
    return piece;
  }
  [[nodiscard]] std::size_t piece_in_crowd(std::size_t piece, std::size_t bucket, double distance) const;

  std::span<const ArcPiece> pieces_;
  std::span<const double> next_begins_;  ///< where the piece behind each begins: infinity behind the last
  std::span<const std::int32_t> buckets_;
  std::span<const std::int32_t> first_pieces_;
  std::span<const TwoSum> segment_begins_;
  TwoSum end_;
  double buckets_per_length_ = 0;  ///< so little less that no distance is behind the last bucket
  double delta_ = 0;
};

/// Memory for a path of up to `Segments` segments with `Pieces` pieces in all.
template <std::size_t Segments, std::size_t Pieces = 24 * Segments>
struct ArcLengthStorage {
  std::array<ArcPiece, Pieces> pieces;
  std::array<double, Pieces> begins;
  std::array<std::int32_t, Pieces> buckets;
  std::array<std::int32_t, Segments + 1> first_pieces;
  std::array<TwoSum, Segments + 1> segment_begins;

  [[nodiscard]] ArcLengthMemory memory() { return {pieces, begins, buckets, first_pieces, segment_begins}; }
};

}  // namespace inbetween
