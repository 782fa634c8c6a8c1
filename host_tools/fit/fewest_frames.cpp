#include "host_tools/fit/fewest_frames.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "host_tools/fit/control_curve.hpp"

namespace inbetween {
namespace {

constexpr int stretches_per_segment = 64;
/// A turn smaller than this share of the largest position of an axis counts as rounding: the axis goes on.
constexpr double turn_rounding = 1e-9;
/// The bound is lowered by this share for the rounding of its sums.
constexpr double sum_rounding = 1e-9;
/// A way is shortened by this share of its ends for their rounding.
constexpr double position_rounding = 1e-15;
/// A stretch is too short if more than this share of its frames is missing: a lock is met within 1e-12 of the
/// length of the path.
constexpr double lock_rounding = 1e-6;

/// The way between two positions, never longer than the true one.
double way_between(double begin, double end) {
  const double rounding = position_rounding * (std::fabs(begin) + std::fabs(end));
  return std::max(std::fabs(end - begin) - rounding, 0.0);
}

/// A part of the path, and whether the motion rests at its ends.
struct Way {
  PathPoint<double> begin, end;
  bool begins_at_rest = false;
  bool ends_at_rest = false;
};

/// visit(cubics of the segment, t where it begins, t where it ends) for every segment of a way.
template <class Visit>
void for_each_segment(const Path<double>& path, const Way& way, const Visit& visit) {
  const std::int32_t last = std::min(way.end.segment, path.segment_count() - 1);
  for (std::int32_t i = way.begin.segment; i <= last; ++i) {
    const double begin = i == way.begin.segment ? way.begin.t : 0;
    const double end = i == way.end.segment ? way.end.t : 1;
    if (begin < end) visit(path.segment(i), begin, end);
  }
}

/// The places where one axis turns round on its way, and the ends: its positions there.
class TurningPoints {
 public:
  TurningPoints(const Path<double>& path, const Way& way, std::size_t axis) {
    for_each_segment(path, way, [&](std::span<const Cubic<double>> cubics, double begin, double end) {
      visit(cubics[axis].value(begin));
      visit_extremes(cubics[axis], begin, end);
      visit(cubics[axis].value(end));
    });
    drop_rounding();
  }
  [[nodiscard]] std::span<const double> positions() const { return positions_; }

 private:
  void visit(double position) { visited_.push_back(position); }
  void visit_extremes(const Cubic<double>& cubic, double begin, double end) {
    // P' = c1 + 2 c2 t + 3 c3 t^2
    const double root = std::sqrt(std::max(cubic.c2 * cubic.c2 - 3 * cubic.c1 * cubic.c3, 0.0));
    const double larger = -(cubic.c2 + std::copysign(root, cubic.c2));
    std::vector<double> places;
    if (cubic.c3 != 0) places.push_back(larger / (3 * cubic.c3));
    if (larger != 0) places.push_back(cubic.c1 / larger);
    std::ranges::sort(places);
    for (const double t : places) {
      if (t > begin && t < end) visit(cubic.value(t));
    }
  }
  /// Keeps the first, the last and every extreme from which the axis comes back by more than rounding.
  void drop_rounding() {
    double largest = 0;
    for (const double position : visited_) largest = std::max(largest, std::fabs(position));
    const double rounding = turn_rounding * largest;
    if (visited_.empty()) return;
    positions_.push_back(visited_.front());
    double extreme = visited_.front();
    double direction = 0;
    for (const double position : visited_) {
      const bool goes_on = direction * (position - extreme) >= 0;
      if (direction == 0) {
        extreme = position;
        if (std::fabs(position - positions_.front()) > rounding) direction = position - positions_.front();
      } else if (goes_on) {
        extreme = position;
      } else if (std::fabs(position - extreme) > rounding) {
        positions_.push_back(extreme);
        direction = position - extreme;
        extreme = position;
      }
    }
    positions_.push_back(visited_.back());
  }

