#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "inbetween/timing/count_track.hpp"

/// The pieces of a count track: those of the arc length, cut short and turned into counts. Everything in
/// double.

namespace inbetween {

template <Precise Real>
TwoSum<Real> in_two_parts(double high, double low) {
  const auto part = static_cast<Real>(high + low);
  return {part, static_cast<Real>((high - static_cast<double>(part)) + low)};
}

template <Precise Source>
double sum_of(const TwoSum<Source>& sum) {
  return static_cast<double>(sum.high) + static_cast<double>(sum.low);
}

/// A part of a piece, or of a span: the parameter from a to b.
struct Part {
  double a = 0, b = 1;
};

/// Part number `index` of `count` equal ones.
constexpr Part part_of(std::int32_t index, std::int32_t count) {
  return {static_cast<double>(index) / count, static_cast<double>(index + 1) / count};
}

/// How much of its segment a piece covers, in t.
template <Precise Source>
double extent_of(const ArcPiece<Source>& piece) {
  double extent = 0;
  for (std::size_t k = 1; k < piece.c.size(); ++k) extent += static_cast<double>(piece.c[k]);
  return extent;
}

/// Into how many a piece is cut. One that the inverse takes as a point stays whole.
template <Precise Real, Precise Source>
std::int32_t part_count(const ArcPiece<Source>& piece) {
  if (!(piece.inverse_step > 0)) return 1;
  const double parts = std::ceil(min_pieces_per_segment<Real> * extent_of(piece));
  return static_cast<std::int32_t>(std::max<double>(min_parts_per_piece<Real>, parts));
}

/// The start of the parameter of a part, and its kind: distances in double.
template <Precise Real, Precise Source>
void set_begin(const ArcPiece<Source>& from, const Part& part, CountPiece<Real>& to) {
  using Kind = typename ArcPiece<Source>::Kind;
  const auto origin = static_cast<double>(from.origin);
  const auto shift = static_cast<double>(from.shift);
  const auto inverse_step = static_cast<double>(from.inverse_step);
  const double step = inverse_step > 0 ? 1 / inverse_step : 0.0;
  to.inverse_step = static_cast<Real>(inverse_step / (part.b - part.a));
  if (from.kind == Kind::plain) {
    to.kind = CountPiece<Real>::Kind::plain;
    to.begin = in_two_parts<Real>(origin, shift + part.a * step);
    to.gap = 0;
    to.root = 0;
    return;
  }
  const bool after = from.kind == Kind::root_after;
  to.kind = after ? CountPiece<Real>::Kind::root_after : CountPiece<Real>::Kind::root_before;
  const double root = std::max((after ? shift + part.a : shift - part.a) * step, 0.0);
  to.begin = in_two_parts<Real>(origin, after ? root * root : -root * root);
  to.gap = static_cast<Real>(root * root);
  to.root = static_cast<Real>(root);
}

/// The place of a part on its segment: t = begin + extent * w.
struct Stretch {
  double begin = 0;
  double extent = 0;
};

/// Lowers degree 7 to the one that a tick evaluates. It leaves out Chebyshev polynomials whose outermost
/// zeros are moved to 0 and 1, where pieces meet. They are at most 1.5e-4 of c[7] and 6e-4 of c[6].
template <Precise Real>
void lower_degree(std::array<double, 8>& c) {
  constexpr std::array<double, 6> seventh{-0.0089440082567369097, 0.17168622523234169, -1.0973048183619977,
                                          3.2242710023106548,     -4.7897084009242620, 3.5};
  constexpr std::array<double, 5> sixth{0.026923788646684060, -0.375, 1.6961524227066319, -3.3480762113533159,
                                        3};
  for (std::size_t k = 0; k < seventh.size(); ++k) c[k + 1] += seventh[k] * c[7];
  c[7] = 0;
  if (CountPiece<Real>{}.c.size() > sixth.size()) return;
  for (std::size_t k = 0; k < sixth.size(); ++k) c[k + 1] += sixth[k] * c[6];
  c[6] = 0;
}

/// t over the part as a polynomial from 0 to 1, and where that is on the segment.
template <Precise Real, Precise Source>
Stretch set_polynomial(const ArcPiece<Source>& from, const Part& part, CountPiece<Real>& to) {
  std::array<double, 8> c{};
  for (std::size_t k = 0; k < c.size(); ++k) c[k] = static_cast<double>(from.c[k]);
  if (part.a > 0) {  // Taylor's coefficients about a
    for (std::size_t k = 0; k + 1 < c.size(); ++k) {
#pragma GCC unroll 7
      for (std::size_t j = c.size() - 1; j > k; --j) c[j - 1] += part.a * c[j];
    }
  }
  const double width = part.b - part.a;
  double power = width;
  for (std::size_t k = 1; width < 1 && k < c.size(); ++k) {
    c[k] *= power;
    power *= width;
  }
  lower_degree<Real>(c);
  const Stretch stretch{.begin = c[0], .extent = c[1] + c[2] + c[3] + c[4] + c[5] + c[6]};
  // A piece without extent is passed without moving.
  const double scale = stretch.extent > 0 ? 1 / stretch.extent : 0.0;
  for (std::size_t k = 0; k < to.c.size(); ++k) to.c[k] = static_cast<Real>(c[k + 1] * scale);
  return stretch;
}

/// One axis of a segment over a stretch of it, in counts.
template <Precise Source>
Cubic<double> cut_cubic(const Cubic<Source>& source, const Stretch& stretch, double counts_per_unit) {
  const Cubic<double> c{static_cast<double>(source.c0), static_cast<double>(source.c1),
                        static_cast<double>(source.c2), static_cast<double>(source.c3)};
  const double t = stretch.begin;
  const double h = stretch.extent;
  return {counts_per_unit * c.value(t), counts_per_unit * h * c.derivative(t),
          counts_per_unit * h * h * (c.second(t) / 2), counts_per_unit * h * h * h * c.c3};
}

/// Whether a cubic stays within the offsets that Real rounds, and within 32 bits. A NaN, which coordinates
/// near the largest number can make, fits nowhere.
template <Precise Real>
bool fits_counts(const Cubic<double>& c) {
  constexpr double most = std::numeric_limits<std::int32_t>::max();
  const double farthest = std::fabs(c.c1) + std::fabs(c.c2) + std::fabs(c.c3);
  if (farthest + 1 <= largest_offset<Real> && std::fabs(c.c0) + farthest + 1 <= most) [[likely]]
    return true;
  // The Bezier ordinates enclose it more narrowly. What is no number is in the last of them.
  double smallest = 0;
  double largest = 0;
  for (const double ordinate : {c.c1 / 3, (2 * c.c1 + c.c2) / 3, c.c1 + c.c2 + c.c3}) {
    smallest = smallest <= ordinate ? smallest : ordinate;
    largest = largest >= ordinate ? largest : ordinate;
  }
  return std::max(-smallest, largest) + 1 <= largest_offset<Real> && c.c0 + smallest - 1 >= -most - 1 &&
         c.c0 + largest + 1 <= most;
}

/// Splits off the integer base.
template <Precise Real>
CountCubic<Real> in_counts(const Cubic<double>& c) {
  const double base = std::floor(c.c0 + 0.5);
  return {static_cast<std::uint32_t>(static_cast<std::int32_t>(base)) - low_bits(rounder<Real>),
          {static_cast<Real>(c.c0 - base), static_cast<Real>(c.c1), static_cast<Real>(c.c2),
           static_cast<Real>(c.c3)}};
}

/// A piece shorter than this share of the path is delicate. A longer one, evaluated a rounding of the
/// distance outside itself, is as good there as its neighbour.
template <Precise Real>
inline constexpr Real short_share = 256 * std::numeric_limits<Real>::epsilon();

/// Fills the memory of a count track piece by piece.
template <Precise Real, Precise Source>
class PieceCutter {
 public:
  PieceCutter(const Path<Source>& path, std::span<const double> counts_per_unit,
              const CountTrackMemory<Real>& memory)
      : path_(path), counts_per_unit_(counts_per_unit), memory_(memory) {}

