#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/arc_length.hpp"
#include "inbetween/frame_time.hpp"
#include "inbetween/precision.hpp"
#include "inbetween/result.hpp"
#include "inbetween/speed_profile.hpp"
#include "inbetween/track.hpp"

/// A track as the counts of drives: what a controller without double precision evaluates every tick.

namespace inbetween {

/// In single precision the speed curve and the segments of the path are cut, exactly, into parts so short
/// that what a float rounds is a small share of the way: the curve into at least this many spans, a segment
/// into at least this many pieces. CountTrack.IsWithinATenthOfACountOfTwentyBits holds both. Double needs no
/// cutting.
template <Precise Real>
inline constexpr std::int32_t least_count_spans = std::same_as<Real, float> ? 64 : 1;
template <Precise Real>
inline constexpr std::int32_t least_pieces_per_segment = std::same_as<Real, float> ? 8 : 1;

/// One span of the speed curve as a way: begin + c1 t + c2 t^2 + c3 t^3 + c4 t^4, t from 0 to 1. Within so
/// short a span powers of t are as good as Bernstein's polynomials, and half the work.
template <Precise Real>
struct CountSpan {
  TwoSum<Real> begin;  ///< distance at its start
  Real c1 = 0, c2 = 0, c3 = 0, c4 = 0;
  std::int32_t first_piece = 0;  ///< the piece in which it starts

  [[nodiscard]] Real way(Real t) const { return t * (c1 + t * (c2 + t * (c3 + t * c4))); }
};

/// One piece of the inverse of arc length, with a parameter of its own: w from 0 to 1 over the piece is the
/// quintic c[0] u + ... + c[4] u^5. The way from its start enters as
///   plain:        u = way * inverse_step
///   root_after:   u = (sqrt(gap + way) - root) * inverse_step   (gap: from where the path stands still)
///   root_before:  u = (root - sqrt(gap - way)) * inverse_step   (gap: to where the path stands still)
/// with root = sqrt(gap), and both differences of roots written as way over their sum, which loses no digits.
template <Precise Real>
struct CountPiece {
  TwoSum<Real> begin;
  Real inverse_step = 0;
  Real gap = 0;
  Real root = 0;
  std::array<Real, 5> c{};
  typename ArcPiece<Real>::Kind kind{};

  [[nodiscard]] Real w_at(Real way) const {
    const Real u = parameter(way);
    return u * (c[0] + u * (c[1] + u * (c[2] + u * (c[3] + u * c[4]))));
  }

 private:
  [[nodiscard]] Real parameter(Real way) const {
    using Kind = typename ArcPiece<Real>::Kind;
    if (kind == Kind::plain) [[likely]]
      return way * inverse_step;
    const Real square = kind == Kind::root_after ? gap + way : gap - way;
    // Below zero is rounding at the very point where the path stands still.
    const Real sum = std::sqrt(square > 0 ? square : Real(0)) + root;
    return sum > 0 ? way * inverse_step / sum : Real(0);
  }
};

/// Adding this to an offset puts its whole part, rounded to nearest even, into the lowest bits of the sum:
/// one addition instead of a comparison and a conversion.
template <Precise Real>
inline constexpr Real rounder = std::same_as<Real, float> ? Real(12582912.0F) : Real(6755399441055744.0);
/// ... which holds for offsets up to this (float), or for all that have 32 bits (double).
template <Precise Real>
inline constexpr double largest_offset = std::same_as<Real, float> ? 4194304.0 : 2147483648.0;

/// The lowest 32 bits.
constexpr std::uint32_t low_bits(float number) {
  return std::bit_cast<std::uint32_t>(number);
}
constexpr std::uint32_t low_bits(double number) {
  return static_cast<std::uint32_t>(std::bit_cast<std::uint64_t>(number));
}

/// One axis on one piece: base + offset(w) counts. The base is the position at its start, rounded, and
/// |offset(0)| <= 1/2 is what the rounding left.
template <Precise Real>
struct CountCubic {
  std::uint32_t rounded_base = 0;  ///< base - low_bits(rounder), modulo 2^32
  Cubic<Real> offset;

  [[nodiscard]] std::int32_t base() const {
    return static_cast<std::int32_t>(rounded_base + low_bits(rounder<Real>));
  }
  [[nodiscard]] std::int32_t count(Real w) const {
    return static_cast<std::int32_t>(rounded_base + low_bits(offset.value(w) + rounder<Real>));
  }
};

/// `base` + `offset` counts.
template <Precise Real>
struct CountPosition {
  std::int32_t base = 0;
  Real offset = 0;
};

/// How many spans a count track cuts a speed curve of f spans into: the first of f, 2 f, 4 f, ... that is
/// not below least_count_spans.
template <Precise Real>
constexpr std::int32_t count_span_count(std::int32_t f) {
  while (f < least_count_spans<Real>) f *= 2;
  return f;
}

/// How many pieces a count track cuts those of an arc length into: less than
/// least_pieces_per_segment more a segment, and at least 1.
template <Precise Real, Precise Source>
std::size_t count_piece_count(const ArcLength<Source>& arc_length);

/// The memory of a count track, owned by the caller.
template <Precise Real>
struct CountTrackMemory {
  std::span<CountSpan<Real>> spans;    ///< count_span_count() + 1
  std::span<CountPiece<Real>> pieces;  ///< count_piece_count()
  std::span<Real> begins;              ///< count_piece_count() + 1
  std::span<CountCubic<Real>> cubics;  ///< (pieces + 1) * axes
};

/// The same motion as that of a track, in integer counts. Every floating-point number in it is local: time
/// to a span of the speed curve, with an exact integer phase; distance to a piece of the path, in two parts;
/// position to an integer at the start of the piece. Refers to the caller's memory, not to the track.
template <Precise Real>
class CountTrack {
 public:
  /// Worked out in double precision whatever Real is; on a controller without it that takes some thousand
  /// instructions a piece, once per move. `counts_per_unit` has one number per axis, negative where the
  /// drive counts the other way.
  ///
  /// Accuracy, Real = float, from a Track<double>: within 0.1 counts of that track, where the longest axis
  /// travels 2^20 counts and the path is at most eight times as long. From a Track<float> it is no better
  /// than that track: up to 1 count.
  /// Errors: wrong_count, not_finite and out_of_range (counts_per_unit; a position that does not fit 32
  /// bits, or a piece longer than the whole numbers that Real knows, with key and axis; too many frames
  /// times spans), capacity.
  template <Precise Source>
  static Result<CountTrack> make(const Track<Source>& track, std::span<const double> counts_per_unit,
                                 const CountTrackMemory<Real>& memory);

