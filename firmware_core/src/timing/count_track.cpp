#include "inbetween/timing/count_track.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "count_piece.hpp"

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

template <Precise Real>
Status check_memory(const CountSizes& needed, std::size_t axes, const CountTrackMemory<Real>& memory) {
  Error error{.code = ErrorCode::capacity, .remedy = "give it a larger capacity"};
  if (memory.portions.size() < needed.portions + 1) {
    error.what = "the track has more portions than the memory of the count track";
    error.needed = static_cast<std::int64_t>(needed.portions) + 1;
  } else if (memory.spans.size() < needed.spans) {
    error.what = "the speed curve has more spans than the memory of the count track";
    error.needed = static_cast<std::int64_t>(needed.spans);
  } else if (memory.pieces.size() < needed.pieces + 1) {
    error.what = "the arc length has more pieces than the memory of the count track";
    error.needed = static_cast<std::int64_t>(needed.pieces) + 1;
  } else if (memory.cubics.size() < (needed.pieces + 1) * axes) {
    error.what = "the pieces have more axes than the memory of the count track";
    error.needed = static_cast<std::int64_t>((needed.pieces + 1) * axes);
  } else {
    return Done{};
  }
  return error;
}

/// The spans of the curve, uniform over all frames, that a portion of the move passes through.
struct SpanRange {
  std::int32_t first = 0;
  std::int32_t last = 0;
};

template <Precise Real, Precise Source>
SpanRange spans_of_portion(const Track<Source>& track, std::size_t portion) {
  const std::span<const Portion<Source>> portions = track.portions();
  const std::int64_t spans = count_span_count<Real>(track.profile().span_count());
  const std::int64_t begin = portions.empty() ? 0 : portions[portion].begin_frame;
  const std::int64_t end = portion + 1 < portions.size() ? portions[portion + 1].begin_frame : track.frames();
  return {static_cast<std::int32_t>(begin * spans / track.frames()),
          static_cast<std::int32_t>((end * spans - 1) / track.frames())};
}

/// Fills the portions and spans of a count track; the pieces are there already. In frames of its own: what it
/// needs is not on the stack while the pieces are cut.
template <Precise Real, Precise Source>
class SpanCutter {
 public:
  SpanCutter(const Track<Source>& track, std::size_t piece_count, const CountTrackMemory<Real>& memory)
      : track_(track), pieces_(memory.pieces.first(piece_count)), memory_(memory) {}

  /// A drawn curve, broken in portions or not.
  [[gnu::noinline]] void cut_curve() {
    const std::int32_t spans = count_span_count<Real>(track_.profile().span_count());
    const std::size_t portions = std::max<std::size_t>(track_.portions().size(), 1);
    for (std::size_t i = 0; i < portions; ++i) {
      const SpanRange range = spans_of_portion<Real>(track_, i);
      const Scale scale = scale_of(i);
      const std::int32_t first = span_count_;
      for (std::int32_t index = range.first; index <= range.last; ++index) add_curve_span(scale, index);
      const std::int32_t begin = track_.portions().empty() ? 0 : track_.portions()[i].begin_frame;
      add_portion({.begin_frame = begin,
                   .frames = track_.frames(),
                   .spans = spans,
                   .phase = (first - range.first) * track_.frames(),
                   .last_span = span_count_ - 1});
    }
    finish();
  }
  /// A frame for every key: the time between two keys is a portion.
  [[gnu::noinline]] void cut_intervals() {
    constexpr std::int32_t per_part = min_pieces_per_segment<Real>;
    std::int32_t first = 0;
    std::int32_t segment = 0;
    for (const KeyInterval<Source>& interval : track_.key_intervals()) {
      if (interval.part == 0) first = span_count_;
      for (std::int32_t i = 0; i < per_part; ++i) {
        add_interval_span(interval, segment, part_of(i, per_part));
      }
      ++segment;
      if (interval.part + 1 < interval.parts) continue;
      const std::int32_t spans = per_part * interval.parts;
      add_portion({.begin_frame = interval.begin_frame,
                   .frames = interval.frames,
                   .spans = spans,
                   .phase = first * interval.frames - interval.begin_frame * spans,
                   .last_span = span_count_ - 1});
    }
    finish();
  }

