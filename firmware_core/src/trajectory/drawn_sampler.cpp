#include "trajectory/drawn_sampler.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "path/segment_speed.hpp"
#include "timing/met_place.hpp"

namespace inbetween {
namespace {

/// Joints that are nearer than this in frames are one: a key that is locked to a knot is met within rounding.
constexpr double same_moment = 1e-9;
/// The point of a joint that lies on no knot of the path.
constexpr std::int32_t nowhere = -1;

/// a = span + t as a time, exact where t is 0.
FrameTime time_of(const Track& track, const CurvePlace& place) {
  const std::int64_t f = track.profile().span_count();
  const std::int64_t scaled = static_cast<std::int64_t>(place.span) * track.frames();
  const FrameTime begin{static_cast<std::int32_t>(scaled / f),
                        static_cast<double>(scaled % f) / static_cast<double>(f)};
  return moved_by(begin, place.t * static_cast<double>(track.frames()) / static_cast<double>(f));
}

double constant_at(const Track& track, std::int32_t frame) {
  double constant = track.constant();
  for (const Portion& portion : track.portions()) {
    if (portion.begin_frame <= frame) constant = portion.constant;
  }
  return constant;
}

/// Collects the joints in the caller's memory.
class JointList {
 public:
  JointList(const Track& track, std::span<SampledJoint> memory) : track_(track), memory_(memory) {}

  void add_knots() {
    const std::int32_t f = track_.profile().span_count();
    for (std::int32_t i = 0; i <= f; ++i) {
      SampledJoint joint = at(i < f ? CurvePlace{i, 0} : CurvePlace{f - 1, 1});
      if (i > 0) joint.curve_before = {i - 1, 1};
      add(joint);
    }
  }
  void add_portions() {
    for (std::size_t i = 1; i < track_.portions().size(); ++i) {
      const Portion& portion = track_.portions()[i];
      SampledJoint joint = at(track_.place({portion.begin_frame, 0}));
      joint.time = {portion.begin_frame, 0};
      joint.constant_before = track_.portions()[i - 1].constant;
      joint.constant_after = portion.constant;
      add(joint);
    }
  }
  void add_path() {
    const Path& path = track_.path();
    std::int32_t before = nowhere;  // the last segment with a length
    for (std::int32_t i = 0; i < path.segment_count(); ++i) {
      if (!has_length(track_, i)) continue;
      if (before != nowhere)
        add_passing(track_.arc_length().segment_begin(i), {before, 1}, {i, 0}, path.key_at(before + 1));
      if (before == nowhere) first_ = {i, 0};
      before = i;
      last_ = {i, 1};
      const AnchoredIntervals split = split_where_slow(SegmentSpeed(path.segment(i), path.weights()));
      for (std::size_t k = 0; k < split.count; ++k) {
        const AnchoredInterval& interval = split.intervals[k];
        if (!interval.forward || interval.anchor <= 0 || interval.anchor >= 1) continue;
        const PathPoint anchor{i, interval.anchor};
        add_passing(track_.arc_length().distance(path, anchor), anchor, anchor, std::nullopt);
      }
    }
  }

  /// In order, those of one moment as one.
  std::span<const SampledJoint> settle() {
    const std::span<SampledJoint> all = memory_.first(count_);
    // A heap needs no recursion, so that the stack has a bound.
    std::make_heap(all.begin(), all.end(), is_before);
    std::sort_heap(all.begin(), all.end(), is_before);
    std::size_t kept = 0;
    for (const SampledJoint& joint : all) {
      if (kept > 0 && are_one(all[kept - 1], joint)) {
        join(all[kept - 1], joint);
      } else {
        all[kept++] = joint;
      }
    }
    all[0].point_after = first_;
    all[0].key = track_.path().key_at(0).value_or(-1);
    all[kept - 1].point_before = last_;
    all[kept - 1].key = track_.path().key_at(last_.segment + 1).value_or(-1);
    return all.first(kept);
  }
  [[nodiscard]] bool has_room() const { return count_ <= memory_.size(); }

