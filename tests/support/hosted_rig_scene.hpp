// A scripted host, a DMC device, and a simulated rig behind it on a virtual clock: everything in one thread.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host_tools/dragonframe/dmc_device.hpp"
#include "host_tools/hosted/hosted_rig.hpp"
#include "host_tools/loop/loop_preparations.hpp"
#include "host_tools/loop/loop_storage.hpp"
#include "host_tools/motions/free_axes.hpp"
#include "host_tools/plan/move_rolls.hpp"
#include "host_tools/rig/simulated_hardware.hpp"
#include "host_tools/rig_model/rig_motors.hpp"
#include "inbetween/loop/tick_time.hpp"
#include "tests/support/oracle_dmc_host.hpp"

namespace inbetween {

/// One tick of the loop, and where every axis was told to be.
struct HostedTick {
  std::vector<Setpoint> axes;
};

class HostedScene {
 public:
  explicit HostedScene(const std::string& rig_text, double share = 1)
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
    motion = std::make_unique<HostedMotion>(loop, std::move(free), std::move(limits), 1.0 / rig.rate_hz);
    HostedRigOptions options{.share = share};
    options.about_to_move = [this](std::span<const std::size_t> axes) { marks += axes.size(); };
    options.keep = [this](const std::vector<DriveState>&) { ++keeps; };
    hosted = std::make_unique<HostedRig>(rig, *motion, options);
    device.emplace(dragonframe::DmcFacts{.motors = static_cast<std::uint8_t>(rig.axes.size())},
                   [this](const dragonframe::RigOrder& order) { return hosted->take(order); });
    if (!motion->begin()) throw std::runtime_error("the motion does not begin");
    tick();
    device->connect(now_ns);
    pass();
  }
  HostedScene(const HostedScene&) = delete;
  HostedScene& operator=(const HostedScene&) = delete;
  ~HostedScene() = default;

  /// The code of its acknowledgement, 0 where data answered it. It is answered once.
  unsigned ask(const oracle::DmcBytes& request) {
    device->hear(request, now_ns);
    pass();
    if (host.answers() != 1) throw std::runtime_error("a request is answered once");
    return host.code();
  }
  void tick() {
    motion->tick(1, next_ns());
    path.push_back({{loop.setpoints().begin(), loop.setpoints().end()}});
    hosted->look();
    device->observe(hosted->state(), now_ns);
    while (const auto event = hosted->take_event()) device->tell(*event, now_ns);
    pass();
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
  void run_until(dragonframe::DmcStage stage, double seconds = 200) {
    for (std::int64_t left = std::llround(seconds * rig.rate_hz); left > 0; --left) {
      if (device->stage() == stage) return;
      tick();
    }
    throw std::runtime_error("the stage is not reached");
  }
  [[nodiscard]] double position(std::size_t axis) const { return path.back().axes[axis].position; }
  [[nodiscard]] std::int32_t steps(std::size_t axis) const { return hosted->state().positions.at(axis); }
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

  RigFile rig;
  SimulatedHardware hardware;
  RigInputs lines;
  RigDrives drives;
  LoopStorage room;
  RunLoop loop;
  std::unique_ptr<HostedMotion> motion;
  std::unique_ptr<HostedRig> hosted;
  std::optional<dragonframe::DmcDevice> device;
  oracle::DmcHost host;
  std::int64_t now_ns = 0;
  std::vector<HostedTick> path;
  std::vector<oracle::DmcHeard> heard;
  std::vector<std::string> words;
  std::size_t marks = 0;
  int keeps = 0;

 private:
  std::int64_t next_ns() { return now_ns = time_of_tick(++ticks_, rig.rate_hz); }
  void pass() {
    host.hear(device->take_bytes());
    for (oracle::DmcHeard& message : host.take_heard()) heard.push_back(std::move(message));
    for (std::string& line : hosted->take_words()) words.push_back(std::move(line));
  }
  std::int64_t ticks_ = 0;
};

}  // namespace inbetween
