#include "host_tools/check/planned_stops.hpp"

#include <algorithm>

#include "host_tools/plan/move_rolls.hpp"

namespace inbetween {
namespace {

constexpr std::int64_t max_cells = 4096;
constexpr std::int64_t min_cells = 64;

std::size_t cell_count(const Plan& plan, double rate) {
  const std::int64_t frames = plan.played().last_frame() - plan.played().first_frame();
  const std::int64_t ticks =
      last_tick(static_cast<std::int32_t>(frames), plan.played().frame_rate(), plan.rig()->rate_hz);
  const auto longest = static_cast<std::int64_t>(static_cast<double>(ticks) / (2 * std::max(rate, 1.0)));
  const std::int64_t wanted = std::clamp(frames, min_cells, max_cells);
  return static_cast<std::size_t>(std::max<std::int64_t>(std::min(wanted, longest), 1));
}

std::vector<AxisLimits<double>> motion_limits_of(const Plan& plan) {
  std::vector<AxisLimits<double>> limits;
  for (std::size_t d = 0; d < plan.limits().size(); ++d) {
    RigAxis axis = plan.rig()->axes[plan.axis_of(d)];
    axis.stop_acceleration = axis.max_acceleration;
    axis.stop_jerk = axis.max_jerk;
    limits.push_back(limits_of(axis));
  }
  return limits;
}

}  // namespace

PlannedStops::PlannedStops(const Plan& plan, double rate)
    : PlannedStops(plan, {.move = plan.played(), .limits = plan.limits(), .rate = rate},
                   cell_count(plan, rate)) {}

PlannedStops PlannedStops::within_motion_limits(const Plan& plan, double rate, bool may_wait) const {
  const std::vector<AxisLimits<double>> limits = motion_limits_of(plan);
  return {plan,
          {.move = plan.played(), .limits = limits, .rate = rate, .within = &*bounds_, .may_wait = may_wait},
          cells_.size() - 1};
}

PlannedStops::PlannedStops(const Plan& plan, const StopRequest<double>& asked, std::size_t cells)
    : cells_(cells + 1), peaks_(plan.played().axis_count()) {
  std::vector<MotionTriple<double>> suprema((cells_.size() - 1) * peaks_.size());
  std::vector<AxisTurn<double>> turns(peaks_.size());
  std::vector<PeakSlack<double>> slack(peaks_.size());
  StopRequest<double> request = asked;
  request.tick_seconds = 1.0 / plan.rig()->rate_hz;
  const StopBoundsMemory<double> memory{.cells = cells_, .suprema = suprema, .slack = slack, .turns = turns};
  const auto bounds = StopBounds<double>::make(request, memory, peaks_);
  if (!bounds && bounds.error().code == ErrorCode::no_solution) {
    obstacle_ = value_or_throw(stop_obstacle(request, memory));
  } else {
    bounds_ = value_or_throw(bounds);
  }
}

}  // namespace inbetween
