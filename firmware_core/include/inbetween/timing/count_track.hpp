#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/processor_clones.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/path/arc_length.hpp"
#include "inbetween/timing/frame_time.hpp"
#include "inbetween/timing/speed_profile.hpp"
#include "inbetween/timing/track.hpp"

/// A track as the counts of drives: what a controller without double precision evaluates every tick.

namespace inbetween {

/// The speed curve is cut, exactly, into at least this many spans: what a float rounds is then a small share
/// of the way, and the piece that a distance lies in is found among few. In double precision, where there are
/// more pieces, it is cut into more.
/// CountTrack.IsWithinATenthOfACountOfTwentyBits and Budget.EveryFunctionKeepsToItsInstructions hold it.
template <Precise Real>
inline constexpr std::int32_t min_count_spans = std::same_as<Real, float> ? 64 : 128;
/// Likewise a segment of the path is cut into at least this many pieces; double has digits enough without.
template <Precise Real>
inline constexpr std::int32_t min_pieces_per_segment = std::same_as<Real, float> ? 8 : 1;
/// A piece of the inverse has degree 7, and one of a count track less, which saves instructions of every
/// tick. In double precision it keeps its digits because it is cut in two;
/// CountTrack.InDoubleIsTheTrackItself holds it.
template <Precise Real>
inline constexpr std::int32_t min_parts_per_piece = std::same_as<Real, float> ? 1 : 2;

/// c[0] + c[1] x + c[2] x^2 + ... by Horner's rule with fused multiply-adds: one instruction and one rounding
/// a step on every processor with a floating-point unit for Real, and the same bits on all, because IEEE 754
/// defines them. (A Cortex-M4 has none for double; use float there.)
template <std::size_t Index = 0, Precise Real, std::size_t Count>
INBETWEEN_PART_OF_CLONES Real polynomial(const std::array<Real, Count>& c, Real x) {
  if constexpr (Index + 1 == Count) {
    return c[Index];
  } else {
    return std::fma(polynomial<Index + 1>(c, x), x, c[Index]);
  }
}

/// One span of the speed curve as a way: begin + t * (c[0] + c[1] t + c[2] t^2 + c[3] t^3), t from 0 to 1.
/// Within so short a span powers of t are as good as Bernstein's polynomials, and half the work.
template <Precise Real>
struct CountSpan {
  TwoSum<Real> begin;  ///< distance at its start
  std::array<Real, 4> c{};
  std::int32_t first_piece = 0;  ///< that in which it starts
  std::int32_t crowd = 0;        ///< how many it touches, if these are more than are tried in turn
};

/// One piece of the inverse of arc length, with a parameter of its own: w from 0 to 1 over the piece is
/// u * (c[0] + c[1] u + ... + c[4] u^4), in double precision + c[5] u^5. The way from its start enters as
///   plain, delicate:  u = way * inverse_step
///   root_after:       u = (sqrt(gap + way) - root) * inverse_step   (gap: from where the path stands still)
///   root_before:      u = (root - sqrt(gap - way)) * inverse_step   (gap: to where the path stands still)
/// with root = sqrt(gap), and both differences of roots written as way over their sum, which loses no digits.
template <Precise Real>
struct CountPiece {
  /// At all but plain ones it matters on which side of its start a distance is, to the last bit: behind a
  /// key the direction may have changed, and a short piece means nothing outside itself.
  enum class Kind : std::uint8_t { plain, delicate, root_after, root_before };

  TwoSum<Real> begin;
  Real inverse_step = 0;
  Real gap = 0;
  Real root = 0;
  std::array<Real, std::same_as<Real, float> ? 5 : 6> c{};
  std::int32_t first_cubic = 0;  ///< that of axis 0
  Kind kind = Kind::plain;

  [[nodiscard]] Real w(Real u) const { return u * polynomial(c, u); }
  /// u for a way of any kind of piece; one outside it belongs to its nearer end.
  [[nodiscard]] Real parameter(Real way) const {
    if (!(way > 0)) return 0;
    Real u = way * inverse_step;
    if (kind >= Kind::root_after) {
      // Below zero is rounding at the very point where the path stands still.
      const Real square = kind == Kind::root_after ? gap + way : gap - way;
      u /= std::sqrt(square > 0 ? square : Real(0)) + root;
    }
    return u < 1 ? u : Real(1);
  }
};

/// Pieces in a span up to this number are tried one after the other.
inline constexpr std::int32_t max_pieces_in_turn = 6;

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
  std::array<Real, 4> c{};