  /// The pieces of the arc length: what enters is a distance.
  Status cut(const ArcLength<Source>& arc_length) {
    shortest_ = static_cast<Real>(arc_length.total()) * short_share<Real>;
    for (const ArcPiece<Source>& piece : arc_length.pieces()) {
      const std::int32_t parts = part_count<Real>(piece);
      for (std::int32_t i = 0; i < parts; ++i) {
        const Part part = part_of(i, parts);
        CountPiece<Real>& cut = next_piece();
        set_begin(piece, part, cut);
        const Stretch stretch = set_polynomial(piece, part, cut);
        if (const Status done = add(cut, piece.segment, stretch); !done) return done.error();
      }
    }
    if (count_ == 0) {  // the path stays where it is
      if (const Status done = add(next_piece() = {}, 0, {}); !done) return done.error();
    }
    return finish();
  }
  /// The segments themselves, for a move timed by frames: what enters is s.
  Status cut_segments() {
    constexpr std::int32_t parts = min_pieces_per_segment<Real>;
    for (std::int32_t segment = 0; segment < path_.segment_count(); ++segment) {
      for (std::int32_t i = 0; i < parts; ++i) {
        const Part part = part_of(i, parts);
        CountPiece<Real>& cut = next_piece();
        cut = {.begin = in_two_parts<Real>(segment + part.a, 0),
               .inverse_step = static_cast<Real>(parts),
               .c = {1}};
        if (const Status done = add(cut, segment, {part.a, part.b - part.a}); !done) return done.error();
      }
    }
    return finish();
  }

