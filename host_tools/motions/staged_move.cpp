#include "host_tools/motions/staged_move.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "host_tools/check/check.hpp"
#include "host_tools/plan/move_rolls.hpp"
#include "host_tools/rig_model/rig_motors.hpp"

namespace inbetween {
namespace {

[[noreturn]] void refuse(const Plan& plan, const StopObstacle& obstacle, const char* what, double rate,
                         const char* remedy) {
  const std::size_t axis = plan.axis_of(static_cast<std::size_t>(obstacle.axis));
  throw LimitError(plan.place_of(axis),
                   fmt::format("axis {} could not be {} at frame {:.2f} from {:g} times the drawn speed; {}",
                               in_quotes(plan.axes()[axis].name), what, obstacle.frame, rate, remedy));
}

/// The rungs on which the rate rises and falls: the first for travels and exposures, the last for the highest
/// rate.
std::vector<PlannedStops> rungs_of(const Plan& plan, const PlannedStops& stops, double exposure_rate) {
  // A whole number of ticks is a little longer or shorter than what was asked for.
  constexpr double rounding = 1 + 1e-9;
  const double top = stops.bounds()->rate();
  const double first = std::max(StagedMove::travel_share * top, std::min(exposure_rate * rounding, top));
  std::vector<PlannedStops> rungs;
  rungs.push_back(stops.within_motion_limits(plan, first, false));
  if (rungs.front().obstacle()) {
    refuse(plan, *rungs.front().obstacle(), "sped up or slowed down within its motion limits", first,
           "expose longer, or give the move more frames");
  }
  for (const double share : {StagedMove::middle_share, 1.0}) {
    if (share * top > first) rungs.push_back(stops.within_motion_limits(plan, share * top, true));
  }
  return rungs;
}

std::vector<StopBounds> bounds_of(const std::vector<PlannedStops>& rungs) {
  std::vector<StopBounds> bounds;
  bounds.reserve(rungs.size());
  for (const PlannedStops& rung : rungs) bounds.push_back(*rung.bounds());
  return bounds;
}

}  // namespace

std::shared_ptr<const PlannedStops> StagedMove::stops_of(const Plan& plan, double rate) {
  auto stops = std::make_shared<const PlannedStops>(plan, rate);
  if (stops->obstacle()) refuse(plan, *stops->obstacle(), "stopped", rate, "use a lower rate");
  return stops;
}

StagedMove::StagedMove(const Plan& plan, std::shared_ptr<const PlannedStops> stops)
    : StagedMove(plan, std::move(stops), {.first_frame = plan.played().first_frame()}) {}

StagedMove::StagedMove(const Plan& plan, std::shared_ptr<const PlannedStops> stops, ShootStage shoot)
    : plan_(plan),
      stops_(std::move(stops)),
      shoot_(std::move(shoot)),
      rungs_(rungs_of(plan, *stops_, shoot_.exposure_rate)),
      rung_bounds_(bounds_of(rungs_)),
      playhead_(plan.played(), *stops_->bounds(), plan.rig()->rate_hz, rung_bounds_),
      is_still_(std::make_unique<bool[]>(plan.played().axis_count())) {
  for (std::size_t d = 0; d < plan.played().axis_count(); ++d) {
    drive_of_.push_back(plan.axis_of(d));
    counts_.push_back(count_of(plan.rig()->axes[plan.axis_of(d)]));
    loop_limits_.push_back(limits_of(slow_enough_everywhere(plan.rig()->axes[plan.axis_of(d)])));
    is_still_[d] = std::ranges::count(shoot_.still, plan.axes()[drive_of_[d]].name) > 0;
  }
  value_or_throw(playhead_.place_on(shoot_.first_frame));
  if (!shoot_.still.empty()) still_ = playhead_;
}

LoopSpec StagedMove::loop_spec() {
  LoopSpec spec{.move = &plan_.motion(),
                .playhead = &playhead_,
                .drive_of = drive_of_,
                .limits = loop_limits_,
                .tick_seconds = 1.0 / plan_.rig()->rate_hz};
  spec.counts = counts_;
  if (still_) {
    spec.still = &*still_;
    spec.is_still = {is_still_.get(), drive_of_.size()};
  }
  return spec;
}

void StagedMove::set_repeat(Repeat repeat) {
  const Status status = repeat == Repeat::loop ? can_loop(plan_.motion()) : Done{};
  if (status) return playhead_.set_repeat(repeat);
  const std::size_t axis = plan_.axis_of(static_cast<std::size_t>(std::max(status.error().axis, 0)));
  throw LimitError(plan_.place_of(axis), fmt::format("axis {}: {}; {}", in_quotes(plan_.axes()[axis].name),
                                                     status.error().what, status.error().remedy));
}

}  // namespace inbetween