  [[nodiscard]] std::int32_t base() const {
    return static_cast<std::int32_t>(rounded_base + low_bits(rounder<Real>));
  }
  [[nodiscard]] Real offset(Real w) const { return polynomial(c, w); }
  [[nodiscard]] std::int32_t count(Real w) const {
    return static_cast<std::int32_t>(rounded_base + low_bits(offset(w) + rounder<Real>));
  }
};

/// `base` + `offset` counts.
template <Precise Real>
struct CountPosition {
  std::int32_t base = 0;
  Real offset = 0;
};

/// A stretch of the move with a time of its own: the whole move, or what lies between two breaks, or between
/// two keys of a move timed by frames. (frame * spans + phase) / frames is the number of a span, and the rest
/// the t in it.
template <Precise Real>
struct CountPortion {
  std::int32_t begin_frame = 0;
  std::int32_t frames = 1;
  std::int32_t spans = 1;
  std::int32_t phase = 0;
  std::int32_t last_span = 0;
  Real spans_in_real = 0;
  Real inverse_frames = 0;
};

/// How many spans a speed curve of f spans is cut into: the first of f, 2 f, 4 f, ... that is not below
/// min_count_spans.
template <Precise Real>
constexpr std::int32_t count_span_count(std::int32_t f) {
  while (f < min_count_spans<Real>) f *= 2;
  return f;
}

/// The parts of the count track of a track. Spans: count_span_count(), and one more a break. Pieces: those
/// of the arc length, each in min_parts_per_piece, and less than min_pieces_per_segment more a segment. For a
/// move timed by frames: a portion between two keys, and min_pieces_per_segment spans and pieces a segment.
struct CountSizes {
  std::size_t portions, spans, pieces;
};
template <Precise Real, Precise Source>
CountSizes count_sizes(const Track<Source>& track);

/// The memory of a count track, owned by the caller; sizes by count_sizes().
template <Precise Real>
struct CountTrackMemory {
  std::span<CountPortion<Real>> portions;  ///< portions + 1
  std::span<CountSpan<Real>> spans;
  std::span<CountPiece<Real>> pieces;  ///< pieces + 1
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
  /// travels 2^20 counts, the path is at most eight times as long, and the move has at least 12 frames (in
  /// fewer, the fraction of a frame is too coarse). From a Track<float> it is no better than that track: up
  /// to 1 count.
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
  INBETWEEN_PROCESSOR_CLONES void counts(const FrameTime<Real>& time, std::span<std::int32_t> out) const {
    const Place place = locate(time);
    const CountCubic<Real>* cubic = cubics_ + place.first_cubic;
    for (std::int32_t& count : out) count = (cubic++)->count(place.w);
  }
  /// One axis with its part of a count, for drives that interpolate.
  [[nodiscard]] INBETWEEN_PROCESSOR_CLONES CountPosition<Real> position(const FrameTime<Real>& time,
                                                                        std::int32_t axis) const {
    const Place place = locate(time);
    const CountCubic<Real>& cubic = cubics_[place.first_cubic + axis];
    return {cubic.base(), cubic.offset(place.w)};
  }

 private:
  CountTrack() = default;

