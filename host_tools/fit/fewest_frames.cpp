#include "host_tools/fit/fewest_frames.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "host_tools/fit/control_curve.hpp"

namespace inbetween {
namespace {

/// The time of a segment is the sum of what each of so many parts takes at least. Fewer give a bound that is
/// proven too, and lower; the time that the bound takes grows with them.
constexpr int stretches_per_segment = 64;
/// A turn smaller than this share of the largest position of an axis counts as rounding: the axis goes on.
constexpr double turn_rounding = 1e-9;
/// The bound is lowered by this share for the rounding of its sums.
constexpr double sum_rounding = 1e-9;
/// A distance is shortened by this share of its ends for their rounding.
constexpr double position_rounding = 1e-15;
/// A stretch is too short if more than this share of its frames is missing: a lock is met within 1e-12 of the
/// length of the path.
constexpr double lock_rounding = 1e-6;

/// The distance between two positions, never longer than the true one.
double min_distance_between(double begin, double end) {
  const double rounding = position_rounding * (std::fabs(begin) + std::fabs(end));
  return std::max(std::fabs(end - begin) - rounding, 0.0);
}

/// A part of the path, and whether the motion rests at its ends.
struct PathPart {
  PathPoint begin, end;
  bool begins_at_rest = false;
  bool ends_at_rest = false;
};

/// visit(segment, t where it begins, t where it ends) for every segment of a part.
template <class Visit>
void for_each_segment(const Path& path, const PathPart& part, const Visit& visit) {
  const std::int32_t last = std::min(part.end.segment, path.segment_count() - 1);
  for (std::int32_t i = part.begin.segment; i <= last; ++i) {
    const double begin = i == part.begin.segment ? part.begin.t : 0;
    const double end = i == part.end.segment ? part.end.t : 1;
    if (begin < end) visit(i, begin, end);
  }
}

/// An axis at a place s of the path, segment + t.
struct AxisPlace {
  double s = 0;
  double position = 0;
};

/// The places where one axis turns round on its part of the path, and the first and the last: its extremes at
/// the ends. One place of an axis that stays where it is.
class TurningPoints {
 public:
  TurningPoints(const Path& path, const PathPart& part, std::size_t axis) {
    for_each_segment(path, part, [&](std::int32_t segment, double begin, double end) {
      const Cubic& cubic = path.segment(segment)[axis];
      visit(segment, cubic, begin);
      visit_extremes(segment, cubic, begin, end);
      visit(segment, cubic, end);
    });
    drop_rounding();
  }
  [[nodiscard]] std::span<const AxisPlace> places() const { return places_; }

 private:
  void visit(std::int32_t segment, const Cubic& cubic, double t) {
    visited_.push_back({segment + t, cubic.value(t)});
  }
  void visit_extremes(std::int32_t segment, const Cubic& cubic, double begin, double end) {
    // P' = c1 + 2 c2 t + 3 c3 t^2
    const double root = std::sqrt(std::max(cubic.c2 * cubic.c2 - 3 * cubic.c1 * cubic.c3, 0.0));
    const double larger = -(cubic.c2 + std::copysign(root, cubic.c2));
    std::vector<double> turns;
    if (cubic.c3 != 0) turns.push_back(larger / (3 * cubic.c3));
    if (larger != 0) turns.push_back(cubic.c1 / larger);
    std::ranges::sort(turns);
    for (const double t : turns) {
      if (t > begin && t < end) visit(segment, cubic, t);
    }
  }
  /// Keeps every extreme from which the axis comes back by more than rounding, and those at the ends.
  void drop_rounding() {
    if (visited_.empty()) return;
    double largest = 0;
    for (const AxisPlace& place : visited_) largest = std::max(largest, std::fabs(place.position));
    const double rounding = turn_rounding * largest;
    AxisPlace lowest = visited_.front();
    AxisPlace highest = visited_.front();
    int direction = 0;
    for (const AxisPlace& place : visited_) {
      if (place.position > highest.position) highest = place;
      if (place.position < lowest.position) lowest = place;
      const bool has_risen = direction <= 0 && place.position - lowest.position > rounding;
      const bool has_fallen = direction >= 0 && highest.position - place.position > rounding;
      if (has_risen || has_fallen) {
        places_.push_back(has_risen ? lowest : highest);
        direction = has_risen ? 1 : -1;
        lowest = highest = place;
      }
    }
    places_.push_back(direction < 0 ? lowest : highest);
  }

