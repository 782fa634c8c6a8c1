#include "host_tools/rig/machine_hardware.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <variant>

#include "drivers/gpio/gpio_chip.hpp"
#include "drivers/gpio/gpio_inputs.hpp"
#include "drivers/gpio/gpio_outputs.hpp"
#include "drivers/gpio/step_thread.hpp"
#include "drivers/linux/real_time.hpp"
#include "host_tools/rig/bus_kind.hpp"
#include "host_tools/rig/pipe_drives.hpp"
#include "inbetween/loop/tick_time.hpp"

namespace inbetween {
namespace {

gpio::LineChoice choice_of(const GpioLine& line) {
  if (const int* const offset = std::get_if<int>(&line)) return static_cast<unsigned>(*offset);
  return std::get<std::string>(line);
}

/// Throws InputError at the place of a line that no chip has.
void open_chip_of(const LineAddress& address, gpio::GpioChip& chip) {
  const auto refusal = address.chip.empty() ? chip.open_with_line(std::get<std::string>(address.line))
                                            : chip.open(address.chip);
  if (refusal) refuse_at(address.place, *refusal);
}

void add_drive(const RigAxis& axis, std::vector<LineAddress>& lines) {
  const auto* const drive = std::get_if<StepDirDrive>(&axis.drive);
  if (drive == nullptr) return;
  lines.push_back({drive->chip, drive->step, axis.place});
  lines.push_back({drive->chip, drive->dir, axis.place});
  if (drive->enable) lines.push_back({drive->chip, *drive->enable, axis.place});
}

std::vector<LineAddress> lines_of(const RigFile& rig) {
  std::vector<LineAddress> lines;
  const auto add = [&](const std::optional<InputLine>& input) {
    if (input) lines.push_back(input->address);
  };
  add(rig.emergency_stop);
  add(rig.start_trigger);
  for (const RigAxis& motor : motors_of(rig).rig.axes) add_drive(motor, lines);
  for (const RigAxis& axis : rig.axes) {
    if (axis.home) lines.push_back(axis.home->input.address);
    add(axis.limit_min);
    add(axis.limit_max);
  }
  for (const Output& output : rig.outputs) lines.push_back(output.line.address);
  if (rig.camera) {
    lines.push_back(rig.camera->shutter.address);
    add(rig.camera->asks);
  }
  return lines;
}

/// By chip and number, and where the rig names them.
using KnownLines = std::map<std::pair<std::string, unsigned>, Place>;

void refuse_unavailable_line(const LineAddress& line, KnownLines& known) {
  gpio::GpioChip chip;
  open_chip_of(line, chip);
  const gpio::LineChoice choice = choice_of(line.line);
  std::vector<unsigned> offset;
  if (const auto refusal = chip.find(std::span(&choice, 1), offset)) refuse_at(line.place, *refusal);
  const auto [other, is_new] = known.try_emplace({chip.label(), offset.front()}, line.place);
  if (is_new) return;
  throw InputError(line.place, fmt::format("line {} of chip {} is used in line {} already; give each line "
                                           "one use",
                                           offset.front(), in_quotes(chip.label()), other->second.line));
}

// In the order of Bias.
constexpr std::array biases = {gpio::Bias::pull_up, gpio::Bias::pull_down, gpio::Bias::none};

template <class Frame>
class SocketLink final : public BusLink<Frame> {
 public:
  SocketLink(const RigFile& rig, const std::string& bus, std::span<const can::CanFilter> filters) {
    open_bus_of(rig, bus, filters, socket_);
  }

  /// Once the link has gone or the controller was bus-off it stays down: nothing resumes by itself.
  [[nodiscard]] bool is_up() const override { return is_up_; }
  std::size_t receive(std::span<Frame> in, std::int64_t /*now_ns*/) override {
    const std::size_t count = socket_.receive(in);
    look_at_socket();
    return count;
  }
  std::size_t send(std::span<const Frame> out) override {
    if (!is_up_) return 0;
    const std::size_t count = socket_.send(out);
    look_at_socket();
    return count;
  }
  std::size_t drain() override { return socket_.drain().stale; }
  [[nodiscard]] const can::CanCounters* counters() const override { return &socket_.counters(); }

 private:
  void look_at_socket() {
    is_up_ = is_up_ && socket_.link() == can::LinkState::up &&
             socket_.controller() != can::ControllerState::bus_off;
  }

