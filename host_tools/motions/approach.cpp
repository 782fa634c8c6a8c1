#include "host_tools/motions/approach.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/check/check_frames.hpp"
#include "inbetween/loop/motion_loop.hpp"

namespace inbetween {
namespace {

/// At rest at both ends, and even between.
const std::vector<double> even_speed{0, 0, 10, 10, 10, 10, 0, 0};

/// The fewest are found from any number.
constexpr std::int32_t any_frames = 96;

/// The same rig, slower; but a stop on the way is as quick as ever.
RigFile slowed(RigFile rig) {
  for (RigAxis& axis : rig.axes) {
    const AxisLimits<double> limits = limits_of(axis);
    axis.stop_acceleration = limits.stop_acceleration();
    axis.stop_jerk = limits.stop_jerk();
    axis.max_velocity *= approach_share;
    axis.max_acceleration *= approach_share;
    if (axis.max_jerk) *axis.max_jerk *= approach_share;
  }
  return rig;
}

std::vector<double> first_positions(const Plan& plan) {
  std::vector<double> first(plan.played().axis_count());
  plan.played().positions({plan.played().first_frame(), 0}, first);
  return first;
}

}  // namespace

std::optional<Plan> plan_approach(const Plan& plan, std::span<const double> actual) {
  const RigFile& rig = *plan.rig();
  const std::vector<double> first = first_positions(plan);
  MoveTrack track;
  track.keys.resize(2);
  for (std::size_t a = 0; a < plan.axes().size(); ++a) {
    if (!plan.axes()[a].track) continue;
    const RigAxis& axis = rig.axes[a];
    const double target = first[plan.axes()[a].move_axis];
    const double tolerance = start_tolerance(axis.max_acceleration, 1.0 / rig.rate_hz, count_of(axis.drive));
    if (std::fabs(target - actual[a]) <= tolerance) continue;
    if (actual[a] < axis.min || actual[a] > axis.max) {
      throw InputError(
          axis.place, fmt::format("axis {} stands at {} {}, outside its limits {}..{}; bring it "
                                  "back inside by hand",
                                  in_quotes(axis.name), actual[a], to_string(axis.unit), axis.min, axis.max));
    }
    track.axes.push_back(axis.name);
    track.axis_places.push_back(axis.place);
    track.keys.front().at.push_back(actual[a]);
    track.keys.back().at.push_back(target);
  }
  if (track.axes.empty()) return std::nullopt;
  for (MoveKey& key : track.keys) key.at_places.assign(track.axes.size(), {rig.path, 0, 0});
  track.speed = even_speed;
  track.speed_places.assign(even_speed.size(), {rig.path, 0, 0});
  const RigFile slow = slowed(rig);
  MoveFile move{.path = rig.path,
                .name = "to the start of " + plan.move().name,
                .fps = plan.move().fps,
                .frames = any_frames,
                .tracks = {std::move(track)},
                .frames_place = {rig.path, 0, 0},
                .fps_place = {rig.path, 0, 0}};
  const Plan tried(move, slow, {});
  const SmallestFrames fewest = smallest_frames(tried, check(tried), [](double, std::int32_t) {});
  if (!fewest.frames) {
    throw InputError({rig.path, 0, 0},
                     "no slow way leads from where the rig stands to where the move starts: " +
                         fewest.reason + "; take it there by hand");
  }
  move.frames = *fewest.frames;
  return Plan(std::move(move), slow, {});
}

std::string describe_approach(const Plan& approach) {
  const MoveTrack& track = approach.move().tracks.front();
  std::string words = "the rig is not where the move starts:";
  for (const PlanAxis& axis : approach.axes()) {
    if (!axis.track) continue;
    const auto [from, to] = told_apart(track.keys.front().at[axis.track_axis],
                                       track.keys.back().at[axis.track_axis], Digits::decimals, 3);
    words +=
        fmt::format("\n  {:<16}{:>12} -> {} {}", axis.name, from, to, axis.unit ? to_string(*axis.unit) : "");
  }
  return words + fmt::format("\nit goes there in {:.1f} s, at {:.0f} % of its limits at most",
                             approach.duration_s(), approach_share * 100);
}

}  // namespace inbetween
