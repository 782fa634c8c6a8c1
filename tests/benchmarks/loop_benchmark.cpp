#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host_tools/check/planned_stops.hpp"
#include "host_tools/loop/loop_storage.hpp"
#include "inbetween/can/cia402_port.hpp"
#include "sim/cia402_drive.hpp"
#include "sim/simulated_link.hpp"
#include "sim/simulated_rig.hpp"
#include "tests/support/drive_frames.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/simulated_lines.hpp"

/// The whole tick of a rig on CAN: what the drives have told is read and judged, the playhead goes on, and
/// the next setpoints are written as frames.

namespace inbetween {
namespace {

constexpr std::int32_t rate_hz = 250;
constexpr std::int64_t tick_ns = 4'000'000;
constexpr double counts_per_unit = 1000;

/// A bus with simulated drives until everything runs; then it gives back the same answers in every tick, and
/// costs nothing of its own.
class ReplayedLink {
 public:
  explicit ReplayedLink(SimulatedCanBus& bus) : simulated_(bus) {}
  void replay(const std::vector<can::Frame>& told) { told_ = told; }

  [[nodiscard]] bool is_up() const { return true; }
  std::size_t receive(std::span<can::Frame> in, std::int64_t now_ns) {
    if (told_.empty()) return simulated_.receive(in, now_ns);
    is_asked_ = !is_asked_;
    if (!is_asked_) return 0;
    std::ranges::copy(told_, in.begin());
    return told_.size();
  }
  std::size_t send(std::span<const can::Frame> out) {
    if (told_.empty()) return simulated_.send(out);
    benchmark::DoNotOptimize(out.data());
    return out.size();
  }
  std::size_t drain() { return simulated_.drain(); }

 private:
  SimulatedLink simulated_;
  std::vector<can::Frame> told_;
  bool is_asked_ = false;
};

/// So many axes move to and fro by a hundredth of a unit, which no drive's window for errors notices.
std::string move_text(std::size_t axes) {
  std::string names;
  std::vector<std::string> keys(8);
  for (std::size_t d = 0; d < axes; ++d) {
    names += fmt::format("{}\"a{}\"", d == 0 ? "" : ", ", d);
    for (std::size_t k = 0; k < keys.size(); ++k) {
      keys[k] += fmt::format("{}{}", d == 0 ? "" : ", ", 0.01 * static_cast<double>((k * (d + 3)) % 5) / 5);
    }
  }
  std::string text =
      fmt::format("name = \"m\"\nfps = 24\nframes = 2400\n[[track]]\naxes = [{}]\nkeys = [", names);
  for (const std::string& key : keys) text += fmt::format("{{ at = [{}] }},", key);
  return text + "]\nspeed = [0, 0, 10, 4, 10, 0, 0]\n";
}

std::string rig_of(std::size_t count) {
  std::vector<AxisText> axes;
  for (std::size_t d = 0; d < count; ++d) {
    axes.push_back({.name = fmt::format("a{}", d),
                    .min = -1,
                    .max = 1,
                    .max_velocity = 1,
                    .max_acceleration = 100,
                    .more = "max_jerk = 10000",
                    .drive = cia402_text(static_cast<int>(d) + 1, counts_per_unit)});
  }
  return rig_text(axes, {.rate_hz = rate_hz, .more = bus_can0});
}

class Rig {
 public:
  explicit Rig(std::size_t axes)
      : plan_(parse_move(move_text(axes), "move.toml"), parse_rig(rig_of(axes), "rig.toml"), {}),
        room_(axes, axes) {
    for (std::size_t d = 0; d < axes; ++d) {
      drive_of_.push_back(d);
      const can::NodeId node = can::NodeId::make(static_cast<std::int64_t>(d + 1)).value();
      hosts_.push_back(
          can::Cia402Drive::make({.setup = {.node = node, .host = host_id_}, .max_step_counts = 100})
              .value());
      drives_.emplace_back(SimulatedCia402Settings{.node = node, .position = 0}, 0);
      wire_.attach(drives_.back());
      axes_.push_back({0, d, counts_per_unit});
    }
    bus_.emplace(can::Cia402Bus::make(hosts_, {.host = host_id_}).value());
    targets_.resize(axes);
    known_.resize(axes);
    frames_.resize(can::frames_per_read(axes));
    lanes_.push_back({&*bus_, &link_, targets_, known_, frames_});
    port_.emplace(can::Cia402Port<ReplayedLink>::make(lanes_, axes_).value());
    loop_.emplace(*port_, lines_, room_.memory());
    if (!loop_->load({&plan_.motion(), &playhead_, drive_of_, plan_.limits(), 1.0 / rate_hz}) ||
        !loop_->post(SupervisorEvent::arm)) {
      throw std::runtime_error("not armed");
    }
    for (int i = 0; i < 5000 && loop_->state() != SupervisorState::ready; ++i) tick();
    playhead_.set_repeat(Repeat::ping_pong);
    if (!loop_->start(Direction::forward)) {
      throw std::runtime_error("not started");
    }
    std::vector<can::Frame> told;
    for (const can::Cia402Drive& host : hosts_) {
      told.push_back(can::feedback_frame(host.node(), {.statusword = 0x1237, .actual = 5, .mode = 8}));
      told.push_back(can::heartbeat_frame(host.node(), can::NmtState::operational));
    }
    link_.replay(told);
  }
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  void tick() {
    now_ns_ += tick_ns;
    loop_->tick(1, now_ns_);
  }
  [[nodiscard]] bool is_running() const { return loop_->state() == SupervisorState::running; }

 private:
  Plan plan_;
  PlannedStops stops_{plan_};
  Playhead playhead_{plan_.played(), *stops_.bounds(), rate_hz};
  std::vector<std::size_t> drive_of_;
  const can::NodeId host_id_ = can::NodeId::make(127).value();
  std::vector<can::Cia402Drive> hosts_;
  std::deque<SimulatedCia402Drive> drives_;
  SimulatedCanBus wire_;
  ReplayedLink link_{wire_};
  std::optional<can::Cia402Bus> bus_;
  std::vector<std::int32_t> targets_;
  std::vector<can::PortDrive> known_;
  std::vector<can::Frame> frames_;
  std::vector<can::Cia402Lane<ReplayedLink>> lanes_;
  std::vector<can::Cia402Axis> axes_;
  std::optional<can::Cia402Port<ReplayedLink>> port_;
  SimulatedLines lines_;
  LoopStorage room_;
  std::optional<MotionLoop<can::Cia402Port<ReplayedLink>, SimulatedLines>> loop_;
  std::int64_t now_ns_ = 0;
};

void loop_tick(benchmark::State& state) {
  Rig rig(static_cast<std::size_t>(state.range(0)));
  for ([[maybe_unused]] auto _ : state) rig.tick();
  if (!rig.is_running()) throw std::runtime_error("not running any more");
}
BENCHMARK(loop_tick)->Arg(3)->Arg(8);

}  // namespace
}  // namespace inbetween

BENCHMARK_MAIN();