  [[nodiscard]] std::int32_t axis_count() const { return axis_count_; }
  [[nodiscard]] std::int32_t frames() const { return frames_; }

  /// The position of every axis in whole counts, rounded to nearest: the tick. `out` has axis_count()
  /// entries. Before frame 0 the start and from frame N on the end. O(axes), no allocation, no library
  /// call; the same bits on every target.
  void counts(const FrameTime<Real>& time, std::span<std::int32_t> out) const {
    const Place place = locate(time);
    const CountCubic<Real>* cubic = cubics_of(place);
    for (std::int32_t& count : out.first(static_cast<std::size_t>(axis_count_))) {
      count = (cubic++)->count(place.w);
    }
  }
  /// One axis with its part of a count, for drives that interpolate.
  [[nodiscard]] CountPosition<Real> position(const FrameTime<Real>& time, std::int32_t axis) const {
    const Place place = locate(time);
    const CountCubic<Real>& cubic = cubics_of(place)[axis];
    return {cubic.base(), cubic.offset.value(place.w)};
  }

 private:
  CountTrack() = default;

  struct Place {
    std::int32_t piece = 0;
    Real w = 0;
  };
  [[nodiscard]] Place locate(const FrameTime<Real>& time) const {
    // Negative frames are large ones here.
    if (static_cast<std::uint32_t>(time.frame) >= static_cast<std::uint32_t>(frames_)) [[unlikely]] {
      return {time.frame < 0 ? 0 : piece_count_, 0};
    }
    const std::int32_t scaled = time.frame * span_count_;
    std::int32_t index = scaled / frames_;
    Real t = (static_cast<Real>(scaled - index * frames_) + time.fraction * spans_in_real_) * inverse_frames_;
    if (t >= 1) [[unlikely]] {  // more spans than frames: a fraction of a frame may pass over some
      const auto whole = static_cast<std::int32_t>(t);
      index += whole;
      t -= static_cast<Real>(whole);
      if (index >= span_count_) {
        index = span_count_ - 1;
        t = 1;
      }
    }
    const CountSpan<Real>& span = spans_[index];
    const Real way = span.way(t);
    const std::int32_t number = piece_at(span, span.begin.high + way);
    const CountPiece<Real>& piece = pieces_[number];
    // The starts of span and piece are near each other: their difference rounds to a share of itself.
    return {number, piece.w_at(span.begin.minus(piece.begin) + way)};
  }
  /// The last piece that begins at or before a distance in the span.
  [[nodiscard]] std::int32_t piece_at(const CountSpan<Real>& span, Real distance) const {
    const Real* low = begins_ + span.first_piece;
    const Real* high = begins_ + (&span)[1].first_piece;
    while (high - low > 4) [[unlikely]] {  // near a cusp
        const Real* middle = low + (high - low + 1) / 2;
        if (*middle <= distance) {
          low = middle;
        } else {
          high = middle - 1;
        }
      }
    while (low[1] <= distance) ++low;  // the last entry is above every distance
    return static_cast<std::int32_t>(low - begins_);
  }
  [[nodiscard]] const CountCubic<Real>* cubics_of(const Place& place) const {
    return cubics_ + place.piece * axis_count_;
  }

  const CountSpan<Real>* spans_ = nullptr;  ///< span_count_ and one more, whose first_piece ends the search
  const CountPiece<Real>* pieces_ = nullptr;
  const Real* begins_ = nullptr;
  const CountCubic<Real>* cubics_ = nullptr;
  std::int32_t span_count_ = 0;
  std::int32_t piece_count_ = 0;
  Real spans_in_real_ = 0;
  Real inverse_frames_ = 0;
  std::int32_t frames_ = 0;
  std::int32_t axis_count_ = 0;
};

/// Memory for tracks with up to `Axes` axes, `Values` control values and `Pieces` pieces by
/// count_piece_count().
template <Precise Real, std::size_t Axes, std::size_t Values, std::size_t Pieces>
struct CountTrackStorage {
  /// A curve of fewer spans may be cut into more than one of `Values` - 1.
  static constexpr std::size_t span_count = 2 * std::max<std::size_t>(Values, least_count_spans<Real>);
  std::array<CountSpan<Real>, span_count + 1> spans;
  std::array<CountPiece<Real>, Pieces> pieces;
  std::array<Real, Pieces + 1> begins;
  std::array<CountCubic<Real>, (Pieces + 1) * Axes> cubics;

  [[nodiscard]] CountTrackMemory<Real> memory() { return {spans, pieces, begins, cubics}; }
};

}  // namespace inbetween
