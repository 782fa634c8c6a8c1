#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "inbetween/timing/track.hpp"

/// The kinds of timing of a track: a drawn curve, a drawn curve in portions, or a frame for every key.

namespace inbetween {
namespace {

Status check_time_line(const SpeedProfile& profile, std::int32_t frames, FrameRate fps) {
  if (frames < 1 || frames > max_frames) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the number of frames is not between 1 and 1000000",
                 .remedy = "the move lasts frames / fps seconds"};
  }
  if (fps.numerator < 1 || fps.denominator < 1) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the frame rate is not positive",
                 .remedy = "use a fraction like 24/1 or 24000/1001"};
  }
  if (static_cast<std::int64_t>(frames) * profile.span_count() > std::numeric_limits<std::int32_t>::max()) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "frames times control values does not fit 31 bits",
                 .remedy = "draw the speed curve with fewer control values"};
  }
  return Done{};
}

/// K as a rounded value and the rest, so that K Phi(f) is the length to about twice the precision.
TwoSum solve_constant(const TwoSum& length, const TwoSum& integral) {
  TwoSum constant{length.high / integral.high, 0};
  const TwoSum product = two_product(constant.high, integral.high);
  const double rest =
      (length.high - product.high) + (length.low - product.low - constant.high * integral.low);
  constant.low = rest / integral.high;
  return constant;
}

/// `constant` times the integral of a span of the curve, in powers of t.
std::array<double, 4> distance_over(const SpeedSpan& span, double constant) {
  const double rise = span.b1 - span.b0;
  return {constant * span.b0, constant * (1.5 * rise), constant * ((span.b2 - span.b1) - rise),
          constant * (((span.b3 - span.b0) - 3 * (span.b2 - span.b1)) / 4)};
}

Error frame_error(const char* what, const char* remedy, std::int32_t key, std::int32_t frame) {
  return {.code = ErrorCode::out_of_range, .what = what, .remedy = remedy, .key = key, .frame = frame};
}

/// Slopes of the monotone spline through (key frame, s), in s per frame.
class MonotoneSlopes {
 public:
  explicit MonotoneSlopes(std::span<const std::int32_t> frames) : frames_(frames) {}

  [[nodiscard]] double at(std::size_t key) const {
    const std::size_t last = frames_.size() - 1;
    if (last == 1) return secant(0);
    if (key == 0) return end_slope(interval(0), interval(1));
    if (key == last) return end_slope(interval(last - 1), interval(last - 2));
    // Fritsch and Butland 1984, weighted harmonic mean; both secants are positive.
    const double before = interval(key - 1);
    const double after = interval(key);
    const double w1 = 2 * after + before;
    const double w2 = after + 2 * before;
    return (w1 + w2) / (w1 * before + w2 * after);  // 1 / secant is the interval
  }

 private:
  [[nodiscard]] double interval(std::size_t i) const {
    return static_cast<double>(frames_[i + 1] - frames_[i]);
  }
  [[nodiscard]] double secant(std::size_t i) const { return 1 / interval(i); }
  /// The parabola through three keys, kept between 0 and three times the secant: monotone.
  static double end_slope(double near, double next) {
    const double slope = ((2 * near + next) / near - near / next) / (near + next);
    return std::clamp(slope, 0.0, 3 / near);
  }
  std::span<const std::int32_t> frames_;
};

Status check_key_frames(const Path& path, std::span<const std::int32_t> key_frames, std::int32_t frames) {
  const std::size_t last = static_cast<std::size_t>(path.key_count()) - (path.closed() ? 0 : 1);
  if (key_frames.size() != last + 1 || path.segment_count() == 0) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "a move timed by frames needs two keys, and a frame for every key",
                 .remedy = "give every key its frame; a closed path one more, for the return to key 0"};
  }
  for (std::size_t i = 0; i <= last; ++i) {
    const auto key = static_cast<std::int32_t>(i);
    if (i == 0 && key_frames[i] != 0) {
      return frame_error("the first key is not on frame 0", "give it frame 0", key, key_frames[i]);
    }
    if (i == last && key_frames[i] != frames) {
      return frame_error("the last key is not on the last frame", "give it the frame of the move's end", key,
                         key_frames[i]);
    }
    if (i > 0 && key_frames[i] <= key_frames[i - 1]) {
      return frame_error("this key is not behind the key before it in time", "give it a later frame", key,
                         key_frames[i]);
    }
  }
  return Done{};
}

/// `part` of `parts` of so many frames, in the fewest parts of a frame that are whole numbers: of those that
/// there are in a path none is above 2^31 then.
KeyInterval interval_of(const FrameKnot& knot, std::int32_t begin_frame, std::int32_t frames) {
  const std::int32_t common = std::gcd(knot.parts, frames);
  const std::int32_t whole = frames / common;
  return {.begin_frame = begin_frame,
          .parts = knot.parts / common,
          .begin = knot.part * whole,
          .length = knot.length * whole};
}