  std::vector<AxisPlace> visited_;
  std::vector<AxisPlace> places_;
};

/// The time that an axis takes on its part, alone and as quickly as its limits allow: it is at rest where it
/// turns, and where the part begins or ends at rest.
class AxisTime {
 public:
  AxisTime(const Path& path, const PathPart& part, std::size_t axis, const RigAxis& limits)
      : turns_(path, part, axis), part_(part), limits_(limits) {}

  struct Seconds {
    double needed = 0;
    double by_velocity = 0;  ///< from max_velocity alone
  };
  /// Stretches are passed in the order of the path. One in which the axis turns counts with its velocity
  /// alone.
  [[nodiscard]] Seconds pass(const AxisPlace& from, const AxisPlace& to) {
    const double distance = min_distance_between(from.position, to.position);
    const double by_velocity = distance / limits_.max_velocity;
    Seconds seconds{by_velocity, by_velocity};
    const std::span<const AxisPlace> places = turns_.places();
    while (run_ + 2 < places.size() && places[run_ + 1].s <= from.s) ++run_;
    if (run_ + 1 >= places.size()) return seconds;
    const AxisPlace& begin = places[run_];
    const AxisPlace& end = places[run_ + 1];
    if (!(distance > 0) || from.s < begin.s || to.s > end.s) return seconds;
    const double rounding = position_rounding * (std::fabs(begin.position) + std::fabs(end.position));
    const double passed = from.s > begin.s ? std::fabs(from.position - begin.position) + rounding : 0;
    const double left = to.s < end.s ? std::fabs(end.position - to.position) + rounding : 0;
    seconds.needed = std::max(seconds.needed, between_rests(passed, distance, left));
    return seconds;
  }

 private:
  /// `distance`, of which `passed` lies behind since the last rest and `left` ahead to the next one.
  [[nodiscard]] double between_rests(double passed, double distance, double left) const {
    const bool has_last = run_ > 0 || part_.begins_at_rest;
    const bool has_next = run_ + 2 < turns_.places().size() || part_.ends_at_rest;
    // The nearer of the rests limits the velocity.
    const double half = (left + distance - passed) / 2;
    const double rising = !has_last ? 0 : !has_next ? distance : std::clamp(half, 0.0, distance);
    const double falling = has_next ? distance - rising : 0;
    const auto ramp = [&](double from, double more) {
      return more > 0 ? seconds_from_rest(from + more, limits_) - seconds_from_rest(from, limits_) : 0.0;
    };
    return ramp(passed, rising) + ramp(left, falling);
  }

  TurningPoints turns_;
  PathPart part_;
  RigAxis limits_;
  std::size_t run_ = 0;  ///< the last turn that was passed
};

/// The time that one track needs for its path or a part of it, in seconds.
class TrackTime {
 public:
  TrackTime(const Plan& plan, std::size_t index)
      : track_(plan.tracks()[index].track()), whole_{{0, 0}, {track_.path().segment_count(), 0}} {
    axes_.resize(static_cast<std::size_t>(track_.path().axis_count()));
    for (std::size_t a = 0; a < plan.axes().size(); ++a) {
      if (plan.axes()[a].track == index) axes_[plan.axes()[a].track_axis] = {a, &plan.rig()->axes[a]};
    }
    // A periodic curve has no ends at which two zeros would be a rest.
    if (!track_.has_profile() || plan.move().tracks[index].periodic) return;
    const std::vector<bool> rests = rests_of(plan.tracks()[index].control_values());
    whole_.begins_at_rest = rests.front();
    whole_.ends_at_rest = rests.back();
  }

