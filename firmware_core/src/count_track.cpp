#include "inbetween/count_track.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace inbetween {
namespace {

Status check_counts_per_unit(std::int32_t axis_count, std::span<const double> counts_per_unit) {
  if (counts_per_unit.size() != static_cast<std::size_t>(axis_count)) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "there are not as many counts per unit as axes",
                 .remedy = "give one number per axis"};
  }
  for (std::size_t d = 0; d < counts_per_unit.size(); ++d) {
    const bool finite = std::isfinite(counts_per_unit[d]);
    if (finite && counts_per_unit[d] != 0) continue;
    return Error{.code = finite ? ErrorCode::out_of_range : ErrorCode::not_finite,
                 .what = finite ? "the counts per unit of an axis are 0"
                                : "the counts per unit of an axis are not a finite number",
                 .remedy = "give the counts of one unit, negative where the drive counts the other way",
                 .axis = static_cast<std::int32_t>(d)};
  }
  return Done{};
}

/// What the memory of a count track must hold.
struct Sizes {
  std::size_t spans, pieces, axes;
};

template <Precise Real>
Status check_memory(const Sizes& needed, const CountTrackMemory<Real>& memory) {
  Error error{.code = ErrorCode::capacity, .remedy = "give it a larger capacity"};
  if (memory.spans.size() < needed.spans) {
    error.what = "the speed curve has more spans than the memory of the count track";
    error.needed = static_cast<std::int64_t>(needed.spans);
  } else if (memory.pieces.size() < needed.pieces + 1) {
    error.what = "the arc length has more pieces than the memory of the count track";
    error.needed = static_cast<std::int64_t>(needed.pieces) + 1;
  } else if (memory.cubics.size() < (needed.pieces + 1) * needed.axes) {
    error.what = "the pieces have more axes than the memory of the count track";
    error.needed = static_cast<std::int64_t>((needed.pieces + 1) * needed.axes);
  } else {
    return Done{};
  }
  return error;
}

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

/// The integral of a span over a part of it as powers of the part's own t, times `scale`.
template <Precise Real, Precise Source>
void set_way(const SpeedSpan<Source>& drawn, const Part& part, double scale, CountSpan<Real>& to) {
  const SpeedSpan<double> wide{static_cast<double>(drawn.b0), static_cast<double>(drawn.b1),
                               static_cast<double>(drawn.b2), static_cast<double>(drawn.b3)};
  const double h = part.b - part.a;
  const double third = wide.b3 - wide.b0 + 3 * (wide.b1 - wide.b2);
  to.c = {static_cast<Real>(scale * h * wide.value(part.a)),
          static_cast<Real>(scale * h * h * wide.derivative(part.a) / 2),
          static_cast<Real>(scale * h * h * h * wide.second(part.a) / 6),
          static_cast<Real>(scale * h * h * h * h * third / 4)};
}

template <Precise Source>
double integral_to(const SpeedSpan<Source>& drawn, double t) {
  const SpeedSpan<double> wide{static_cast<double>(drawn.b0), static_cast<double>(drawn.b1),
                               static_cast<double>(drawn.b2), static_cast<double>(drawn.b3)};
  return wide.integral(t);
}

/// Cuts every span of the curve into `parts` and finds the pieces in which each starts and ends.
template <Precise Real, Precise Source>
void cut_spans(const Track<Source>& track, std::int32_t parts, std::span<const CountPiece<Real>> pieces,
               std::span<CountSpan<Real>> spans) {
  const SpeedProfile<Source>& profile = track.profile();
  const std::int32_t f = profile.span_count();
  const double length = sum_of(track.arc_length().segment_begin(track.path().segment_count()));
  // K of the track, with all digits that there are.
  const double constant = length > 0 ? length / sum_of(profile.integral_before(f)) : 0.0;
  std::int32_t piece = 0;
  const auto piece_at = [&](Real distance) {  // distances rise from call to call
    while (pieces[static_cast<std::size_t>(piece) + 1].begin.high <= distance) ++piece;
    return piece;
  };
  std::size_t index = 0;
  for (std::int32_t i = 0; i < f; ++i) {
    const double before = sum_of(profile.integral_before(i));
    for (std::int32_t k = 0; k < parts; ++k) {
      const Part part{static_cast<double>(k) / parts, static_cast<double>(k + 1) / parts};
      CountSpan<Real>& span = spans[index];
      set_way(profile.span(i), part, constant, span);
      span.begin = in_two_parts<Real>(constant * (before + integral_to(profile.span(i), part.a)), 0);
      span.first_piece = piece_at(span.begin.high);
      if (index > 0) spans[index - 1].last_piece = span.first_piece;
      ++index;
    }
  }
  spans[index - 1].last_piece = piece_at(static_cast<Real>(length));
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
  const double parts = std::ceil(least_pieces_per_segment<Real> * extent_of(piece));
  return parts > 1 ? static_cast<std::int32_t>(parts) : 1;
}

