#include "tests/support/sixteen_axes.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <vector>

#include "host_tools/loop/loop_preparations.hpp"
#include "host_tools/motions/run_checks.hpp"
#include "host_tools/takes/take_recorder.hpp"
#include "host_tools/takes/taken_motion.hpp"
#include "inbetween/loop/tick_time.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween::sixteen_axes {
namespace {

/// A bus takes two of them at 1 kHz.
std::string cia402_on(int bus, int node) {
  return fmt::format(R"(type = "cia402", bus = "can{}", node = {}, counts_per_unit = 1000)", bus, node);
}

void give_drive(AxisText& axis, int number) {
  if (number < 3) axis.drive = cia402_on(number == 0 ? 0 : 1, number + 1);
  if (number == 0) {
    axis.more = "ganged = [{ drive = { " + cia402_on(0, 4) + " }, offset = 2 }]\nmax_skew = 0.5\n";
  }
  if (number == 1) axis.more = "backlash = { play = 0.05, take_up_s = 0.2, approach = \"positive\" }\n";
  if (number >= 3 && number < 5) {
    axis.drive = fmt::format(
        R"(type = "odrive", bus = "can2", node = {}, turns_per_unit = 0.0125, firmware = "0.6")", number);
  }
  if (number >= 5 && number < 8) {
    axis.drive = fmt::format(R"(type = "step-dir", chip = "gpio", step = {}, dir = {}, steps_per_unit = 40)",
                             2 * number, 2 * number + 1);
  }
}

std::vector<double> start_of(const Plan& plan) {
  std::vector<double> start(axes);
  plan.motion().positions({0, 0}, start);
  return start;
}

}  // namespace

std::string rig_of(Drives drives) {
  std::vector<AxisText> texts;
  for (int i = 0; i < axes; ++i) {
    AxisText axis{.name = fmt::format("a{}", i),
                  .unit = "deg",
                  .max_acceleration = 1000,
                  .drive = R"(type = "pipe", path = "/dev/null", counts_per_unit = 1000)"};
    if (drives == Drives::of_every_kind) give_drive(axis, i);
    texts.push_back(axis);
  }
  std::string buses;
  if (drives == Drives::of_every_kind)
    buses = bus_can0 + "[bus.can1]\nbitrate = 1000000\n[bus.can2]\nbitrate = 1000000\n";
  return rig_text(texts, {.name = "sixteen", .rate_hz = rate_hz, .more = buses});
}

std::string move() {
  std::string names, there, back;
  for (int i = 0; i < axes; ++i) {
    const char* const comma = i == 0 ? "" : ", ";
    names += fmt::format("{}\"a{}\"", comma, i);
    back += fmt::format("{}{}", comma, 1 + 0.1 * i);
    there += fmt::format("{}{}", comma, 60.3 - 7.7 * i);
  }
  return fmt::format(
      "name = \"there and back\"\nfps = {}\nframes = {}\n[[track]]\naxes = [{}]\nkeys = [{{ at = [{}] }}, {{ "
      "at = [{}] }}, {{ at = [{}] }}]\nspeed = [0, 0, 10, 10, 0, 0]\ncorners = \"ease\"\n",
      fps, frames, names, back, there, back);
}

TickedLoop::TickedLoop()
    : plan_(parse_move(move(), "move.toml"), parse_rig(rig_of(Drives::ideal), "rig.toml"), {}),
      staged_(checked_move(plan_, 1, Repeat::loop)),
      hardware_(*plan_.rig(), start_of(plan_)),
      lines_(*plan_.rig(), hardware_),
      drives_(*plan_.rig(), hardware_),
      loop_(drives_, lines_, room_.memory()),
      transport_(loop_, *staged_, false) {
  start();
}

void TickedLoop::start() {
  Arming arming(loop_);
  if (!arming.begin()) throw std::runtime_error("not armed");
  while (!arming.is_over()) arming.tick(1, time_of_tick(++ticks_, rate_hz));
  if (!transport_.begin()) throw std::runtime_error("not started");
}

void TickedLoop::tick(LoopTrace& trace) {
  transport_.tick(1, time_of_tick(++ticks_, rate_hz));
  trace.take(loop_, &transport_);
}

Take TickedLoop::take() const {
  Take take;
  take.move_name = plan_.move().name;
  take.rig_name = plan_.rig()->name;
  take.rate_hz = rate_hz;
  take.frame_rate = plan_.played().frame_rate();
  take.frames = frames;
  take.is_repeated = true;
  for (const PlanAxis& axis : plan_.axes())
    take.axes.push_back(take_axis_of(plan_.rig()->axes[take.axes.size()], axis.move_axis));
  take.trajectory = bytes_of(plan_.motion());
  return take;
}

}  // namespace inbetween::sixteen_axes