  can::CanSocket<Frame> socket_;
  bool is_up_ = true;
};

std::vector<can::CanFilter> heard_by_host(const RigFile& rig, std::span<const std::size_t> axes) {
  std::vector<can::CanFilter> filters;
  for (const std::size_t a : axes) {
    with_kind_of(rig.axes[a], [&]<class Kind>() {
      std::ranges::copy(Kind::heard_by_host(rig.axes[a]), std::back_inserter(filters));
    });
  }
  return filters;
}

/// Lines of one chip, the player of their instants and its thread. Destroyed in the opposite order.
class PlayedChip final : public ChipOutputs {
 public:
  explicit PlayedChip(bool tells) {
    if (tells) played_ = std::make_unique<gpio::StepPlayer::PlayedRing>();
  }
  /// Takes the lines and starts the thread. Call it once, before anything else.
  std::optional<Refusal> open(const std::string& label, std::span<const gpio::OutputLine> lines,
                              const gpio::StepPlayerSettings& settings, bool in_real_time) {
    gpio::GpioChip machine;
    if (auto refusal = machine.open(label)) return refusal;
    if (auto refusal = outputs_.open(machine, lines)) return refusal;
    player_.emplace(outputs_, settings, played_.get());
    std::optional<RealTimeRequest> request;
    if (in_real_time) request = RealTimeRequest{.locks_memory = false};
    thread_.emplace(*player_, request);
    for (const RealTimeRight& right : thread_->rights()) {
      if (right.is_needed && right.refusal) return right.refusal;
    }
    return std::nullopt;
  }

  bool push(const EdgeInstant& instant) override { return player_->push(instant); }
  void discard() override { player_->discard(); }
  [[nodiscard]] std::uint64_t waiting() const override { return player_->waiting(); }
  [[nodiscard]] bool has_ended() const override { return player_->has_ended(); }
  [[nodiscard]] std::optional<double> too_late_us() const override {
    if (!player_->is_too_late()) return std::nullopt;
    return static_cast<double>(player_->counters().worst_late_ns) * 1e-3;
  }
  std::optional<gpio::PlayedInstant> take_played() override {
    return played_ ? played_->pop() : std::nullopt;
  }
  [[nodiscard]] std::vector<Count> counts() const override { return counts_of(player_->counters()); }

 private:
  gpio::GpioOutputs outputs_;
  std::unique_ptr<gpio::StepPlayer::PlayedRing> played_;
  std::optional<gpio::StepPlayer> player_;
  std::optional<gpio::StepThread> thread_;
};

class InputsOfChip final : public ChipInputs {
 public:
  InputsOfChip(const std::string& label, std::span<const InputLine* const> lines) {
    std::vector<gpio::InputLine> wanted;
    for (const InputLine* const input : lines) {
      if (input->active == Level::low) levels_ |= std::uint64_t{1} << wanted.size();
      wanted.push_back(
          {.line = choice_of(input->address.line), .bias = biases.at(static_cast<std::size_t>(input->bias))});
    }
    const Place& first = lines.front()->address.place;
    gpio::GpioChip machine;
    if (const auto refusal = machine.open(label)) refuse_at(first, *refusal);
    if (const auto refusal = inputs_.open(machine, wanted)) refuse_at(first, *refusal);
  }

  std::span<const LineEvent> read(std::int64_t /*now_ns*/) override {
    // The levels come after the edges: they are what holds.
    const std::size_t count = inputs_.read(events_);
    levels_ = inputs_.levels().value_or(levels_);
    return std::span(events_).first(count);
  }
  [[nodiscard]] bool level(std::size_t line) const override { return (levels_ >> line & 1U) != 0; }
  [[nodiscard]] bool has_gone() const override { return inputs_.state() != gpio::ChipState::there; }

