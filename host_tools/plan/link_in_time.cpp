#include "host_tools/plan/link_in_time.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host_tools/joints/tip_deviation.hpp"
#include "host_tools/plan/bounded_move.hpp"
#include "host_tools/plan/solved_track.hpp"

namespace inbetween {
namespace {

/// Of the largest velocity or acceleration: a smaller step is rounding. With less a smooth motion is refused
/// for a step that nobody made.
constexpr double visible_step_share = 1e-6;
/// Of a position: what its rounding may make of it in a frame. What stands, or goes evenly, has no velocity
/// or no acceleration of which a share could be taken.
constexpr double rounding_share = 1e-9;

bool steps_between_ends(const BoundedMove& bounded, const Track& track) {
  const double rate = track.frame_rate().frames_per_second();
  return std::ranges::any_of(bounded.steps(), [&](const MoveStep& step) {
    const AxisPeaks& peaks = bounded.peaks()[step.axis];
    const double rounding =
        rounding_share * std::max(std::fabs(peaks.lowest.value), std::fabs(peaks.highest.value));
    const bool is_inside = step.frame > 0 && step.frame < track.frames();
    return is_inside &&
           (step.velocity > visible_step_share * peaks.velocity.value + rounding * rate ||
            step.acceleration > visible_step_share * peaks.acceleration.value + rounding * rate * rate);
  });
}

}  // namespace

TrackBounds bounds_of(const Track& track) {
  const std::span<const Track> alone(&track, 1);
  const BoundedMove bounded(value_or_throw(Move::make(alone, {})), alone);
  TrackBounds bounds{.peaks = bounded.peaks(), .steps = steps_between_ends(bounded, track)};
  for (const AxisPeaks& peak : bounds.peaks) {
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
    const AxisPeaks& peaks = bounds.peaks[by.axis];
    jets[c] = {std::max(std::fabs(peaks.lowest.value), std::fabs(peaks.highest.value)), peaks.velocity.value,
               peaks.acceleration.value, peaks.jerk.value, 0};
    steps_ = steps_ || bounds.steps;
  }
  const Jet position = position_jet(kinematics, link, jets);
  max_speed_ = position[1];
  max_jerk_ = position[3];
}

const LinkMotion& LinkInTime::motion(const FrameTime& time) {
  std::vector<AxisMotion> axes;
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

MovingPoint LinkInTime::at(const FrameTime& time) {
  const LinkMotion& found = motion(time);
  return {found.pose.position, found.velocity};
}

}  // namespace inbetween
