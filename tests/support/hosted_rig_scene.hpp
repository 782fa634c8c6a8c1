// A simulated rig that a host drives, on a virtual clock, everything in one thread; and a scripted host of
// each of Dragonframe's protocols at it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "host_tools/dragonframe/dfmoco_device.hpp"
#include "host_tools/dragonframe/dmc_device.hpp"
#include "host_tools/hosted/hosted_rig.hpp"
#include "host_tools/loop/loop_preparations.hpp"
#include "host_tools/loop/loop_storage.hpp"
#include "host_tools/motions/free_axes.hpp"
#include "host_tools/plan/move_rolls.hpp"
#include "host_tools/rig/simulated_hardware.hpp"
#include "host_tools/rig_model/rig_motors.hpp"
#include "inbetween/loop/tick_time.hpp"
#include "tests/support/oracle_dfmoco_host.hpp"
#include "tests/support/oracle_dmc_host.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {

/// Of every rig in here.
inline constexpr double host_steps_per_deg = 1000;

/// So many axes of -180 to 180 deg, 1000 steps a degree, at 250 Hz.
inline std::string hosted_rig_text(std::size_t axes, const LimitsText& limits = {
                                                         .velocity = 60, .acceleration = 240, .jerk = 6000}) {
  std::vector<AxisText> texts;
  std::string steps;
  for (std::size_t a = 0; a < axes; ++a) {
    const std::string name = "axis" + std::to_string(a + 1);
    texts.push_back(axis_text(name, "deg", {-180, 180}, limits, R"(reference = "operator")",
                              R"(type = "pipe", path = "/dev/null", counts_per_unit = 10000)"));
    steps += (a > 0 ? ", " : "") + name + " = 1000";
  }
  return rig_text(texts, {.rate_hz = 250, .more = "[dragonframe]\nsteps_per_unit = { " + steps + " }\n"});
}

/// A ramp of S form and a wave on it, from rest to rest, in steps.
inline std::vector<std::int32_t> host_wave(std::size_t frames, double height_deg, double waves) {
  std::vector<std::int32_t> steps;
  for (std::size_t k = 0; k < frames; ++k) {
    const double u = static_cast<double>(k) / static_cast<double>(frames - 1);
    const double smooth = u * u * u * (10 - 15 * u + 6 * u * u);
    const double bump = 16 * u * u * (1 - u) * (1 - u) * std::sin(2 * std::numbers::pi * waves * u);
    steps.push_back(
        static_cast<std::int32_t>(std::lround(host_steps_per_deg * height_deg * (smooth + 0.2 * bump))));
  }
  return steps;
}

/// At a constant speed, which a move in the middle of a take has.
inline std::vector<std::int32_t> host_ramp(std::size_t frames, std::int32_t per_frame) {
  std::vector<std::int32_t> steps;
  for (std::size_t k = 0; k < frames; ++k) steps.push_back(static_cast<std::int32_t>(k) * per_frame);
  return steps;
}

/// One tick of the loop: where every axis was told to be, where the rig's own drive is, which outputs are on.
struct HostedTick {
  std::vector<Setpoint> axes{};
  std::vector<double> drives{};
  std::uint32_t outputs = 0;
};

/// The rig, its loop, and the motions in it; who is at the port is below.
class HostedRigScene {
 public:
  explicit HostedRigScene(const std::string& rig_text, double share = 1)
      : rig(parse_rig(rig_text, "rig.toml")),
        hardware(rig, std::vector<double>(rig.axes.size())),
        lines(rig, hardware),
        drives(rig, hardware),
        room(rig.axes.size(), rig.axes.size()),
        loop(drives, lines, room.memory()) {
    Arming arming(loop);
    static_cast<void>(arming.begin());
    while (!arming.is_over()) arming.tick(1, next_ns());
    std::vector<FreeAxis> free;
    std::vector<AxisLimits> limits;
    for (const RigAxis& axis : rig.axes) {
      free.push_back(free_axis_of(axis, free_limits_of(axis, share), 0, 1.0 / rig.rate_hz));
      limits.push_back(limits_of(slow_enough_everywhere(axis)));
    }
    outputs = LevelOutputs::open(rig, hardware);
    motion = std::make_unique<HostedMotion>(loop, std::move(free), std::move(limits), 1.0 / rig.rate_hz,
                                            outputs.get());
    HostedRigOptions options{.share = share};
    options.about_to_move = [this](std::span<const std::size_t> axes) { marks += axes.size(); };
    options.keep = [this](const std::vector<DriveState>&) { ++keeps; };
    hosted = std::make_unique<HostedRig>(rig, *motion, options);
    if (!motion->begin()) throw std::runtime_error("the motion does not begin");
    tick_loop();
    hosted->look();
  }
  HostedRigScene(const HostedRigScene&) = delete;
  HostedRigScene& operator=(const HostedRigScene&) = delete;
  virtual ~HostedRigScene() = default;