 private:
  [[nodiscard]] SampledJoint at(const CurvePlace& place) const {
    SampledJoint joint;
    joint.time = time_of(track_, place);
    joint.curve_before = joint.curve_after = place;
    joint.point_before = joint.point_after = {nowhere, 0};
    joint.constant_before = joint.constant_after = constant_at(track_, joint.time.frame);
    return joint;
  }
  void add_passing(const TwoSum& distance, const PathPoint& before, const PathPoint& after,
                   std::optional<std::int32_t> key) {
    MetPlace met = find_distance(track_, distance);
    if (met.arriving == met.leaving) met.place = refined(met.place, met.leaving, distance);
    SampledJoint joint = at(met.place);
    joint.point_before = before;
    joint.point_after = after;
    joint.constant_before = met.arriving;
    joint.constant_after = met.leaving;
    joint.key = key.value_or(-1);
    add(joint);
  }
  /// The place to the last bits where the motion goes on: found is one as near as a lock is.
  [[nodiscard]] CurvePlace refined(CurvePlace place, double constant, const TwoSum& distance) const {
    constexpr int max_steps = 4;
    for (int i = 0; i < max_steps; ++i) {
      const double slope = constant * track_.profile().span(place.span).value(place.t);
      const double off = track_.distance(time_of(track_, place)).minus(distance);
      const double next = place.t - off / slope;
      if (!(next >= 0 && next <= 1)) break;  // at rest, or beyond the span
      place.t = next;
    }
    return place;
  }
  void add(const SampledJoint& joint) {
    if (count_ < memory_.size()) memory_[count_] = joint;
    ++count_;
  }
  static bool has_points(const SampledJoint& a, const SampledJoint& b) {
    return a.point_after.segment != nowhere && b.point_before.segment != nowhere;
  }
  [[nodiscard]] double distance_between(const SampledJoint& a, const SampledJoint& b) const {
    const auto distance = [&](const PathPoint& point) {
      return track_.arc_length().distance(track_.path(), point);
    };
    return distance(b.point_before).minus(distance(a.point_after));
  }
  /// At one moment, or nearer to each other along the path than the time of a place is known.
  [[nodiscard]] bool are_one(const SampledJoint& a, const SampledJoint& b) const {
    if (frames_between(a.time, b.time) <= same_moment) return true;
    return has_points(a, b) && distance_between(a, b) <= 4 * lock_share * track_.arc_length().total();
  }
  /// In time; of one moment knots of the curve, breaks, and passings in the order of the path: whatever the
  /// library sorts with, the order is the same.
  static bool is_before(const SampledJoint& a, const SampledJoint& b) {
    if (!(a.time == b.time)) return a.time < b.time;
    if (a.point_before.segment != b.point_before.segment)
      return a.point_before.segment < b.point_before.segment;
    if (a.point_before.t != b.point_before.t) return a.point_before.t < b.point_before.t;
    return a.constant_before == a.constant_after && b.constant_before != b.constant_after;
  }
  static bool is_inside(const CurvePlace& place) { return place.t > 0 && place.t < 1; }
  static void take_time(SampledJoint& into, const SampledJoint& other) {
    into.time = other.time;
    into.curve_before = other.curve_before;
    into.curve_after = other.curve_after;
  }
  /// A knot of the curve knows the time and its spans, a knot of the path its points, a break its constants.
  void join(SampledJoint& into, const SampledJoint& other) const {
    if (has_points(into, other) && (into.key < 0 || other.key < 0))
      into.passed_by = std::max(into.passed_by, 2 * std::fabs(distance_between(into, other)));
    if (is_inside(into.curve_after) && !is_inside(other.curve_after)) take_time(into, other);
    if (other.point_after.segment != nowhere) {
      const bool is_alone = into.point_before.segment == nowhere;
      const bool are_keys = into.key >= 0 && other.key >= 0;
      // A slow place beside a key is passed by: beside the key the axes would jump there.
      if (is_alone || (into.key < 0 && other.key >= 0)) {
        // The key brings its own time: a billionth of a frame beside it, the axes would jump too.
        if (is_inside(into.curve_after)) take_time(into, other);
        into.point_before = other.point_before;
        into.point_after = other.point_after;
      } else if (are_keys) {  // in the order of the path: their times are within rounding of each other
        if (other.point_before.at_or_before(into.point_before)) into.point_before = other.point_before;
        if (into.point_after.at_or_before(other.point_after)) into.point_after = other.point_after;
      }
      into.key = are_keys ? std::min(into.key, other.key) : std::max(into.key, other.key);
    }
    if (other.constant_before != other.constant_after) {
      into.constant_before = other.constant_before;
      into.constant_after = other.constant_after;
    }
  }

