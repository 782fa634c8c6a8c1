#include "tests/support/played_take.hpp"

#include <fmt/format.h>

#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "host_tools/joints/kinematics.hpp"
#include "host_tools/takes/taken_motion.hpp"
#include "tests/support/places.hpp"

namespace inbetween {
namespace {

std::vector<double> commanded_at(const Plan& plan, const FrameTime& time, double held) {
  std::vector<double> played(plan.motion().axis_count());
  plan.motion().positions(time, played);
  std::vector<double> all;
  for (const PlanAxis& axis : plan.axes()) all.push_back(axis.track ? played[axis.move_axis] : held);
  return all;
}

}  // namespace

Take played_take(const Plan& plan, const PlayedTake& played) {
  Take take;
  take.number = played.number;
  take.move_name = plan.move().name;
  take.rate_hz = plan.rig()->rate_hz;
  take.frame_rate = plan.played().frame_rate();
  take.frames = plan.move().frames;
  take.part = plan.part();
  take.trajectory = bytes_of(plan.motion());
  for (std::size_t i = 0; i < plan.axes().size(); ++i) {
    const RigAxis& axis = plan.rig()->axes[i];
    const PlanAxis& of = plan.axes()[i];
    take.axes.push_back({axis.name, std::string(to_string(axis.unit)), 1e-9,
                         of.track ? std::optional(of.move_axis) : std::nullopt});
  }
  const FrameTime end{take.frames, 0};
  const std::int64_t ticks = last_tick(take.frames, take.frame_rate, take.rate_hz) + 1 + played.rest;
  const double later = played.phase * take.frame_rate.frames_per_second() / take.rate_hz;
  std::vector<double> told = commanded_at(plan, {0, 0}, played.held);
  for (std::int64_t k = 0; k < ticks; ++k) {
    FrameTime time = frame_time_of_tick(k, take.frame_rate, take.rate_hz);
    if (later != 0) time = moved_by(time, later);
    time = end < time ? end : time;
    TakeTick tick{.number = k, .state = SupervisorState::running, .time = time};
    for (std::size_t a = 0; a < told.size(); ++a) tick.actual.push_back(told[a] + played.error(k, a));
    take.ticks_of_take.push_back(std::move(tick));
    told = commanded_at(plan, time, played.held);
  }
  take.ticks = ticks;
  return take;
}

std::string record_of(const Take& take, const Plan& plan, double held) {
  std::string text = "tick,seconds,state,frame";
  for (const TakeAxis& axis : take.axes) text += "," + axis.name + "," + axis.name + " actual";
  text += '\n';
  for (const TakeTick& tick : take.ticks_of_take) {
    fmt::format_to(std::back_inserter(text), "{},{:.6f},running,{:.6f}", tick.number,
                   static_cast<double>(tick.number) / take.rate_hz,
                   tick.time.value().frame + tick.time.value().fraction);
    const std::vector<double> told = commanded_at(plan, *tick.time, held);
    for (std::size_t a = 0; a < told.size(); ++a)
      fmt::format_to(std::back_inserter(text), ",{},{}", told[a], tick.actual[a]);
    text += '\n';
  }
  return text;
}

RigMeasures measures_of(const Plan& plan) {
  return {*plan.rig(), plan.kinematics()};
}

Plan plan_of(const std::string& move, const std::string& rig) {
  return {parse_move(move, "move.toml"), parse_rig(rig, "rig.toml"), {}};
}

Plan plan_of_crane() {
  const RigFile rig = read_rig_file(in_checkout("examples/crane/rig.toml"));
  return {read_move_file(in_checkout("examples/crane/round_the_puppet.toml")),
          rig,
          {.kinematics = std::make_shared<const Kinematics>(read_kinematics(rig))}};
}

}  // namespace inbetween