  void tick() {
    tick_loop();
    serve();
  }
  /// The last thing that the person at the terminal was told.
  [[nodiscard]] std::string last_words() const { return words.empty() ? "" : words.back(); }
  void run_for(double seconds) {
    for (std::int64_t left = std::llround(seconds * rig.rate_hz); left > 0; --left) tick();
  }
  /// As a host polls STATUS. Throws after so many seconds of the rig's time.
  void run_until_still(double seconds = 200) {
    for (std::int64_t left = std::llround(seconds * rig.rate_hz); left > 0; --left) {
      tick();
      if (hosted->state().moving == 0) return;
    }
    throw std::runtime_error("the rig does not come to rest");
  }
  [[nodiscard]] double position(std::size_t axis) const { return path.back().axes[axis].position; }
  [[nodiscard]] std::int32_t steps(std::size_t axis) const { return hosted->state().positions.at(axis); }
  /// Where the rig's own drive went, in steps, by what it was told in a tick of the record; it is there when
  /// the next one begins. Between ticks it is a cubic with the velocities of the setpoints.
  [[nodiscard]] double recorded_steps(std::size_t axis, double ticks) const {
    const auto tick = static_cast<std::size_t>(std::floor(ticks));
    const double u = ticks - std::floor(ticks);
    const double from = path.at(tick + 1).drives[axis];
    if (u == 0) return from * host_steps_per_deg;
    const double to = path.at(tick + 2).drives[axis];
    const double tick_s = 1.0 / rig.rate_hz;
    const double v0 = path[tick].axes[axis].velocity * tick_s;
    const double v1 = path[tick + 1].axes[axis].velocity * tick_s;
    const double cubic =
        from + u * (v0 + u * ((3 * (to - from) - 2 * v0 - v1) + u * (2 * (from - to) + v0 + v1)));
    return cubic * host_steps_per_deg;
  }

  RigFile rig;
  SimulatedHardware hardware;
  RigInputs lines;
  RigDrives drives;
  LoopStorage room;
  RunLoop loop;
  std::unique_ptr<LevelOutputs> outputs;
  std::unique_ptr<HostedMotion> motion;
  std::unique_ptr<HostedRig> hosted;
  std::int64_t now_ns = 0;
  std::vector<HostedTick> path;
  std::vector<std::string> words;
  std::size_t marks = 0;
  int keeps = 0;

 protected:
  /// What is between the rig and its host, behind a tick.
  virtual void serve() = 0;
  void gather_words() {
    for (std::string& line : hosted->take_words()) words.push_back(std::move(line));
  }
  /// What the rig has told goes to a device.
  void tell(auto& device) {
    hosted->look();
    device.observe(hosted->state(), now_ns);
    while (const auto event = hosted->take_event()) device.tell(*event, now_ns);
  }

 private:
  std::int64_t next_ns() { return now_ns = time_of_tick(++ticks_, rig.rate_hz); }
  void tick_loop() {
    motion->tick(1, next_ns());
    HostedTick tick{.axes = {loop.setpoints().begin(), loop.setpoints().end()}};
    for (std::size_t a = 0; a < rig.axes.size(); ++a) tick.drives.push_back(hardware.true_position(a));
    if (outputs) tick.outputs = outputs->bits();
    path.push_back(std::move(tick));
  }
  std::int64_t ticks_ = 0;
};

/// DMC.
class HostedScene final : public HostedRigScene {
 public:
  explicit HostedScene(const std::string& rig_text, double share = 1)
      : HostedRigScene(rig_text, share),
        device({.motors = static_cast<std::uint8_t>(rig.axes.size()),
                .outputs = static_cast<std::uint8_t>(output_count(rig))},
               [this](const dragonframe::RigOrder& order) { return hosted->take(order); }) {
    device.connect(now_ns);
    pass();
  }