/// Curves need a path over frames, and nothing else can use one. A monotone spline is one of whole keys.
Status check_knots(const Path& path, Kinetic kinetic) {
  const bool has_parts = !path.over_frames() && !path.knots().empty();
  if (path.over_frames() == (kinetic == Kinetic::curves) && !(has_parts && kinetic == Kinetic::monotone)) {
    return Done{};
  }
  return Error{.code = ErrorCode::out_of_range,
               .what = "the path and the kind of timing do not go together",
               .remedy = "make the path over the frames of its keys for curves, and for nothing else"};
}

}  // namespace

Result<Track> Track::make(const Path& path, const ArcLength& arc_length, const SpeedProfile& profile,
                          std::int32_t frames, FrameRate fps, const TrackMemory& memory) {
  if (const Status valid = check_time_line(profile, frames, fps); !valid) return valid.error();
  const auto f = static_cast<std::size_t>(profile.span_count());
  if (memory.span_distances.size() < f + 1) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the speed curve has more control values than the memory of the track",
                 .remedy = "give it a larger capacity",
                 .needed = static_cast<std::int64_t>(f) + 1};
  }
  const TwoSum length = arc_length.segment_begin(path.segment_count());
  if (profile.total_integral() < Precision::smallest_square_root && length.high > 0) {
    const bool zero = profile.total_integral() <= 0;
    return Error{.code = ErrorCode::no_distance,
                 .what = zero ? "the speed curve is zero everywhere, but the path has length"
                              : "the speed curve is too near zero everywhere for a path that has length",
                 .remedy = "raise a control value above 0"};
  }
  TwoSum constant;
  if (length.high > 0) constant = solve_constant(length, profile.integral_before(profile.span_count()));
  for (std::size_t i = 0; i <= f; ++i) {
    const TwoSum& integral = profile.integral_before(static_cast<std::int32_t>(i));
    TwoSum distance = two_product(constant.high, integral.high);
    distance.low += constant.high * integral.low + constant.low * integral.high;
    distance.renormalize();
    // In a dwell at the end the move is at the end, to the last bit.
    const bool arrived = integral == profile.integral_before(profile.span_count());
    SpanDistance& span = memory.span_distances[i];
    span.begin = arrived ? length : distance;
    if (i < f) span.c = distance_over(profile.span(static_cast<std::int32_t>(i)), constant.high);
  }
  Track track(path, arc_length, profile, frames, fps);
  track.span_distances_ = memory.span_distances.first(f + 1);
  track.constant_ = constant.high;
  return track;
}

Result<Track> Track::make_with_breaks(const Path& path, const ArcLength& arc_length,
                                      const SpeedProfile& profile, std::int32_t frames, FrameRate fps,
                                      std::span<const BreakKey> breaks, const TrackMemory& memory) {
  Result<Track> made = make(path, arc_length, profile, frames, fps, memory);
  if (!made || breaks.empty()) return made;
  if (memory.portions.size() < breaks.size() + 1) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the move has more breaks than the memory of the track",
                 .remedy = "give it a larger capacity",
                 .needed = static_cast<std::int64_t>(breaks.size()) + 1};
  }
  Track& track = *made;
  BreakKey begin;
  TwoSum integral_before;
  for (std::size_t i = 0; i <= breaks.size(); ++i) {
    const bool last = i == breaks.size();
    const BreakKey end = last ? BreakKey{path.segment_count(), frames} : breaks[i];
    if (end.key <= begin.key || end.key > path.segment_count() || end.frame <= begin.frame ||
        (!last && end.frame >= frames)) {
      return frame_error("the breaks are not in the order of their keys and frames",
                         "give every break a key and a frame behind those of the one before", end.key,
                         end.frame);
    }
    TwoSum integral = profile.integral_before(profile.span_count());
    if (!last) {
      const CurvePlace where = track.place({end.frame, 0});
      integral = profile.integral_before(where.span);
      integral.add(profile.span(where.span).integral(where.t));
    }
    const double length = arc_length.segment_begin(end.key).minus(arc_length.segment_begin(begin.key));
    const double covered = integral.minus(integral_before);
    if (!(covered >= Precision::smallest_square_root) && length > 0) {
      return Error{.code = ErrorCode::no_distance,
                   .what = covered > 0 ? "the speed curve is too near zero on the whole path to this key"
                                       : "the speed curve is zero on the whole path to this key",
                   .remedy = "raise a control value there above 0",
                   .key = end.key,
                   .frame = end.frame};
    }
    Portion& portion = memory.portions[i];
    portion = {begin.frame, length > 0 ? length / covered : 0.0, arc_length.segment_begin(begin.key)};
    const TwoSum skipped = two_product(portion.constant, integral_before.high);
    portion.offset.add(-skipped.high);
    portion.offset.low -= skipped.low + portion.constant * integral_before.low;
    begin = end;
    integral_before = integral;
  }
  track.portions_ = memory.portions.first(breaks.size() + 1);
  track.is_plain_ = track.needs_nothing_more_ = false;
  return made;
}