  std::vector<double> visited_;
  std::vector<double> positions_;
};

/// The time that one track needs for its way or a part of it, in seconds.
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
  [[nodiscard]] const Way& whole() const { return whole_; }
  [[nodiscard]] Bound bound(const Way& way) const {
    Bound slowest = by_velocity(way);
    for (std::size_t d = 0; d < axes_.size(); ++d) {
      const double seconds = by_acceleration(way, d);
      if (seconds > slowest.seconds * (1 + sum_rounding)) slowest = {seconds, axes_[d].index, true};
    }
    return slowest;
  }

 private:
  struct Axis {
    std::size_t index = 0;
    const RigAxis* limits = nullptr;
  };

  [[nodiscard]] Bound by_velocity(const Way& way) const {
    std::vector<double> share(axes_.size());
    double seconds = 0;
    for_each_segment(track_.path(), way, [&](std::span<const Cubic<double>> cubics, double from, double to) {
      for (int k = 0; k < stretches_per_segment; ++k) {
        const double begin = from + (to - from) * k / stretches_per_segment;
        const double end = from + (to - from) * (k + 1) / stretches_per_segment;
        std::size_t slowest = 0;
        double longest = 0;
        for (std::size_t d = 0; d < axes_.size(); ++d) {
          const double time =
              way_between(cubics[d].value(begin), cubics[d].value(end)) / axes_[d].limits->max_velocity;
          // All axes move together, so the slowest axis decides. Its share tells which axis to name.
          if (time > longest) slowest = d;
          longest = std::max(longest, time);
        }
        seconds += longest;
        share[slowest] += longest;
      }
    });
    const auto slowest = static_cast<std::size_t>(std::ranges::max_element(share) - share.begin());
    return {seconds, axes_[slowest].index, false};
  }

  [[nodiscard]] double by_acceleration(const Way& way, std::size_t axis) const {
    const TurningPoints turns(track_.path(), way, axis);
    const std::span<const double> places = turns.positions();
    double seconds = 0;
    for (std::size_t i = 0; i + 1 < places.size(); ++i) {
      const bool first = i == 0;
      const bool last = i + 2 == places.size();
      const int rests = (first && !way.begins_at_rest ? 0 : 1) + (last && !way.ends_at_rest ? 0 : 1);
      seconds += quickest(way_between(places[i], places[i + 1]), *axes_[axis].limits, rests);
    }
    return seconds;
  }

  const Track<double>& track_;
  std::vector<Axis> axes_;
  Way whole_;
};

/// A frame on which the move has to be at a place of its path, from which it goes on `hold` frames later.
struct Meeting {
  std::int32_t key = 0;
  std::int32_t frame = 0;
  std::int32_t hold = 0;
  bool rests = false;
};

/// The keys of a track that have a frame, and its ends.
std::vector<Meeting> meetings_of(const Plan& plan, std::size_t index, const Way& whole) {
  const MoveTrack& file = plan.move().tracks[index];
  const std::int32_t frames = plan.move().frames;
  std::vector<Meeting> meetings;
  for (const KeyLock& lock : plan.tracks()[index].key_timing()->locks) {
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

}  // namespace

double quickest(double distance, const RigAxis& limits, int ends_at_rest) {
  const double v = limits.max_velocity;
  const double a = limits.max_acceleration;
  const double ramp = v * v / (2 * a);
  if (ends_at_rest == 0) return distance / v;
  // The way is too short to reach full velocity.
  if (distance <= ends_at_rest * ramp) {
    return ends_at_rest == 1 ? std::sqrt(2 * distance / a) : 2 * std::sqrt(distance / a);
  }
  return distance / v + ends_at_rest * v / (2 * a);
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

std::optional<ShortStretch> shortest_stretch(const Plan& plan, std::size_t track) {
  if (!plan.tracks()[track].key_timing()) return std::nullopt;
  const TrackTime time(plan, track);
  const std::vector<Meeting> meetings = meetings_of(plan, track, time.whole());
  const double fps = plan.move().fps.rate.frames_per_second();
  std::optional<ShortStretch> shortest;
  double missing = lock_rounding;
  for (std::size_t i = 0; i + 1 < meetings.size(); ++i) {
    const Meeting& one = meetings[i];
    const Meeting& next = meetings[i + 1];
    const std::int32_t left = one.frame + one.hold;
    const Track<double>& solved = plan.tracks()[track].track();
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