 private:
  /// distance = offset + constant * Phi(a), with all digits that there are.
  struct Scale {
    double constant = 0;
    double offset = 0;
  };
  [[nodiscard]] Scale scale_of(std::size_t portion) const {
    if (!track_.portions().empty()) {
      const Portion<Source>& broken = track_.portions()[portion];
      return {static_cast<double>(broken.constant), sum_of(broken.offset)};
    }
    const double length = sum_of(track_.arc_length().segment_begin(track_.path().segment_count()));
    const double integral = sum_of(track_.profile().integral_before(track_.profile().span_count()));
    return {length > 0 ? length / integral : 0.0, 0};
  }

  void add_curve_span(const Scale& scale, std::int32_t index) {
    const SpeedProfile<Source>& profile = track_.profile();
    const std::int32_t parts = count_span_count<Real>(profile.span_count()) / profile.span_count();
    const SpeedSpan<Source>& drawn = profile.span(index / parts);
    const SpeedSpan<double> speed{static_cast<double>(drawn.b0), static_cast<double>(drawn.b1),
                                  static_cast<double>(drawn.b2), static_cast<double>(drawn.b3)};
    const Part part = part_of(index % parts, parts);
    const double h = part.b - part.a;
    const double third = speed.b3 - speed.b0 + 3 * (speed.b1 - speed.b2);
    const double integral = sum_of(profile.integral_before(index / parts)) + speed.integral(part.a);
    add_span(
        scale.offset + scale.constant * integral,
        {scale.constant * h * speed.value(part.a), scale.constant * h * h * speed.derivative(part.a) / 2,
         scale.constant * h * h * h * speed.second(part.a) / 6, scale.constant * h * h * h * h * third / 4});
  }

  void add_interval_span(const KeyInterval<Source>& interval, std::int32_t segment, const Part& part) {
    const Cubic<double> t{0, static_cast<double>(interval.c1), static_cast<double>(interval.c2),
                          static_cast<double>(interval.c3)};
    const double h = part.b - part.a;
    add_span(segment + t.value(part.a),
             {h * t.derivative(part.a), h * h * t.second(part.a) / 2, h * h * h * t.c3, 0});
  }

  void add_span(double begin, const std::array<double, 4>& c) {
    CountSpan<Real>& span = memory_.spans[static_cast<std::size_t>(span_count_++)];
    span.begin = in_two_parts<Real>(begin, 0);
    std::ranges::transform(c, span.c.begin(), [](double x) { return static_cast<Real>(x); });
    span.first_piece = piece_at(span.begin.high);
    near_piece_ = static_cast<std::size_t>(span.first_piece);
    const std::int32_t last_piece = piece_at(static_cast<Real>(begin + c[0] + c[1] + c[2] + c[3]));
    const std::int32_t touched = last_piece - span.first_piece + 1;
    span.crowd = touched > max_pieces_in_turn ? touched : 0;
  }
  /// The last piece that begins at or before a distance, or the first. Distances rise from span to span, so
  /// that it is near the last one found.
  [[nodiscard]] std::int32_t piece_at(Real distance) const {
    std::size_t piece = near_piece_;
    while (piece + 1 < pieces_.size() && pieces_[piece + 1].begin.high <= distance) ++piece;
    while (piece > 0 && pieces_[piece].begin.high > distance) --piece;
    return static_cast<std::int32_t>(piece);
  }

  void add_portion(CountPortion<Real> portion) {
    portion.spans_in_real = static_cast<Real>(portion.spans);
    portion.inverse_frames = 1 / static_cast<Real>(portion.frames);
    memory_.portions[portion_count_++] = portion;
  }
  void finish() {
    memory_.portions[portion_count_] = {.begin_frame = std::numeric_limits<std::int32_t>::max()};
  }

