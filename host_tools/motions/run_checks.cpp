#include "host_tools/motions/run_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "host_tools/check/check.hpp"
#include "host_tools/rig_model/rig_motors.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "inbetween/loop/motion_loop.hpp"

namespace inbetween {
namespace {

void refuse_beyond_highest_rate(const Plan& plan, const CheckReport& report, double top_rate) {
  if (top_rate <= std::max(report.highest_rate, 1.0)) return;
  throw LimitError(
      plan.move().frames_place,
      fmt::format("at {:g} times the drawn speed the move leaves the limits of the rig; lower --top-rate to "
                  "{:.3f} or less",
                  top_rate, std::floor(report.highest_rate * 1000) / 1000));
}

void refuse_positions_beyond_limits(const Plan& plan) {
  const Move& move = plan.played();
  const PlayedMotion& motion = plan.motion();
  const std::int64_t last = move.last_tick_at(plan.rig()->rate_hz);
  std::vector<double> positions(move.axis_count());
  for (std::int64_t tick = 0; tick <= last; ++tick) {
    const FrameTime when = move.time_of_tick(tick, plan.rig()->rate_hz);
    motion.positions(when, positions);
    for (std::size_t d = 0; d < positions.size(); ++d) {
      if (positions[d] >= plan.limits()[d].min() && positions[d] <= plan.limits()[d].max()) continue;
      const std::size_t a = plan.axis_of(d);
      const RigAxis& axis = plan.rig()->axes[a];
      const double rounding = position_rounding(axis.min, axis.max);
      if (positions[d] >= axis.min - rounding && positions[d] <= axis.max + rounding) continue;
      const double limit = positions[d] < axis.min ? axis.min : axis.max;
      throw LimitError(
          plan.place_of(a),
          fmt::format("axis {} would go to {} {} at frame {:.2f}, outside {} of the rig {}; move its keys "
                      "inward",
                      in_quotes(axis.name), told_apart(positions[d], limit, Digits::significant, 6).first,
                      to_string(axis.unit), when.frame + when.fraction, range_in_words(axis),
                      in_quotes(plan.rig()->name)));
    }
  }
}

/// At so many times the drawn speed every axis goes as slowly as in a transit.
double slow_rate_of(const CheckReport& report) {
  constexpr double min_slow_rate = 0.01;
  double share = 0;
  for (const CheckedAxis& axis : report.axes) share = std::max(share, axis.velocity.share());
  return share > transit_share ? std::max(transit_share / share, min_slow_rate) : 1;
}

}  // namespace

std::unique_ptr<StagedMove> checked_move(const Plan& plan, double top_rate, Repeat repeat) {
  const CheckReport checked = check(plan);
  refuse_beyond_limits(checked);
  refuse_positions_beyond_limits(plan);
  refuse_beyond_highest_rate(plan, checked, top_rate);
  auto staged = std::make_unique<StagedMove>(
      plan, top_rate == 1 ? checked.planned_stops : StagedMove::stops_of(plan, top_rate));
  staged->set_repeat(repeat);
  staged->go_slowly(slow_rate_of(checked));
  return staged;
}

std::vector<GoTarget> away_from_start(const Plan& plan, std::span<const double> actual,
                                      const std::optional<FrameTime>& start,
                                      const std::string& as_arguments) {
  const RigFile& rig = *plan.rig();
  std::vector<double> first(plan.played().axis_count());
  plan.motion().positions(start.value_or(FrameTime{plan.played().first_frame(), 0}), first);
  std::vector<GoTarget> away;
  for (std::size_t a = 0; a < plan.axes().size(); ++a) {
    if (!plan.axes()[a].track) continue;
    const RigAxis& axis = rig.axes[a];
    const double target = first[plan.axes()[a].move_axis];
    const double tolerance =
        start_tolerance(slow_enough_everywhere(axis).max_acceleration, 1.0 / rig.rate_hz, count_of(axis));
    if (std::fabs(target - actual[a]) <= tolerance) continue;
    if (actual[a] < axis.min || actual[a] > axis.max) {
      throw InputError(axis.place,
                       fmt::format("{} stands at {:.10g} {}, outside its limits {}; {}", named(axis),
                                   actual[a], to_string(axis.unit), range_in_words(axis),
                                   remedy_outside(rig, a, actual[a], as_arguments)));
    }
    away.push_back({.axis = a, .position = target});
  }
  return away;
}

void refuse_unagreed_transit(const Plan& plan, std::size_t axis, bool can_be_agreed) {
  if (can_be_agreed) return;
  throw InputError({plan.move().path, 0, 0},
                   fmt::format("{} of the rig is not where the move starts; bring it there, or agree to let "
                               "it go there slowly (--yes)",
                               named(plan.rig()->axes[axis])));
}

}  // namespace inbetween
