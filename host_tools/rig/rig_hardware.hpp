// A rig stands on buses, GPIO chips and drives. The machine has them, and so has a simulation.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "drivers/can/socket_can.hpp"
#include "drivers/gpio/step_player.hpp"
#include "host_tools/rig/counters.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/text/loop_log.hpp"
#include "inbetween/can/cia402_homing.hpp"
#include "inbetween/can/fd_frame.hpp"
#include "inbetween/can/frame.hpp"
#include "inbetween/homing/line_event.hpp"
#include "inbetween/loop/ports.hpp"
#include "inbetween/loop/tick_time.hpp"
#include "inbetween/steps/edge_instant.hpp"
#include "inbetween/steps/step_merge.hpp"

namespace inbetween {

/// How long before its time the motion of a tick is written: a tick, and never less than the thread of a chip
/// needs to notice it.
inline std::int64_t played_lead_ns(const RigFile& rig) {
  return std::max(ns_per_s / rig.rate_hz, gpio::StepPlayerSettings{}.nap_ns + 2 * rig.step_watch_ns);
}

/// A bus of a rig with such frames (can::FrameLink).
template <class Frame>
class BusLink {
 public:
  virtual ~BusLink() = default;
  [[nodiscard]] virtual bool is_up() const = 0;
  virtual std::size_t receive(std::span<Frame> in, std::int64_t now_ns) = 0;
  virtual std::size_t send(std::span<const Frame> out) = 0;
  virtual std::size_t drain() = 0;
  /// Null where no interface counts.
  [[nodiscard]] virtual const can::CanCounters* counters() const { return nullptr; }
};

/// Output lines of one chip, which change at planned times (StepSink).
class ChipOutputs {
 public:
  virtual ~ChipOutputs() = default;
  virtual bool push(const EdgeInstant& instant) = 0;
  virtual void discard() = 0;
  [[nodiscard]] virtual std::uint64_t waiting() const = 0;
  [[nodiscard]] virtual bool has_ended() const = 0;
  [[nodiscard]] bool is_too_late() const { return too_late_us().has_value(); }

  /// By how much an instant was late, if that exceeded its limit.
  [[nodiscard]] virtual std::optional<double> too_late_us() const { return std::nullopt; }
  /// Takes the oldest instant that was played. Only lines of pulses tell them.
  virtual std::optional<gpio::PlayedInstant> take_played() { return std::nullopt; }
  /// Empty where no player counts.
  [[nodiscard]] virtual std::vector<Count> counts() const { return {}; }
};

/// The counters of the chips that count. Each has a label and its outputs.
template <class Chips>
std::vector<Counted> counts_of_chips(const Chips& chips) {
  std::vector<Counted> counts;
  for (const auto& chip : chips) {
    if (auto counted = chip.outputs->counts(); !counted.empty()) {
      counts.push_back({chip.label, std::move(counted)});
    }
  }
  return counts;
}

/// Input lines of one chip.
class ChipInputs {
 public:
  virtual ~ChipInputs() = default;
  /// Takes the edges that have come, by the number of the line on this chip. They last until the next call.
  virtual std::span<const LineEvent> read(std::int64_t now_ns) = 0;
  /// The level that the last read found, or the last that is known.
  [[nodiscard]] virtual bool level(std::size_t line) const = 0;
  [[nodiscard]] virtual bool has_gone() const { return false; }
};

/// Some drives of a rig under the motion loop (DrivePort), numbered among themselves.
class AxisDrives {
 public:
  virtual ~AxisDrives() = default;
  virtual void read(std::span<DriveState> states, std::int64_t now_ns) = 0;
  virtual void write(std::span<const Setpoint> setpoints, std::int64_t now_ns) = 0;
  virtual void enable() = 0;
  virtual void disable() = 0;
  virtual void quick_stop() = 0;
  /// StopsOne. A drive that only takes setpoints knows no other stop.
  virtual void stop_one(std::size_t /*drive*/, OwnStop /*how*/) {}
  /// Whether they can be switched on, and whether they may: drives of all protocols wait for each other.
  [[nodiscard]] virtual bool is_set_up() const { return true; }
  virtual void let_switch_on(bool /*may*/) {}
  /// RigDrives::place.
  virtual void place(std::size_t drive, double position) = 0;
  /// The position that the drive counts, in the unit of its motor, where the motor is at 0. Nothing where no
  /// drive tells its place, or this one has not told it since it was placed.
  [[nodiscard]] virtual std::optional<double> zero(std::size_t /*drive*/) const { return {}; }
  /// Its motor is at 0 where the drive counts this. Only before it is switched on.
  virtual void set_zero(std::size_t /*drive*/, double /*zero*/) {}
  /// RigDrives::homing.
  [[nodiscard]] virtual can::Cia402Homing* homing(std::size_t /*drive*/) const { return nullptr; }
  [[nodiscard]] virtual bool has_lost_position(std::size_t /*drive*/) const { return false; }
  /// RigDrives::trouble and RigDrives::counts, of these.
  [[nodiscard]] virtual std::string trouble() const { return ""; }
  virtual void count(Counters& /*counts*/) const {}