  const Track& track_;
  std::span<SampledJoint> memory_;
  std::size_t count_ = 0;
  PathPoint first_, last_;  ///< of the path that has a length
};

/// A segment whose cubics are multiples of one: a line, on which only the pace changes, however it turns
/// back. The chain rule would take large numbers from each other there.
class Line {
 public:
  Line(const Track& track, std::int32_t segment)
      : cubics_(track.path().segment(segment)), weights_(track.path().weights()) {
    for (std::size_t d = 0; d < cubics_.size(); ++d) {
      if (size_of(d) > size_of(largest_)) largest_ = d;
    }
    const std::array<double, 3> longest = of(largest_);
    for (std::size_t k = 0; k < longest.size(); ++k) {
      if (std::fabs(longest[k]) > std::fabs(longest[term_])) term_ = k;
    }
  }
  [[nodiscard]] bool is_there() const {
    const std::array<double, 3> longest = of(largest_);
    if (longest[term_] == 0) return false;
    for (std::size_t d = 0; d < cubics_.size(); ++d) {
      for (std::size_t k = 0; k < longest.size(); ++k) {
        const double off = std::fabs(of(d)[k] - ratio(d) * longest[k]);
        if (off > rounding * std::fabs(ratio(d) * longest[term_])) return false;
      }
    }
    return true;
  }
  /// dP / dL of every axis at t: with its sign there, or of a joint where the path stands still, to within
  /// the rounding of t, with that of its side.
  void write(const AlongPath& along, bool is_joint, bool arriving, std::span<AxisMotion> out) const {
    const Cubic& longest = cubics_[largest_];
    const double t = along.point.t;
    double slope = longest.derivative(t);
    const std::array<double, 3> terms = of(largest_);
    const double size = std::fabs(terms[0]) + std::fabs(terms[1]) + std::fabs(terms[2]);
    if (std::fabs(slope) <= (is_joint ? rounding * size : 0))
      slope = arriving ? -longest.second(t) : longest.second(t);
    if (slope == 0) slope = longest.third();
    const double sign = slope < 0 ? -1 : 1;
    double squares = 0;
    for (std::size_t d = 0; d < cubics_.size(); ++d)
      squares += weights_[d] * ratio(d) * weights_[d] * ratio(d);
    const double length = std::sqrt(squares);
    for (std::size_t d = 0; d < out.size(); ++d) {
      const double direction = sign * ratio(d) / length;
      out[d].velocity = direction * along.speed;
      out[d].acceleration = direction * along.acceleration;
      out[d].jerk = direction * along.jerk;
    }
  }

 private:
  static constexpr double rounding = 64 * std::numeric_limits<double>::epsilon();

  [[nodiscard]] std::array<double, 3> of(std::size_t d) const {
    return {cubics_[d].c1, 2 * cubics_[d].c2, 3 * cubics_[d].c3};
  }
  [[nodiscard]] double size_of(std::size_t d) const {
    const std::array<double, 3> terms = of(d);
    return weights_[d] * (std::fabs(terms[0]) + std::fabs(terms[1]) + std::fabs(terms[2]));
  }
  [[nodiscard]] double ratio(std::size_t d) const { return of(d)[term_] / of(largest_)[term_]; }