  /// The code of its acknowledgement, 0 where data answered it. It is answered once.
  unsigned ask(const oracle::DmcBytes& request) {
    device.hear(request, now_ns);
    pass();
    if (host.answers() != 1) throw std::runtime_error("a request is answered once");
    return host.code();
  }
  void run_until(dragonframe::DmcStage stage, double seconds = 200) {
    for (std::int64_t left = std::llround(seconds * rig.rate_hz); left > 0; --left) {
      if (device.stage() == stage) return;
      tick();
    }
    throw std::runtime_error("the stage is not reached");
  }
  /// Messages that came without being asked for.
  [[nodiscard]] std::size_t pushed(unsigned type) const {
    std::size_t count = 0;
    for (const oracle::DmcHeard& message : heard) count += message.id == 0 && message.type == type ? 1U : 0U;
    return count;
  }
  /// Every motor with all its positions, in blocks of 200. The code of the first that is not OK, or 0x10.
  unsigned upload(std::int32_t start, const std::vector<std::vector<std::int32_t>>& motors) {
    const auto end = start + static_cast<std::int32_t>(motors.front().size()) - 1;
    for (unsigned m = 1; m <= motors.size(); ++m) {
      if (const unsigned code = ask(host.configure(m, 0x03)); code != 0x10) return code;
    }
    if (const unsigned code = ask(host.upload_begin(start, end)); code != 0x10) return code;
    constexpr std::size_t block = 200;
    for (unsigned m = 1; m <= motors.size(); ++m) {
      const std::vector<std::int32_t>& all = motors[m - 1];
      for (std::size_t first = 0; first < all.size(); first += block) {
        const auto from = all.begin() + static_cast<std::ptrdiff_t>(first);
        const auto to = all.begin() + static_cast<std::ptrdiff_t>(std::min(first + block, all.size()));
        const unsigned code =
            ask(host.upload_axis(m, static_cast<std::uint32_t>(first), to == all.end(), {from, to}));
        if (code != 0x10) return code;
      }
    }
    return ask(host.upload_end());
  }
  /// With consent, and as fast as the rig may be: the motors stand on frame 1 of a move that is theirs. False
  /// where something of that was refused.
  [[nodiscard]] bool stand_on_first_frame(const std::vector<std::vector<std::int32_t>>& motors) {
    if (!device.arm()) return false;
    for (unsigned m = 1; m <= motors.size(); ++m) {
      if (ask(host.speed(m, 60'000, 200'000)) != 0x10) return false;
    }
    if (upload(1, motors) != 0x10 || ask(host.position_frame(1)) != 0x10) return false;
    run_until_still();
    return true;
  }
  /// A run or a shot is prepared. The tick of the record that is the one of GO.
  std::size_t go() {
    run_until(dragonframe::DmcStage::wait);
    if (ask(host.go()) != 0x10) throw std::runtime_error("GO is refused");
    return path.size() - 1;
  }

  dragonframe::DmcDevice device;
  oracle::DmcHost host;
  std::vector<oracle::DmcHeard> heard;

 private:
  void serve() override {
    tell(device);
    pass();
  }
  void pass() {
    host.hear(device.take_bytes());
    for (oracle::DmcHeard& message : host.take_heard()) heard.push_back(std::move(message));
    gather_words();
  }
};

/// DFMoco.
class HostedDfmocoScene final : public HostedRigScene {
 public:
  explicit HostedDfmocoScene(const std::string& rig_text, double share = 1)
      : HostedRigScene(rig_text, share),
        device(static_cast<std::uint8_t>(rig.axes.size()),
               [this](const dragonframe::RigOrder& order) { return hosted->take(order); }) {
    device.connect(now_ns);
    read();
  }

  /// What the device says to a line; what it has said before is in `told`.
  std::vector<std::string> ask(const std::string& line) {
    read();
    device.hear(oracle::dfmoco_bytes(line), now_ns);
    host.hear(device.take_text());
    gather_words();
    return host.take_lines();
  }

  dragonframe::DfmocoDevice device;
  oracle::DfmocoHost host;
  std::vector<std::string> told;

 private:
  void serve() override {
    tell(device);
    read();
  }
  void read() {
    host.hear(device.take_text());
    for (std::string& line : host.take_lines()) told.push_back(std::move(line));
    gather_words();
  }
};

}  // namespace inbetween