  // Of drives on buses. Each says the first thing that is wrong, with a bus or with a drive, and what to do;
  // "" if nothing is.
  [[nodiscard]] virtual std::string bus_trouble() const { return ""; }
  [[nodiscard]] virtual std::string drive_trouble() const { return ""; }
  /// What drives that are set up do without, a line each, with what stands in for it.
  [[nodiscard]] virtual std::vector<std::string> notes() const { return {}; }
  /// RigDrives::left_on.
  [[nodiscard]] virtual std::string left_on() const { return ""; }
};

/// The drives behind a DrivePort.
template <DrivePort Port>
class PortDrives : public AxisDrives {
 public:
  void read(std::span<DriveState> states, std::int64_t now_ns) override { port_->read(states, now_ns); }
  void write(std::span<const Setpoint> setpoints, std::int64_t now_ns) override {
    port_->write(setpoints, now_ns);
  }
  void enable() override { port_->enable(); }
  void disable() override { port_->disable(); }
  void quick_stop() override { port_->quick_stop(); }
  [[nodiscard]] bool is_set_up() const override {
    if constexpr (requires { port_->is_set_up(); }) return port_->is_set_up();
    return true;
  }
  void let_switch_on(bool may) override {
    if constexpr (requires { port_->let_switch_on(may); }) port_->let_switch_on(may);
  }

 protected:
  std::optional<Port> port_;
};

/// An output of a rig.
struct PulseLine {
  std::string_view name;
  const OutputLine* wire = nullptr;
  const Place* place = nullptr;
};

/// Opens the parts of a rig, each once. Every function throws InputError at the place of what is not there or
/// not allowed; then nothing has changed. It outlives what it has opened.
class RigHardware {
 public:
  struct OpenedInputs {
    std::string label;
    std::vector<std::size_t> lines;  ///< of the lines asked for, in the order of the chip's numbers
    std::unique_ptr<ChipInputs> chip;
  };

  virtual ~RigHardware() = default;
  /// Brings what is simulated to `now_ns`. Call it once a tick, before anything is read.
  virtual void advance(std::int64_t /*now_ns*/) {}
  /// Ends the log of the edges that simulated steppers got, where there is one. Nothing is advanced after it.
  virtual std::optional<LoopLogEnd> end_step_log() { return std::nullopt; }
  /// `axes` of the rig have their drives on this bus; all speak the same protocol, whose frames these are.
  /// Asked once for each protocol on a bus.
  template <class Frame>
  std::unique_ptr<BusLink<Frame>> open_bus(const std::string& bus, std::span<const std::size_t> axes) {
    if constexpr (std::is_same_v<Frame, can::FdFrame>) {
      return open_fd_bus(bus, axes);
    } else {
      return open_classic_bus(bus, axes);
    }
  }
  /// `axes` of the rig have their steps on this chip. The lines are numbered as `wires` are, and the ENABLE
  /// lines follow.
  virtual std::unique_ptr<ChipOutputs> open_steps(const std::string& chip, std::span<const std::size_t> axes,
                                                  std::span<const StepLines> wires) = 0;
  /// The position from which the steps of an axis are counted.
  [[nodiscard]] virtual double counted_from(std::size_t /*axis*/) const { return 0; }
  /// The lines are idle until the first pulse, and 1 is active whatever the wire has then.
  virtual std::unique_ptr<ChipOutputs> open_pulses(const std::string& chip,
                                                   std::span<const PulseLine> lines) = 0;
  /// The chip of a line; whatever has the same name is the same chip.
  virtual std::string chip_of(const LineAddress& line) = 0;
  virtual std::vector<OpenedInputs> open_inputs(std::span<const InputLine* const> lines) = 0;
  /// `axes` of the rig have drives that are neither on a CAN bus nor step-dir.
  virtual std::unique_ptr<AxisDrives> open_others(std::span<const std::size_t> axes) = 0;

 private:
  virtual std::unique_ptr<BusLink<can::Frame>> open_classic_bus(const std::string& bus,
                                                                std::span<const std::size_t> axes) = 0;
  virtual std::unique_ptr<BusLink<can::FdFrame>> open_fd_bus(const std::string& bus,
                                                             std::span<const std::size_t> axes) = 0;
};

}  // namespace inbetween
