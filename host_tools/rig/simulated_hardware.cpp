#include "host_tools/rig/simulated_hardware.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <type_traits>
#include <utility>

#include "host_tools/rig/bus_kind.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "sim/simulated_link.hpp"
#include "sim/simulated_rig.hpp"

namespace inbetween {
namespace {

/// A simulated limit switch is so far beyond the limit, as a share of the axis' travel.
constexpr double limit_margin = 0.02;
/// Simulated switches open so far before they closed, as a share of the distance to back off.
constexpr double hysteresis_share = 0.25;

/// An axis that finds its switch at `fast` is behind it by less than this when it stands.
double overrun_of(const RigAxis& axis) {
  const double fast = axis.home->fast;
  const double ramp = axis.max_jerk ? axis.max_acceleration / *axis.max_jerk : 0;
  constexpr double seconds_until_known = 0.05;
  return fast * (fast / axis.max_acceleration + ramp + seconds_until_known);
}

/// The place of a simulated limit switch of an axis.
double limit_place(const RigAxis& axis, bool is_max) {
  const double margin = limit_margin * (axis.max - axis.min);
  double end = is_max ? axis.max : axis.min;
  if (axis.home && (axis.home->direction > 0) == is_max) {
    const double behind = axis.home->at + axis.home->direction * overrun_of(axis);
    end = is_max ? std::max(end, behind) : std::min(end, behind);
  }
  return is_max ? end + margin : end - margin;
}

template <class Frame>
class LinkInProcess final : public BusLink<Frame> {
 public:
  explicit LinkInProcess(SimulatedBus<Frame>& bus) : link_(bus) {}
  [[nodiscard]] bool is_up() const override { return link_.is_up(); }
  std::size_t receive(std::span<Frame> in, std::int64_t now_ns) override { return link_.receive(in, now_ns); }
  std::size_t send(std::span<const Frame> out) override { return link_.send(out); }
  std::size_t drain() override { return link_.drain(); }

 private:
  SimulatedLinkTo<Frame> link_;
};

class StepsInProcess final : public ChipOutputs {
 public:
  explicit StepsInProcess(SimulatedStepChip& chip) : chip_(chip) {}
  bool push(const EdgeInstant& instant) override { return chip_.push(instant); }
  void discard() override { chip_.discard(); }
  [[nodiscard]] std::uint64_t waiting() const override { return chip_.waiting(); }
  [[nodiscard]] bool has_ended() const override { return chip_.has_ended(); }

 private:
  SimulatedStepChip& chip_;
};

/// Everything is played in time, and at once.
class PulsesInProcess final : public ChipOutputs {
 public:
  bool push(const EdgeInstant& instant) override { return played_.push({.instant = instant}), true; }
  void discard() override {}
  [[nodiscard]] std::uint64_t waiting() const override { return 0; }
  [[nodiscard]] bool has_ended() const override { return false; }
  std::optional<gpio::PlayedInstant> take_played() override { return played_.pop(); }

 private:
  gpio::StepPlayer::PlayedRing played_;
};

class IdealDrives final : public PortDrives<SimulatedRig> {
 public:
  explicit IdealDrives(std::span<const double> positions) { port_.emplace(positions); }
  void place(std::size_t drive, double position) override { port_->place(drive, position); }
  [[nodiscard]] double true_position(std::size_t drive) const { return port_->true_position(drive); }
};

/// The switches follow the axes that have some before their lines are read.
class InputsInProcess final : public ChipInputs {
 public:
  using Where = std::function<std::optional<double>(std::size_t)>;
  InputsInProcess(SimulatedInputs& inputs, std::vector<std::size_t> axes, Where where)
      : inputs_(inputs), axes_(std::move(axes)), where_(std::move(where)) {}
  std::span<const LineEvent> read(std::int64_t now_ns) override {
    for (const std::size_t a : axes_) {
      if (const std::optional<double> at = where_(a)) inputs_.follow(a, *at, now_ns);
    }
    events_.clear();
    inputs_.take(events_);
    return events_;
  }
  [[nodiscard]] bool level(std::size_t line) const override { return inputs_.level(line); }