 private:
  using Kind = typename CountPiece<Real>::Kind;

  /// The piece behind the last one. It counts when it has been filled and added.
  CountPiece<Real>& next_piece() { return memory_.pieces[count_]; }

  Status add(CountPiece<Real>& piece, std::int32_t segment, const Stretch& stretch) {
    const bool behind_key = segment != segment_;
    const bool is_short = piece.inverse_step * shortest_ > 1;
    if (piece.kind == Kind::plain && (behind_key || is_short)) piece.kind = Kind::delicate;
    if (piece.kind != Kind::plain) lower(piece.begin);
    segment_ = segment;
    piece.first_cubic = static_cast<std::int32_t>(count_) * path_.axis_count();
    if (const Status done = set_row(segment, stretch); !done) return done.error();
    ++count_;
    return Done{};
  }
  /// Two units in the last place of `high` are moved to `low`. A distance rounded to one number is then never
  /// below `high` if it is not below the start: the search by one number does not stop too early.
  static void lower(TwoSum<Real>& begin) {
    const Real high = begin.high - 2 * std::numeric_limits<Real>::epsilon() * begin.high;
    begin.low += begin.high - high;
    begin.high = high;
  }
  /// Behind the last piece: what ends every search, and the place where the move ends.
  Status finish() {
    memory_.pieces[count_] = {};
    memory_.pieces[count_].begin.high = std::numeric_limits<Real>::infinity();
    return set_row(path_.segment_count(), {});
  }
  /// All axes of a segment over a stretch of it, as the next row of cubics.
  Status set_row(std::int32_t segment, const Stretch& stretch) {
    const std::span<const Cubic<Source>> cubics = path_.segment(segment);
    const auto axes = static_cast<std::size_t>(path_.axis_count());
    for (std::size_t d = 0; d < axes; ++d) {
      const Cubic<double> counts = cut_cubic(cubics[d], stretch, counts_per_unit_[d]);
      if (fits_counts<Real>(counts)) [[likely]] {
        memory_.cubics[count_ * axes + d] = in_counts<Real>(counts);
        continue;
      }
      return Error{
          .code = ErrorCode::out_of_range,
          .what = "a position after this key does not fit the counts of a drive",
          .remedy = "use fewer counts per unit: a position has 32 bits, in single precision a piece 24",
          .key = segment,
          .axis = static_cast<std::int32_t>(d)};
    }
    return Done{};
  }

  const Path<Source>& path_;
  std::span<const double> counts_per_unit_;
  const CountTrackMemory<Real>& memory_;
  Real shortest_ = 0;
  std::size_t count_ = 0;
  std::int32_t segment_ = 0;
};

}  // namespace inbetween