Result<Track> Track::make_with_key_frames(const Path& path, const ArcLength& arc_length,
                                          std::span<const std::int32_t> key_frames, Kinetic kinetic,
                                          std::int32_t frames, FrameRate fps, const TrackMemory& memory) {
  const SpeedProfile none = SpeedProfile::none();
  if (const Status valid = check_time_line(none, frames, fps); !valid) return valid.error();
  if (const Status keys = check_key_frames(path, key_frames, frames); !keys) return keys.error();
  if (const Status made = check_knots(path, kinetic); !made) return made.error();
  const auto segments = static_cast<std::size_t>(path.segment_count());
  if (memory.key_intervals.size() < segments) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the path has more segments than the memory of the track",
                 .remedy = "give it a larger capacity",
                 .needed = static_cast<std::int64_t>(segments)};
  }
  const MonotoneSlopes slopes(key_frames);
  for (std::size_t i = 0; i < segments; ++i) {
    KeyInterval& interval = memory.key_intervals[i];
    const FrameKnot knot =
        path.knots().empty() ? FrameKnot{.key = static_cast<std::int32_t>(i)} : path.knots()[i];
    const auto key = static_cast<std::size_t>(knot.key);
    const std::int32_t between = key_frames[key + 1] - key_frames[key];
    interval = interval_of(knot, key_frames[key], between);
    if (kinetic == Kinetic::monotone) {
      const double d0 = slopes.at(i) * static_cast<double>(between);
      const double d1 = slopes.at(i + 1) * static_cast<double>(between);
      interval.c1 = d0;
      interval.c2 = 3 - 2 * d0 - d1;
      interval.c3 = d0 + d1 - 2;
    }
  }
  Track track(path, arc_length, none, frames, fps);
  track.key_intervals_ = memory.key_intervals.first(segments);
  track.is_plain_ = track.needs_nothing_more_ = false;
  return track;
}

const Portion& Track::portion_at(std::int32_t frame) const {
  const auto behind = std::ranges::upper_bound(portions_, frame, {}, &Portion::begin_frame);
  return *(behind == portions_.begin() ? behind : behind - 1);
}

std::size_t Track::interval_at(const FrameTime& time) const {
  const auto behind = std::ranges::upper_bound(key_intervals_, time.frame, {}, &KeyInterval::begin_frame);
  if (behind == key_intervals_.begin()) return 0;
  // The last segment between the two keys: the one meant may be before it.
  const auto last = behind - 1;
  if (last->begin == 0) return static_cast<std::size_t>(last - key_intervals_.begin());
  const auto first = std::lower_bound(
      key_intervals_.begin(), last, last->begin_frame,
      [](const KeyInterval& interval, std::int32_t frame) { return interval.begin_frame < frame; });
  const auto next =
      std::partition_point(first, behind, [&](const KeyInterval& interval) { return interval.u(time) >= 0; });
  return static_cast<std::size_t>(next - key_intervals_.begin()) - (next == first ? 0 : 1);
}

TwoSum Track::special_distance(const FrameTime& time) const {
  return has_profile() ? broken_distance(time) : arc_length_.distance(path_, key_frame_point(time));
}

TwoSum Track::broken_distance(const FrameTime& time) const {
  const CurvePlace where = place(time);
  const Portion& portion = portion_at(time.frame);
  TwoSum integral = profile_.integral_before(where.span);
  integral.add(profile_.span(where.span).integral(where.t));
  // The very numbers that made the offset: at the break nothing is left of them, however large they are.
  const TwoSum covered = two_product(portion.constant, integral.high);
  TwoSum sum = portion.offset;
  sum.add(covered.high);
  sum.low += covered.low + portion.constant * integral.low;
  sum.renormalize();  // what two large numbers leave may lie in the low half, and is looked up by the high
                      // one
  return sum;
}

PathPoint Track::special_locate(const FrameTime& time) const {
  return has_profile() ? arc_length_.locate(broken_distance(time)) : key_frame_point(time);
}

PathPoint Track::key_frame_point(const FrameTime& time) const {
  if (time.frame >= frames_) return {path_.segment_count(), 0};
  const std::size_t index = interval_at(time);
  const KeyInterval& interval = key_intervals_[index];
  const double u = interval.u(time);
  const double t = u * (interval.c1 + u * (interval.c2 + u * interval.c3));
  return {static_cast<int>(index), t < 1 ? t : 1.0};
}

ParameterRates Track::key_frame_rates(const FrameTime& time) const {
  const bool at_end = time.frame >= frames_;
  const KeyInterval& interval = key_intervals_[at_end ? key_intervals_.size() - 1 : interval_at(time)];
  return interval.rates(interval.u(time), fps_);
}

}  // namespace inbetween