 private:
  gpio::GpioInputs inputs_;
  std::array<LineEvent, gpio::GpioInputs::max_events> events_{};
  std::uint64_t levels_ = 0;
};

}  // namespace

std::vector<InputError> unavailable_lines(const RigFile& rig) {
  std::vector<InputError> errors;
  KnownLines known;
  for (const LineAddress& line : lines_of(rig)) {
    try {
      refuse_unavailable_line(line, known);
    } catch (const InputError& error) {
      // Lines in one table have one place, and often one reason.
      const bool is_told = !errors.empty() && std::string_view(errors.back().what()) == error.what();
      if (!is_told) errors.push_back(error);
    }
  }
  return errors;
}

void refuse_unavailable_lines(const RigFile& rig) {
  KnownLines known;
  for (const LineAddress& line : lines_of(rig)) refuse_unavailable_line(line, known);
}

void MachineHardware::lock_bus(const std::string& bus) {
  const auto [lock, is_new] = buses_.try_emplace(bus);
  if (!is_new) return;
  if (const auto refusal = lock->second.take("bus " + bus)) refuse_at(place_of_bus(rig_, bus), *refusal);
}

std::unique_ptr<BusLink<can::Frame>> MachineHardware::open_classic_bus(const std::string& bus,
                                                                       std::span<const std::size_t> axes) {
  lock_bus(bus);
  return std::make_unique<SocketLink<can::Frame>>(rig_, bus, heard_by_host(motors_, axes));
}
std::unique_ptr<BusLink<can::FdFrame>> MachineHardware::open_fd_bus(const std::string& bus,
                                                                    std::span<const std::size_t> axes) {
  lock_bus(bus);
  return std::make_unique<SocketLink<can::FdFrame>>(rig_, bus, heard_by_host(motors_, axes));
}

std::unique_ptr<ChipOutputs> MachineHardware::open_steps(const std::string& chip,
                                                         std::span<const std::size_t> axes,
                                                         std::span<const StepLines> /*wires*/) {
  std::vector<gpio::OutputLine> lines, enables;
  gpio::StepPlayerSettings settings{
      .pace = {.min_spacing_ns = ns_per_s}, .max_late_ns = ns_per_s, .watch_ns = rig_.step_watch_ns};
  for (const std::size_t a : axes) {
    const auto& drive = std::get<StepDirDrive>(motors_.axes[a].drive);
    lines.push_back({.line = choice_of(drive.step)});
    lines.push_back({.line = choice_of(drive.dir)});
    if (drive.enable) {
      enables.push_back({.line = choice_of(*drive.enable), .safe_level = drive.enable_active == Level::low});
    }
    settings.max_late_ns = std::min(settings.max_late_ns, drive.latest_ns);
    settings.pace.min_spacing_ns = std::min({settings.pace.min_spacing_ns, drive.pulse_ns, drive.pause_ns,
                                             drive.dir_setup_ns, drive.dir_hold_ns});
  }
  lines.insert(lines.end(), enables.begin(), enables.end());
  auto played = std::make_unique<PlayedChip>(false);
  if (const auto refusal = played->open(chip, lines, settings, in_real_time_)) {
    const RigAxis& first = motors_.axes[axes.front()];
    refuse_at(first.place, *refusal, "axis " + in_quotes(first.name));
  }
  return played;
}

std::unique_ptr<ChipOutputs> MachineHardware::open_pulses(const std::string& chip,
                                                          std::span<const PulseLine> lines) {
  std::vector<gpio::OutputLine> wanted;
  for (const PulseLine& line : lines) {
    wanted.push_back(
        {.line = choice_of(line.wire->address.line), .is_inverted = line.wire->idle == Level::high});
  }
  auto played = std::make_unique<PlayedChip>(true);
  if (const auto refusal = played->open(chip, wanted, {.watch_ns = rig_.step_watch_ns}, in_real_time_)) {
    refuse_at(*lines.front().place, *refusal, "output " + in_quotes(lines.front().name));
  }
  return played;
}

std::string MachineHardware::chip_of(const LineAddress& line) {
  gpio::GpioChip chip;
  open_chip_of(line, chip);
  return chip.label();
}

/// Every line is looked for before any is taken.
std::vector<RigHardware::OpenedInputs> MachineHardware::open_inputs(std::span<const InputLine* const> lines) {
  std::vector<OpenedInputs> opened;
  std::vector<unsigned> offsets;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const LineAddress& address = lines[i]->address;
    gpio::GpioChip chip;
    open_chip_of(address, chip);
    const gpio::LineChoice choice = choice_of(address.line);
    if (const auto no_line = chip.find(std::span(&choice, 1), offsets)) refuse_at(address.place, *no_line);
    auto known = std::ranges::find(opened, chip.label(), &OpenedInputs::label);
    if (known == opened.end()) known = opened.insert(known, {.label = chip.label(), .lines = {}, .chip = {}});
    known->lines.push_back(i);
  }
  for (OpenedInputs& chip : opened) {
    std::vector<const InputLine*> of_chip;
    for (const std::size_t line : chip.lines) of_chip.push_back(lines[line]);
    chip.chip = std::make_unique<InputsOfChip>(chip.label, of_chip);
  }
  return opened;
}

std::unique_ptr<AxisDrives> MachineHardware::open_others(std::span<const std::size_t> axes) {
  return std::make_unique<PipeDrives>(motors_, axes);
}

}  // namespace inbetween
