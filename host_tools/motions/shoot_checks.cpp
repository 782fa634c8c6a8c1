#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/motions/run_checks.hpp"
#include "host_tools/reference/axis_positions.hpp"

namespace inbetween {
namespace {

/// A place so near to a whole frame, in frames, is that frame.
constexpr double whole_frame_rounding = 1e-9;

/// How many times the drawn speed; 0 where the rig rests meanwhile.
double exposure_rate(const ShootOptions& shoot, const Plan& plan) {
  if (!shoot.shutter) return 0;
  return (shoot.shutter->close - shoot.shutter->open) /
         (plan.played().frame_rate().frames_per_second() * shoot.exposure_s);
}

/// Stops from every place that the shoot may pass at up to `rate` times the drawn speed. At a rate at which
/// the motion keeps its limits a stop may still find none left, and less is tried.
std::shared_ptr<const PlannedStops> stops_up_to(const Plan& plan, double rate, const CheckReport& report) {
  constexpr double less = 0.7;
  constexpr int max_tries = 20;
  if (rate == 1 && !report.planned_stops->obstacle()) return report.planned_stops;
  for (int i = 0; i < max_tries; ++i, rate *= less) {
    auto stops = std::make_shared<const PlannedStops>(plan, rate);
    if (!stops->obstacle()) return stops;
  }
  return StagedMove::stops_of(plan, rate);  // says why
}

FrameTime place_on_time_line(double frame) {
  const double whole = std::round(frame);
  if (std::fabs(frame - whole) <= whole_frame_rounding) return {static_cast<std::int32_t>(whole), 0};
  return moved_by({0, 0.0}, frame);
}

/// Where the motion steps in a way that no axis may follow at `rate` times the drawn speed, and at the ends
/// of a move that is moving there without a roll.
std::vector<FrameTime> rests_of(const Plan& plan, const CheckReport& report, double rate) {
  std::vector<FrameTime> rests;
  for (const CheckedStep& step : report.steps) {
    CheckedStep slower = step;
    slower.acceleration *= rate * rate;
    if (step.velocity > 0 || breaks_jerk_limit(slower, plan.rig()->axes[step.axis])) {
      rests.push_back(place_on_time_line(step.frame));
    }
  }
  for (const RollObstacle& end : plan.roll_obstacles()) {
    rests.push_back({end.end == RollEnd::before ? 0 : plan.move().frames, 0});
  }
  std::ranges::sort(rests, [](const auto& a, const auto& b) { return a < b; });
  rests.erase(std::unique(rests.begin(), rests.end()), rests.end());
  return rests;
}

void refuse_fast_exposure(const Plan& plan, double needed, double top, const ShootOptions& shoot) {
  // A whole number of ticks is a little longer or shorter than what was asked for.
  constexpr double rounding = 1 + 1e-9;
  if (needed <= top * rounding) return;
  const double seconds = std::ceil(shoot.exposure_s * needed / top * 1000) / 1000;
  throw LimitError(
      plan.move().frames_place,
      fmt::format("frame {} cannot be exposed in motion: in {:g} s the rig would go at {:.4g} "
                  "times the drawn speed, and its limits hold up to {:.4g} times; expose longer, "
                  "{:g} s at least",
                  shot_frames(plan.move(), shoot).first, shoot.exposure_s, needed, top, seconds));
}

void refuse_exposures(StagedMove& staged, const ShootOptions& options) {
  const MoveFile& move = staged.plan().move();
  const WholeFrames due = shot_frames(move, options);
  std::vector<std::int32_t> shots(static_cast<std::size_t>(due.last - due.first) + 1);
  const ShootFrames frames{.last = move.frames, .first = due.first, .shots = shots, .rests = staged.rests()};
  const ShootSpec spec = shoot_spec(options, *staged.plan().rig());
  const Status possible = FrameShoot(spec, frames, staged.playhead(), nullptr).check();
  if (possible) return;
  throw LimitError(move.frames_place,
                   fmt::format("frame {} cannot be exposed in motion: {}; {}", possible.error().frame,
                               possible.error().what, possible.error().remedy));
}

}  // namespace

std::unique_ptr<StagedMove> checked_shoot(const Plan& plan, double top_rate, const ShootOptions& shoot) {
  static_cast<void>(shot_frames(plan.move(), shoot));
  for (const std::string& axis : shoot.still) static_cast<void>(axis_named(*plan.rig(), axis));
  const CheckReport report = check(plan);
  for (const CheckRefusal& refusal : report.refusals) {
    if (refusal.at_any_rate) throw LimitError(refusal.place, refusal.message());
  }
  const double top = std::min(top_rate, report.highest_rate_between_steps);
  const auto stops = stops_up_to(plan, top, report);
  const double needed = exposure_rate(shoot, plan);
  refuse_fast_exposure(plan, needed, stops->bounds()->rate(), shoot);
  auto staged =
      std::make_unique<StagedMove>(plan, stops,
                                   ShootStage{.exposure_rate = needed,
                                              .still = shoot.still,
                                              .first_frame = first_frame_of(plan.move(), shoot),
                                              .rests = rests_of(plan, report, stops->bounds()->rate())});
  refuse_exposures(*staged, shoot);
  return staged;
}

}  // namespace inbetween