  std::span<const Cubic> cubics_;
  std::span<const double> weights_;
  std::size_t largest_ = 0;  ///< the axis that counts most
  std::size_t term_ = 0;     ///< of its derivative, the largest
};

const SampledSegment& know(const Track& track, std::int32_t segment, SampledSegment& known) {
  if (known.segment != segment) {
    known = {segment, SegmentSpeed(track.path().segment(segment), track.path().weights()),
             Line(track, segment).is_there()};
  }
  return known;
}

/// The point at a distance to the last bits: the tick's own inverse is only as near as it promises.
PathPoint point_at(const Track& track, const TwoSum& distance, SampledSegment& known) {
  constexpr int max_steps = 8;
  PathPoint point = track.arc_length().locate(distance);
  if (point.segment >= track.path().segment_count()) return point;
  const double rounding = std::numeric_limits<double>::epsilon() * track.arc_length().total();
  const SegmentSpeed& speed = know(track, point.segment, known).speed;
  for (int i = 0; i < max_steps; ++i) {
    const DistanceAndSpeed here = track.arc_length().distance(speed, point);
    const double off = here.distance.minus(distance);
    if (std::fabs(off) <= rounding || here.speed == 0) break;
    const double last = point.t;
    point.t = std::clamp(last - off / here.speed, 0.0, 1.0);
    // Newton's step leaves what the distance bends meanwhile, half of the change of speed times the step.
    const double changed = speed.unit() * speed.at(point.t) - here.speed;
    if (std::fabs(changed * (point.t - last)) <= rounding) break;
  }
  return point;
}

/// A key at which the motion rests is its place to the last bit.
PathPoint resting_point(const Track& track, const TwoSum& distance, bool arriving, SampledSegment& known) {
  const double margin = lock_share * track.arc_length().total();
  const PathPoint here = track.arc_length().locate(distance);
  const std::int32_t last = track.path().segment_count();
  for (std::int32_t key = here.segment; key <= std::min<std::int32_t>(here.segment + 1, last); ++key) {
    if (std::fabs(distance.minus(track.arc_length().segment_begin(key))) > margin) continue;
    if (arriving && key > 0 && has_length(track, key - 1)) return {key - 1, 1};
    return {key, 0};
  }
  return point_at(track, distance, known);
}

/// Where P' = 0 to first order: the direction in which the path leaves, and how it turns from there with the
/// root of the distance.
class Standing {
 public:
  Standing(const Track& track, const PathPoint& point)
      : cubics_(track.path().segment(point.segment)), t_(point.t) {
    const std::span<const double> weights = track.path().weights();
    double squares = 0, products = 0, thirds = 0;
    for (std::size_t d = 0; d < cubics_.size(); ++d) {
      const double second = weights[d] * cubics_[d].second(t_);
      const double third = weights[d] * cubics_[d].third();
      squares += second * second;
      products += second * third;
      thirds += third * third;
    }
    size_ = std::sqrt(squares);
    third_ = std::sqrt(thirds);
    along_ = squares > 0 ? products / squares : 0;
  }
  /// The direction is the opposite on the other side.
  [[nodiscard]] bool turns_back() const { return size_ > still_speed_share * third_; }
  /// That of every axis on the side on which the motion leaves. Where the point is known within rounding, P'
  /// may be that of any moment of the turn.
  void write_velocity(double speed, std::span<AxisMotion> out) const {
    for (std::size_t d = 0; d < out.size(); ++d) out[d].velocity = speed * (cubics_[d].second(t_) / size_);
  }
  /// Whether its part of the direction turns: then d2P / dL2 has no bound.
  [[nodiscard]] bool turns(std::size_t d) const {
    if (!(size_ > still_speed_share * third_)) return false;  // to second order: the direction goes on
    const double across = cubics_[d].third() - along_ * cubics_[d].second(t_);
    const double size = std::fabs(cubics_[d].third()) + std::fabs(along_ * cubics_[d].second(t_));
    return std::fabs(across) > straight_share * size;
  }

 private:
  /// What is less across than this share of itself is rounding.
  static constexpr double straight_share = 1e-9;

