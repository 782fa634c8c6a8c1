#include "host_tools/plan/link_in_time.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host_tools/joints/tip_deviation.hpp"
#include "host_tools/plan/solved_track.hpp"
#include "inbetween/limits/motion_steps.hpp"

namespace inbetween {
namespace {

/// Of the largest velocity or acceleration: a smaller step is rounding.
constexpr double step_rounding = 1e-6;

bool steps_between_ends(const Track<double>& track, const std::vector<AxisPeaks<double>>& peaks) {
  std::vector<AxisStep<double>> steps(peaks.size());
  for (std::int32_t i = 1; i < track.path().segment_count(); ++i) {
    static_cast<void>(steps_at_key<double>(track, i, steps));
    for (std::size_t d = 0; d < steps.size(); ++d) {
      if (steps[d].velocity > step_rounding * peaks[d].velocity.value ||
          steps[d].acceleration > step_rounding * peaks[d].acceleration.value) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace

TrackBounds bounds_of(const Track<double>& track) {
  const auto axes = static_cast<std::size_t>(track.path().axis_count());
  TrackBounds bounds{.peaks = std::vector<AxisPeaks<double>>(axes)};
  if (track.path().segment_count() == 0) return bounds;
  std::vector<AxisTurn<double>> turns(axes);
  const std::vector<MotionTriple<double>> slack(axes, {1e-6, 1e-6, 1e-6});
  value_or_throw(bound_motion<double>(track, slack, {turns}, bounds.peaks));
  bounds.steps = steps_between_ends(track, bounds.peaks);
  for (const AxisPeaks<double>& peak : bounds.peaks) {
    bounds.steps = bounds.steps || !std::isfinite(peak.jerk.value);
  }
  return bounds;
}

LinkInTime::LinkInTime(const Kinematics& kinematics, std::int32_t link, std::vector<DrivenCoordinate> driven)
    : kinematics_(&kinematics),
      link_(link),
      driven_(std::move(driven)),
      coordinates_(driven_.size()),
      links_(kinematics.links().size()) {
  std::vector<Jet> jets(driven_.size());
  for (std::size_t c = 0; c < driven_.size(); ++c) {
    const DrivenCoordinate& by = driven_[c];
    if (by.track == nullptr) {
      jets[c][0] = std::fabs(by.held);
      continue;
    }
    const TrackBounds bounds = bounds_of(*by.track);
    const AxisPeaks<double>& peaks = bounds.peaks[by.axis];
    jets[c] = {std::max(std::fabs(peaks.lowest.value), std::fabs(peaks.highest.value)), peaks.velocity.value,
               peaks.acceleration.value, peaks.jerk.value, 0};
    steps_ = steps_ || bounds.steps;
  }
  const Jet position = position_jet(kinematics, link, jets);
  max_speed_ = position[1];
  max_jerk_ = position[3];
}

const LinkMotion<double>& LinkInTime::motion(const FrameTime<double>& time) {
  std::vector<AxisMotion<double>> axes;
  for (std::size_t c = 0; c < driven_.size(); ++c) {
    const DrivenCoordinate& by = driven_[c];
    coordinates_[c] = {by.held, 0, 0};
    if (by.track == nullptr) continue;
    axes.resize(static_cast<std::size_t>(by.track->path().axis_count()));
    by.track->motion(time, axes);
    coordinates_[c] = {axes[by.axis].position, axes[by.axis].velocity, axes[by.axis].acceleration};
  }
  value_or_throw(kinematics_->tree().motion(coordinates_, links_));
  return links_[static_cast<std::size_t>(link_)];
}

MovingPoint LinkInTime::at(const FrameTime<double>& time) {
  const LinkMotion<double>& found = motion(time);
  return {found.pose.position, found.velocity};
}

}  // namespace inbetween
