#include "host_tools/fit/fewest_frames.hpp"

#include <algorithm>
#include <cmath>
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

/// The way between two positions, never longer than the true one.
double way_between(double begin, double end) {
  const double rounding = position_rounding * (std::fabs(begin) + std::fabs(end));
  return std::max(std::fabs(end - begin) - rounding, 0.0);
}

/// The places where one axis turns round, and the ends: its positions there.
class TurningPoints {
 public:
  TurningPoints(const Path<double>& path, std::size_t axis) {
    for (std::int32_t i = 0; i < path.segment_count(); ++i) {
      const Cubic<double>& cubic = path.segment(i)[axis];
      visit(cubic.value(0));
      visit_extremes(cubic);
      visit(cubic.value(1));
    }
    drop_rounding();
  }
  [[nodiscard]] std::span<const double> positions() const { return positions_; }

 private:
  void visit(double position) { visited_.push_back(position); }
  void visit_extremes(const Cubic<double>& cubic) {
    // P' = c1 + 2 c2 t + 3 c3 t^2
    const double root = std::sqrt(std::max(cubic.c2 * cubic.c2 - 3 * cubic.c1 * cubic.c3, 0.0));
    const double larger = -(cubic.c2 + std::copysign(root, cubic.c2));
    std::vector<double> places;
    if (cubic.c3 != 0) places.push_back(larger / (3 * cubic.c3));
    if (larger != 0) places.push_back(cubic.c1 / larger);
    std::ranges::sort(places);
    for (const double t : places) {
      if (t > 0 && t < 1) visit(cubic.value(t));
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

/// The time that one track needs, in seconds.
class TrackTime {
 public:
  TrackTime(const Plan& plan, std::size_t index) : track_(plan.tracks()[index].track()) {
    axes_.resize(static_cast<std::size_t>(track_.path().axis_count()));
    for (std::size_t a = 0; a < plan.axes().size(); ++a) {
      if (plan.axes()[a].track == index) axes_[plan.axes()[a].track_axis] = {a, &plan.rig()->axes[a]};
    }
    // A periodic curve has no ends at which two zeros would be a rest.
    if (!track_.has_profile() || plan.move().tracks[index].periodic) return;
    const std::vector<bool> rests = rests_of(plan.tracks()[index].control_values());
    begins_at_rest_ = rests.front();
    ends_at_rest_ = rests.back();
  }

  struct Bound {
    double seconds = 0;
    std::size_t axis = 0;
    bool by_acceleration = false;
  };
  [[nodiscard]] Bound bound() const {
    Bound slowest = by_velocity();
    for (std::size_t d = 0; d < axes_.size(); ++d) {
      const double seconds = by_acceleration(d);
      if (seconds > slowest.seconds * (1 + sum_rounding)) slowest = {seconds, axes_[d].index, true};
    }
    return slowest;
  }

 private:
  struct Axis {
    std::size_t index = 0;
    const RigAxis* limits = nullptr;
  };

  [[nodiscard]] Bound by_velocity() const {
    std::vector<double> share(axes_.size());
    double seconds = 0;
    for (std::int32_t i = 0; i < track_.path().segment_count(); ++i) {
      const std::span<const Cubic<double>> cubics = track_.path().segment(i);
      for (int k = 0; k < stretches_per_segment; ++k) {
        const double begin = static_cast<double>(k) / stretches_per_segment;
        const double end = static_cast<double>(k + 1) / stretches_per_segment;
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
    }
    const auto slowest = static_cast<std::size_t>(std::ranges::max_element(share) - share.begin());
    return {seconds, axes_[slowest].index, false};
  }

  [[nodiscard]] double by_acceleration(std::size_t axis) const {
    const TurningPoints turns(track_.path(), axis);
    const std::span<const double> places = turns.positions();
    double seconds = 0;
    for (std::size_t i = 0; i + 1 < places.size(); ++i) {
      const bool first = i == 0;
      const bool last = i + 2 == places.size();
      const int rests = (first && !begins_at_rest_ ? 0 : 1) + (last && !ends_at_rest_ ? 0 : 1);
      seconds += quickest(way_between(places[i], places[i + 1]), *axes_[axis].limits, rests);
    }
    return seconds;
  }

  const Track<double>& track_;
  std::vector<Axis> axes_;
  bool begins_at_rest_ = false;
  bool ends_at_rest_ = false;
};

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
    const TrackTime::Bound bound = TrackTime(plan, t).bound();
    const double frames = std::ceil(bound.seconds * fps * (1 - sum_rounding));
    if (!(frames > fewest.frames)) continue;
    const bool is_countable = frames < max_frames;
    fewest = {is_countable ? static_cast<std::int32_t>(frames) : max_frames, bound.axis,
              bound.by_acceleration};
  }
  return fewest;
}

}  // namespace inbetween