  std::span<const Cubic> cubics_;
  double t_;
  double size_ = 0, third_ = 0, along_ = 0;
};

/// Calls `take` with an axis and how far from its position at a point it is at a distance before and behind.
template <class Take>
void look_beside(const Track& track, const PathPoint& point, double offset, const Take& take) {
  const std::int32_t segments = track.path().segment_count();
  const std::span<const Cubic> here =
      track.path().segment(std::min<std::int32_t>(point.segment, segments - 1));
  const double t = point.segment < segments ? point.t : 1;
  const TwoSum distance = track.arc_length().distance(track.path(), point);
  SampledSegment known;
  for (const double side : {-offset, offset}) {
    TwoSum aside = distance;
    aside.add(side);
    const PathPoint beside = point_at(track, aside, known);
    if (beside.segment >= segments) continue;  // the end itself
    const std::span<const Cubic> there = track.path().segment(beside.segment);
    for (std::size_t d = 0; d < static_cast<std::size_t>(track.path().axis_count()); ++d)
      take(d, std::fabs(there[d].value(beside.t) - here[d].value(t)));
  }
}

/// Where an axis of weight 0 has no velocity, its position is known far worse than the distance: as well as
/// the root of its rounding. The velocity says so: what the rounding of the distance makes of the position
/// is in the same proportion to it as the velocity to the speed.
void write_mean_velocities(const Track& track, const AlongPath& along, std::span<AxisMotion> out) {
  const double rounding =
      distance_roundings * std::numeric_limits<double>::epsilon() * track.arc_length().total();
  look_beside(track, along.point, rounding, [&](std::size_t d, double reach) {
    out[d].velocity = std::max(out[d].velocity, reach / rounding * along.speed);
  });
}

}  // namespace

SampledSpeed sample_drawn(const Track& track, const FrameTime& time, const DrawnPlace& place, bool arriving,
                          SampledSegment& known, std::span<AxisMotion> out) {
  const SpeedSpan& span = track.profile().span(place.curve.span);
  const double constant = place.constant;
  const double rate = track.curve_rate();
  AlongPath along;
  along.speed = constant * rate * span.value(place.curve.t);
  along.acceleration = constant * rate * rate * span.derivative(place.curve.t);
  along.jerk = constant * rate * rate * rate * span.second(place.curve.t);
  along.point = place.point;
  if (along.point.segment == nowhere) {
    const TwoSum distance = track.distance(time);
    along.point =
        along.speed == 0 ? resting_point(track, distance, arriving, known) : point_at(track, distance, known);
  }
  const std::uint8_t order = track.motion_at(along, out);
  if (along.point.t == 1) {  // the key itself, and not what the cubic before it is rounded to
    const std::span<const Cubic> next = track.path().segment(along.point.segment + 1);
    for (std::size_t d = 0; d < out.size(); ++d) out[d].position = next[d].c0;
  }
  // At rest the axes stand at a key, and the curve has come to it within what a lock promises.
  const double off =
      along.speed == 0
          ? std::fabs(track.distance(time).minus(track.arc_length().distance(track.path(), along.point)))
          : 0;
  const std::int32_t segment = std::min<std::int32_t>(along.point.segment, track.path().segment_count() - 1);
  if (know(track, segment, known).is_line) {
    if (along.point.segment == segment)
      Line(track, segment).write(along, place.point.segment != nowhere, arriving, out);
    return {along.speed, 3, off, along.point};
  }
  if (order == 1) {
    if (const Standing standing(track, along.point); standing.turns_back())
      standing.write_velocity(arriving ? -along.speed : along.speed, out);
  } else if (order == 0 && place.point.segment == nowhere) {
    write_mean_velocities(track, along, out);
  }
  return {along.speed, order, off, along.point};
}

SampledSpeed sample_drawn(const Track& track, const FrameTime& time, SampledSegment& known,
                          std::span<AxisMotion> out) {
  return sample_drawn(track, time, {track.place(time), constant_at(track, time.frame), {nowhere, 0}}, false,
                      known, out);
}

void write_reach_along(const Track& track, const PathPoint& point, double offset, std::span<double> out) {
  std::fill(out.begin(), out.end(), 0.0);
  look_beside(track, point, offset, [&](std::size_t d, double reach) { out[d] = std::max(out[d], reach); });
}

bool has_unbounded_turn(const Track& track, const PathPoint& point, std::size_t axis) {
  return Standing(track, point).turns(axis);
}

std::size_t max_drawn_joints(const Track& track) {
  const auto spans = static_cast<std::size_t>(track.profile().span_count());
  return spans + 1 + track.portions().size() + 3 * static_cast<std::size_t>(track.path().segment_count());
}

std::span<const SampledJoint> drawn_joints(const Track& track, std::span<SampledJoint> memory) {
  JointList list(track, memory);
  list.add_knots();
  list.add_portions();
  list.add_path();
  return list.has_room() ? list.settle() : std::span<const SampledJoint>();
}

}  // namespace inbetween