/// What the parameter of a part starts from: distances in double.
template <Precise Real, Precise Source>
void set_begin(const ArcPiece<Source>& from, const Part& part, CountPiece<Real>& to) {
  using Kind = typename ArcPiece<Source>::Kind;
  const auto origin = static_cast<double>(from.origin);
  const auto shift = static_cast<double>(from.shift);
  const auto inverse_step = static_cast<double>(from.inverse_step);
  const double step = inverse_step > 0 ? 1 / inverse_step : 0.0;
  to.kind = static_cast<typename ArcPiece<Real>::Kind>(from.kind);
  to.inverse_step = static_cast<Real>(inverse_step / (part.b - part.a));
  if (from.kind == Kind::plain) {
    to.begin = in_two_parts<Real>(origin, shift + part.a * step);
    return;
  }
  const bool after = from.kind == Kind::root_after;
  const double root = std::max((after ? shift + part.a : shift - part.a) * step, 0.0);
  to.begin = in_two_parts<Real>(origin, after ? root * root : -root * root);
  to.gap = static_cast<Real>(root * root);
  to.root = static_cast<Real>(root);
}

/// Where a part lies on its segment: t = begin + extent * w.
struct Stretch {
  double begin = 0;
  double extent = 0;
};

/// t over the part as a quintic from 0 to 1, and where that is on the segment.
template <Precise Real, Precise Source>
Stretch set_quintic(const ArcPiece<Source>& from, const Part& part, CountPiece<Real>& to) {
  std::array<double, 6> c{};
  for (std::size_t k = 0; k < c.size(); ++k) c[k] = static_cast<double>(from.c[k]);
  double power = 1;
  for (std::size_t k = 0; k < c.size(); ++k) {  // Taylor's coefficients about a, in units of b - a
    for (std::size_t j = c.size() - 1; j-- > k;) c[j] += part.a * c[j + 1];
    c[k] *= power;
    power *= part.b - part.a;
  }
  const Stretch stretch{.begin = c[0], .extent = c[1] + c[2] + c[3] + c[4] + c[5]};
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

/// Splits off the integer base. False if a position does not fit; the Bezier ordinates enclose them all.
template <Precise Real>
bool set_base(const Cubic<double>& c, CountCubic<Real>& result) {
  const auto [least, largest] = std::minmax({0.0, c.c1 / 3, (2 * c.c1 + c.c2) / 3, c.c1 + c.c2 + c.c3});
  const bool offset_fits = std::max(-least, largest) + 1 <= largest_offset<Real>;
  // A NaN, which coordinates near the largest number can make, fits nowhere.
  if (!offset_fits || !(c.c0 + least - 1 >= std::numeric_limits<std::int32_t>::min()) ||
      !(c.c0 + largest + 1 <= std::numeric_limits<std::int32_t>::max())) {
    return false;
  }
  const double base = std::floor(c.c0 + 0.5);
  result = {static_cast<std::uint32_t>(static_cast<std::int32_t>(base)) - low_bits(rounder<Real>),
            {static_cast<Real>(c.c0 - base), static_cast<Real>(c.c1), static_cast<Real>(c.c2),
             static_cast<Real>(c.c3)}};
  return true;
}

/// Fills the memory of a count track piece by piece.
template <Precise Real, Precise Source>
class PieceCutter {
 public:
  PieceCutter(const Path<Source>& path, std::span<const double> counts_per_unit,
              const CountTrackMemory<Real>& memory)
      : path_(path), counts_per_unit_(counts_per_unit), memory_(memory) {}

  Status cut(const ArcLength<Source>& arc_length) {
    for (const ArcPiece<Source>& piece : arc_length.pieces()) {
      const std::int32_t parts = part_count<Real>(piece);
      for (std::int32_t i = 0; i < parts; ++i) {
        const Part part{static_cast<double>(i) / parts, static_cast<double>(i + 1) / parts};
        CountPiece<Real> cut;
        set_begin(piece, part, cut);
        const Stretch stretch = set_quintic(piece, part, cut);
        if (const Status done = add(cut, piece.segment, stretch); !done) return done.error();
      }
    }
    if (count_ == 0) {  // the path stays where it is
      if (const Status done = add({}, 0, {}); !done) return done.error();
    }
    memory_.pieces[count_] = {};
    memory_.pieces[count_].begin.high = std::numeric_limits<Real>::infinity();
    return set_row(path_.segment_count(), {});
  }
  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  Status add(const CountPiece<Real>& piece, std::int32_t segment, const Stretch& stretch) {
    memory_.pieces[count_] = piece;
    memory_.pieces[count_].first_cubic = static_cast<std::int32_t>(count_) * path_.axis_count();
    if (const Status done = set_row(segment, stretch); !done) return done.error();
    ++count_;
    return Done{};
  }
  /// All axes of a segment over a stretch of it, as the next row of cubics.
  Status set_row(std::int32_t segment, const Stretch& stretch) {
    const std::span<const Cubic<Source>> cubics = path_.segment(segment);
    for (std::size_t d = 0; d < cubics.size(); ++d) {
      const Cubic<double> counts = cut_cubic(cubics[d], stretch, counts_per_unit_[d]);
      if (set_base(counts, memory_.cubics[count_ * cubics.size() + d])) continue;
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
  std::size_t count_ = 0;
};

Error too_many_spans() {
  return {.code = ErrorCode::out_of_range,
          .what = "frames times spans of the count track do not fit 31 bits",
          .remedy = "draw the speed curve with fewer control values, or plan fewer frames"};
}

}  // namespace

template <Precise Real, Precise Source>
std::size_t count_piece_count(const ArcLength<Source>& arc_length) {
  std::int32_t count = 0;
  for (const ArcPiece<Source>& piece : arc_length.pieces()) count += part_count<Real>(piece);
  return count > 0 ? static_cast<std::size_t>(count) : 1;
}

template <Precise Real>
template <Precise Source>
Result<CountTrack<Real>> CountTrack<Real>::make(const Track<Source>& track,
                                                std::span<const double> counts_per_unit,
                                                const CountTrackMemory<Real>& memory) {
  const Path<Source>& path = track.path();
  const std::int32_t f = track.profile().span_count();
  const std::int32_t spans = count_span_count(f);
  const Sizes sizes{.spans = static_cast<std::size_t>(spans),
                    .pieces = count_piece_count<Real>(track.arc_length()),
                    .axes = static_cast<std::size_t>(path.axis_count())};
  if (const Status valid = check_counts_per_unit(path.axis_count(), counts_per_unit); !valid)
    return valid.error();
  if (const Status enough = check_memory(sizes, memory); !enough) return enough.error();
  if (static_cast<std::int64_t>(track.frames()) * spans > std::numeric_limits<std::int32_t>::max()) {
    return too_many_spans();
  }
  PieceCutter<Real, Source> cutter(path, counts_per_unit, memory);
  if (const Status done = cutter.cut(track.arc_length()); !done) return done.error();
  cut_spans<Real, Source>(track, spans / f, memory.pieces, memory.spans);

  CountTrack result;
  result.spans_ = memory.spans.data();
  result.pieces_ = memory.pieces.data();
  result.cubics_ = memory.cubics.data();
  result.span_count_ = spans;
  result.piece_count_ = static_cast<std::int32_t>(sizes.pieces);
  result.spans_in_real_ = static_cast<Real>(spans);
  result.inverse_frames_ = 1 / static_cast<Real>(track.frames());
  result.frames_ = track.frames();
  result.axis_count_ = path.axis_count();
  return result;
}

#define INBETWEEN_INSTANTIATE(Real, Source)                                                               \
  template std::size_t count_piece_count<Real>(const ArcLength<Source>&);                                 \
  template Result<CountTrack<Real>> CountTrack<Real>::make(const Track<Source>&, std::span<const double>, \
                                                           const CountTrackMemory<Real>&);
INBETWEEN_INSTANTIATE(float, float)
INBETWEEN_INSTANTIATE(float, double)
INBETWEEN_INSTANTIATE(double, double)
#undef INBETWEEN_INSTANTIATE

}  // namespace inbetween