  struct Place {
    std::int32_t first_cubic = 0;
    Real w = 0;
  };
  [[nodiscard]] INBETWEEN_PART_OF_CLONES Place locate(const FrameTime<Real>& time) const {
    // Negative frames are large ones here.
    if (static_cast<std::uint32_t>(time.frame) >= static_cast<std::uint32_t>(frames_)) [[unlikely]]
      return {time.frame < 0 ? 0 : piece_count_ * axis_count_, 0};
    const CountPortion<Real>& portion = portion_at(time.frame);
    const std::int32_t scaled = time.frame * portion.spans + portion.phase;
    std::int32_t index = scaled / portion.frames;
    const auto phase = static_cast<Real>(scaled - index * portion.frames);
    Real t = std::fma(time.fraction, portion.spans_in_real, phase) * portion.inverse_frames;
    if (t >= 1) [[unlikely]] {  // within a frame the curve may pass into the next span, or over several
      const auto whole = std::min(static_cast<std::int32_t>(t), portion.last_span - index);
      index += whole;
      t -= static_cast<Real>(whole);
    }
    const CountSpan<Real>& span = spans_[index];
    const Real way = t * polynomial(span.c, t);
    const CountPiece<Real>* piece = piece_at(span, span.begin.high + way);
    // The starts of span and piece are near each other: their difference rounds to a share of itself.
    const Real piece_way = span.begin.minus(piece->begin) + way;
    if (piece->kind != CountPiece<Real>::Kind::plain) [[unlikely]]
      return locate_exactly(piece, span.begin, way);
    return {piece->first_cubic, piece->w(piece_way * piece->inverse_step)};
  }
  /// `piece` is the one in which begin + way lies, or by a rounding one behind it.
  [[nodiscard]] Place locate_exactly(const CountPiece<Real>* piece, const TwoSum<Real>& begin,
                                     Real way) const {
    Real piece_way = begin.minus(piece->begin) + way;
    while (piece_way < 0 && piece != pieces_) {
      --piece;
      piece_way = begin.minus(piece->begin) + way;
    }
    return {piece->first_cubic, piece->w(piece->parameter(piece_way))};
  }
  [[nodiscard]] const CountPortion<Real>& portion_at(std::int32_t frame) const {
    if (portion_count_ == 1) [[likely]]
      return portions_[0];
    std::int32_t portion = 0;
    for (std::int32_t count = portion_count_; count > 1;) {  // it is one of `count` from `portion` on
      const std::int32_t half = count / 2;
      if (portions_[portion + half].begin_frame <= frame) portion += half;
      count -= half;
    }
    return portions_[portion];
  }
  /// The last piece that begins at or before a distance in the span; by a rounding of the distance it may be
  /// a neighbour. Never the one before a piece that is not plain, which tells its start to be a little
  /// earlier than it is (PieceCutter).
  [[nodiscard]] const CountPiece<Real>* piece_at(const CountSpan<Real>& span, Real distance) const {
    const CountPiece<Real>* piece = pieces_ + span.first_piece;
    if (span.crowd > 0) [[unlikely]] {  // near a cusp
      for (std::int32_t count = span.crowd; count > 1;) {
        const std::int32_t half = count / 2;
        if (piece[half].begin.high <= distance) piece += half;
        count -= half;
      }
    }
    while (piece[1].begin.high <= distance) ++piece;  // the last entry is above every distance
    return piece;
  }

  const CountPortion<Real>* portions_ = nullptr;
  const CountSpan<Real>* spans_ = nullptr;
  const CountPiece<Real>* pieces_ = nullptr;
  const CountCubic<Real>* cubics_ = nullptr;
  std::int32_t portion_count_ = 0;
  std::int32_t piece_count_ = 0;
  std::int32_t frames_ = 0;
  std::int32_t axis_count_ = 0;
};

/// Memory for tracks with up to `Axes` axes, `Values` control values, `Pieces` pieces as count_sizes() counts
/// them, and `Portions` portions.
template <Precise Real, std::size_t Axes, std::size_t Values, std::size_t Pieces, std::size_t Portions = 1>
struct CountTrackStorage {
  /// A curve of fewer control values may be cut into more spans, but into less than twice the least number.
  static constexpr std::size_t span_count =
      std::max<std::size_t>(Values, 2 * min_count_spans<Real> - 2) + Portions - 1;
  std::array<CountPortion<Real>, Portions + 1> portions;
  std::array<CountSpan<Real>, span_count> spans;
  std::array<CountPiece<Real>, Pieces + 1> pieces;
  std::array<CountCubic<Real>, (Pieces + 1) * Axes> cubics;

  [[nodiscard]] CountTrackMemory<Real> memory() { return {portions, spans, pieces, cubics}; }
};

}  // namespace inbetween