  struct Bound {
    double seconds = 0;
    std::size_t axis = 0;
    bool by_acceleration = false;
  };
  [[nodiscard]] const PathPart& whole() const { return whole_; }
  [[nodiscard]] Bound bound(const PathPart& part) const {
    const Path& path = track_.path();
    std::vector<AxisTime> times;
    for (std::size_t d = 0; d < axes_.size(); ++d) times.emplace_back(path, part, d, *axes_[d].limits);
    std::vector<double> share(axes_.size());
    double seconds = 0;
    double by_velocity = 0;
    for_each_segment(path, part, [&](std::int32_t segment, double from, double to) {
      for (int k = 0; k < stretches_per_segment; ++k) {
        const double begin = from + (to - from) * k / stretches_per_segment;
        const double end = from + (to - from) * (k + 1) / stretches_per_segment;
        AxisTime::Seconds longest;
        std::size_t slowest = 0;
        for (std::size_t d = 0; d < axes_.size(); ++d) {
          const Cubic& cubic = path.segment(segment)[d];
          const AxisTime::Seconds one =
              times[d].pass({segment + begin, cubic.value(begin)}, {segment + end, cubic.value(end)});
          // All axes move together, so the slowest axis decides. Its share tells which axis to name.
          if (one.needed > longest.needed) slowest = d;
          longest = {std::max(longest.needed, one.needed), std::max(longest.by_velocity, one.by_velocity)};
        }
        seconds += longest.needed;
        by_velocity += longest.by_velocity;
        share[slowest] += longest.needed;
      }
    });
    const auto slowest = static_cast<std::size_t>(std::ranges::max_element(share) - share.begin());
    return {seconds, axes_[slowest].index, seconds > by_velocity * (1 + sum_rounding)};
  }

 private:
  struct Axis {
    std::size_t index = 0;
    const RigAxis* limits = nullptr;
  };

  const Track& track_;
  std::vector<Axis> axes_;
  PathPart whole_;
};

}  // namespace

double seconds_from_rest(double distance, const RigAxis& limits) {
  const double v = limits.max_velocity;
  const double a = limits.max_acceleration;
  return distance < v * v / (2 * a) ? std::sqrt(2 * distance / a) : distance / v + v / (2 * a);
}

FewestFrames fewest_frames(const Plan& plan) {
  FewestFrames fewest;
  const double fps = plan.move().fps.rate.frames_per_second();
  for (std::size_t t = 0; t < plan.tracks().size(); ++t) {
    const TrackTime time(plan, t);
    const TrackTime::Bound bound = time.bound(time.whole());
    const double frames = std::ceil(bound.seconds * fps * (1 - sum_rounding));
    if (!(frames > fewest.frames)) continue;
    const bool is_countable = frames < max_frames;
    fewest = {is_countable ? static_cast<std::int32_t>(frames) : max_frames, bound.axis,
              bound.by_acceleration};
  }
  return fewest;
}

std::vector<Meeting> meetings_of(const Plan& plan, std::size_t track) {
  const PathPart whole = TrackTime(plan, track).whole();
  const MoveTrack& file = plan.move().tracks[track];
  const std::int32_t frames = plan.move().frames;
  std::vector<Meeting> meetings;
  for (const KeyLock& lock : plan.tracks()[track].key_timing()->locks) {
    const bool is_end = lock.frame == 0 || lock.frame + lock.hold == frames;
    const bool has_frame = lock.key >= 0 && static_cast<std::size_t>(lock.key) < file.keys.size() &&
                           file.keys[static_cast<std::size_t>(lock.key)].frame;
    if (is_end || has_frame)
      meetings.push_back({lock.key, lock.frame, lock.hold, lock.hold > 0 || lock.ease});
  }
  if (whole.begins_at_rest) meetings.front().rests = true;
  if (whole.ends_at_rest) meetings.back().rests = true;
  return meetings;
}

std::optional<ShortStretch> shortest_stretch(const Plan& plan, std::size_t track) {
  if (!plan.tracks()[track].key_timing()) return std::nullopt;
  const TrackTime time(plan, track);
  const std::vector<Meeting> meetings = meetings_of(plan, track);
  const double fps = plan.move().fps.rate.frames_per_second();
  std::optional<ShortStretch> shortest;
  double missing = lock_rounding;
  for (std::size_t i = 0; i + 1 < meetings.size(); ++i) {
    const Meeting& one = meetings[i];
    const Meeting& next = meetings[i + 1];
    const std::int32_t left = one.frame + one.hold;
    const Track& solved = plan.tracks()[track].track();
    const TrackTime::Bound bound =
        time.bound({solved.locate({left, 0}), solved.locate({next.frame, 0}), one.rests, next.rests});
    const double frames = bound.seconds * fps;
    const double missing_here = frames / (next.frame - left) - 1;
    if (!(missing_here > missing)) continue;
    missing = missing_here;
    shortest = {one.key, next.key, left, next.frame, frames, bound.axis, bound.by_acceleration};
  }
  return shortest;
}

}  // namespace inbetween