  const Track<Source>& track_;
  std::span<const CountPiece<Real>> pieces_;
  const CountTrackMemory<Real>& memory_;
  std::size_t portion_count_ = 0;
  std::int32_t span_count_ = 0;
  std::size_t near_piece_ = 0;
};

}  // namespace

template <Precise Real, Precise Source>
CountSizes count_sizes(const Track<Source>& track) {
  if (!track.has_profile()) {
    const std::span<const KeyInterval<Source>> intervals = track.key_intervals();
    const std::size_t parts = intervals.size() * static_cast<std::size_t>(min_pieces_per_segment<Real>);
    const auto portions = std::ranges::count(intervals, 0, &KeyInterval<Source>::part);
    return {.portions = static_cast<std::size_t>(portions), .spans = parts, .pieces = parts};
  }
  CountSizes sizes{.portions = std::max<std::size_t>(track.portions().size(), 1), .spans = 0, .pieces = 0};
  for (std::size_t i = 0; i < sizes.portions; ++i) {
    const SpanRange range = spans_of_portion<Real>(track, i);
    sizes.spans += static_cast<std::size_t>(range.last - range.first + 1);
  }
  for (const ArcPiece<Source>& piece : track.arc_length().pieces()) {
    sizes.pieces += static_cast<std::size_t>(part_count<Real>(piece));
  }
  sizes.pieces = std::max<std::size_t>(sizes.pieces, 1);
  return sizes;
}

template <Precise Real>
template <Precise Source>
Result<CountTrack<Real>> CountTrack<Real>::make(const Track<Source>& track,
                                                std::span<const double> counts_per_unit,
                                                const CountTrackMemory<Real>& memory) {
  const Path<Source>& path = track.path();
  const CountSizes sizes = count_sizes<Real>(track);
  if (const Status valid = check_counts_per_unit(path.axis_count(), counts_per_unit); !valid)
    return valid.error();
  if (const Status enough = check_memory(sizes, static_cast<std::size_t>(path.axis_count()), memory);
      !enough) {
    return enough.error();
  }
  // No more spans than this are uniform over all frames.
  if (static_cast<std::int64_t>(track.frames()) * static_cast<std::int64_t>(sizes.spans) >
      std::numeric_limits<std::int32_t>::max()) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "frames times spans of the count track do not fit 31 bits",
                 .remedy = "draw the speed curve with fewer control values, or plan fewer frames"};
  }
  PieceCutter<Real, Source> pieces(path, counts_per_unit, memory);
  SpanCutter<Real, Source> spans(track, sizes.pieces, memory);
  const Status done = track.has_profile() ? pieces.cut(track.arc_length()) : pieces.cut_segments();
  if (!done) return done.error();
  if (track.has_profile()) {
    spans.cut_curve();
  } else {
    spans.cut_intervals();
  }
  CountTrack result;
  result.portions_ = memory.portions.data();
  result.spans_ = memory.spans.data();
  result.pieces_ = memory.pieces.data();
  result.cubics_ = memory.cubics.data();
  result.portion_count_ = static_cast<std::int32_t>(sizes.portions);
  result.piece_count_ = static_cast<std::int32_t>(sizes.pieces);
  result.frames_ = track.frames();
  result.axis_count_ = path.axis_count();
  return result;
}

#define INBETWEEN_INSTANTIATE(Real, Source)                                                               \
  template CountSizes count_sizes<Real>(const Track<Source>&);                                            \
  template Result<CountTrack<Real>> CountTrack<Real>::make(const Track<Source>&, std::span<const double>, \
                                                           const CountTrackMemory<Real>&);
INBETWEEN_INSTANTIATE(float, float)
INBETWEEN_INSTANTIATE(float, double)
INBETWEEN_INSTANTIATE(double, double)
#undef INBETWEEN_INSTANTIATE

}  // namespace inbetween