 private:
  SimulatedInputs& inputs_;
  std::vector<std::size_t> axes_;
  Where where_;
  std::vector<LineEvent> events_;
};

}  // namespace

void SimulatedHardware::log_steps(const std::string& file, bool waits) {
  const auto is_stepper = [](const RigAxis& axis) {
    return std::holds_alternative<StepDirDrive>(axis.drive);
  };
  if (std::ranges::none_of(rig_.axes, is_stepper)) {
    throw InputError({rig_.path, 0, 0},
                     fmt::format("the rig {} has no axis with a step-dir drive, and --steps writes what the "
                                 "lines of these did; leave out --steps",
                                 in_quotes(rig_.name)));
  }
  step_log_.emplace(file, motors_.rig.axes, waits);
}

/// The lines are low before the first instant, which may say so again: that is no edge.
void SimulatedHardware::log_edges_of(SimulatedStepChip& chip, std::vector<std::size_t> motors,
                                     std::vector<StepLines> lines) {
  chip.tell_played([this, &chip, motors = std::move(motors), lines = std::move(lines),
                    before = std::uint64_t{0}](const EdgeInstant& instant) mutable {
    const std::uint64_t changed = chip.levels() ^ std::exchange(before, chip.levels());
    for (std::size_t i = 0; i < motors.size(); ++i) {
      if ((changed >> lines[i].step & 1) == 0) continue;
      step_log_->take({.at_ns = instant.at_ns,
                       .motor = motors[i],
                       .step = (chip.levels() >> lines[i].step & 1) != 0,
                       .dir = (chip.levels() >> lines[i].dir & 1) != 0,
                       .steps = chip.stepper(i).count()});
    }
  });
}

std::optional<LoopLogEnd> SimulatedHardware::end_step_log() {
  return step_log_ ? std::optional(step_log_->finish()) : std::nullopt;
}

void SimulatedHardware::advance(std::int64_t now_ns) {
  faults_.advance(now_ns);
  for (SimulatedStepChip& chip : chips_) chip.run(now_ns);
}

template <class Frame>
std::unique_ptr<BusLink<Frame>> SimulatedHardware::simulate_bus(SimulatedBus<Frame>& wire,
                                                                std::span<const std::size_t> axes) {
  for (const std::size_t a : axes) {
    const RigAxis& axis = motors_.rig.axes[a];
    with_kind_of(axis, [&]<class Kind>() {
      if constexpr (std::is_same_v<typename Kind::Bus::Frame, Frame>) {
        auto drive = Kind::simulate(axis, {.position = positions_[a]});
        where_[a] = [its = drive.get(), scale = Kind::scale_of(axis)] { return its->position() / scale; };
        wire.attach(*drive);
        faults_.attach(a, *drive);
        drives_.push_back(std::move(drive));
      }
    });
  }
  return std::make_unique<LinkInProcess<Frame>>(wire);
}

std::unique_ptr<BusLink<can::Frame>> SimulatedHardware::open_classic_bus(const std::string& /*bus*/,
                                                                         std::span<const std::size_t> axes) {
  return simulate_bus(buses_.emplace_back(), axes);
}
std::unique_ptr<BusLink<can::FdFrame>> SimulatedHardware::open_fd_bus(const std::string& /*bus*/,
                                                                      std::span<const std::size_t> axes) {
  return simulate_bus(fd_buses_.emplace_back(), axes);
}

std::unique_ptr<ChipOutputs> SimulatedHardware::open_steps(const std::string& /*chip*/,
                                                           std::span<const std::size_t> axes,
                                                           std::span<const StepLines> wires) {
  SimulatedStepChip& chip = chips_.emplace_back();
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const RigAxis& axis = motors_.rig.axes[axes[i]];
    const SimulatedStepper::Settings settings{
        .lines = wires[i], .steps_per_unit = std::get<StepDirDrive>(axis.drive).steps_per_unit, .torque = {}};
    const std::size_t number = chip.add(
        value_or_refuse(SimulatedStepper::make(settings, positions_[axes[i]]), axis.place, named(axis)));
    where_[axes[i]] = [&chip, number] { return chip.stepper(number).position(); };
  }
  if (step_log_) log_edges_of(chip, {axes.begin(), axes.end()}, {wires.begin(), wires.end()});
  return std::make_unique<StepsInProcess>(chip);
}

std::unique_ptr<ChipOutputs> SimulatedHardware::open_pulses(const std::string& /*chip*/,
                                                            std::span<const PulseLine> /*lines*/) {
  return std::make_unique<PulsesInProcess>();
}

std::vector<RigHardware::OpenedInputs> SimulatedHardware::open_inputs(
    std::span<const InputLine* const> lines) {
  OpenedInputs opened;
  std::vector<std::size_t> with_switches;
  std::vector<bool> released;
  for (const InputLine* const line : lines) {
    opened.lines.push_back(released.size());
    released.push_back(line->active == Level::low);
  }
  inputs_.emplace(std::move(released), axis_positions_);
  for (std::size_t a = 0; a < rig_.axes.size(); ++a) {
    const RigAxis& axis = rig_.axes[a];
    const auto add_switch = [&](const InputLine& input, bool is_above, double closes) {
      const double opens_after = axis.home ? axis.home->back_off : limit_margin * (axis.max - axis.min);
      const auto line = std::ranges::find(lines, &input) - lines.begin();
      inputs_->add_switch(a, {.line = static_cast<std::uint8_t>(line),
                              .active_level = input.active == Level::high,
                              .is_above = is_above,
                              .closes = closes,
                              .hysteresis = hysteresis_share * opens_after});
    };
    if (axis.home) add_switch(axis.home->input, axis.home->direction > 0, axis.home->at);
    if (axis.limit_min) add_switch(*axis.limit_min, false, limit_place(axis, false));
    if (axis.limit_max) add_switch(*axis.limit_max, true, limit_place(axis, true));
    if (axis.home || axis.limit_min || axis.limit_max) with_switches.push_back(a);
  }
  opened.chip = std::make_unique<InputsInProcess>(*inputs_, std::move(with_switches), [this](std::size_t a) {
    return where_[a] ? std::optional(true_position(a)) : std::nullopt;
  });
  std::vector<OpenedInputs> all;
  if (!lines.empty()) all.push_back(std::move(opened));
  return all;
}

std::unique_ptr<AxisDrives> SimulatedHardware::open_others(std::span<const std::size_t> axes) {
  std::vector<double> at;
  for (const std::size_t a : axes) at.push_back(positions_[a]);
  auto drives = std::make_unique<IdealDrives>(at);
  for (std::size_t i = 0; i < axes.size(); ++i) {
    where_[axes[i]] = [ideal = drives.get(), i] { return ideal->true_position(i); };
  }
  return drives;
}

}  // namespace inbetween
