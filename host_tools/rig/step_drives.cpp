#include "host_tools/rig/step_drives.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "host_tools/rig/rig_chips.hpp"
#include "inbetween/loop/tick_time.hpp"

namespace inbetween {
namespace {

const StepDirDrive* step_dir_of(const RigAxis& axis) {
  return std::get_if<StepDirDrive>(&axis.drive);
}

/// Of an axis that has one.
const StepDirDrive& its_drive(const RigAxis& axis) {
  return std::get<StepDirDrive>(axis.drive);
}

StepSpec<double> spec_of(const StepDirDrive& drive, std::int32_t rate_hz) {
  return {.steps_per_unit = drive.steps_per_unit,
          .timing = {.pulse_ns = drive.pulse_ns,
                     .pause_ns = drive.pause_ns,
                     .dir_setup_ns = drive.dir_setup_ns,
                     .dir_hold_ns = drive.dir_hold_ns},
          .max_step_rate = drive.max_step_rate,
          .tick_ns = ns_per_s / rate_hz};
}

[[noreturn]] void refuse(const RigAxis& axis, const std::string& what, const std::string& remedy) {
  throw InputError(axis.place, fmt::format("axis {}: {}; {}", in_quotes(axis.name), what, remedy));
}

}  // namespace

void refuse_step_rates(const RigFile& rig) {
  for (const RigAxis& axis : rig.axes) {
    const StepDirDrive* const drive = step_dir_of(axis);
    if (drive == nullptr) continue;
    const Status possible = check_step_rate(spec_of(*drive, rig.rate_hz), axis.max_velocity);
    if (!possible) refuse(axis, possible.error().what, possible.error().remedy);
  }
}

// Lanes are in the order of their chips.
StepDrives::StepDrives(const RigFile& rig) : rig_(rig) {
  refuse_step_rates(rig);
  for (const RigAxis& axis : rig.axes) {
    const StepDirDrive* const drive = step_dir_of(axis);
    if (drive == nullptr) continue;
    const auto is_it = [&](const Chip& chip) { return chip.label == drive->chip; };
    if (std::ranges::none_of(chips_, is_it)) chips_.emplace_back().label = drive->chip;
  }
  for (Chip& chip : chips_) {
    std::int32_t bit = 0;
    std::size_t room = 0;
    for (std::size_t a = 0; a < rig.axes.size(); ++a) {
      const StepDirDrive* const drive = step_dir_of(rig.axes[a]);
      if (drive == nullptr || drive->chip != chip.label) continue;
      const StepSpec<double> spec = spec_of(*drive, rig.rate_hz);
      const Result<StepGenerator<double>> generator = StepGenerator<double>::make(spec);
      if (!generator) refuse(rig.axes[a], generator.error().what, generator.error().remedy);
      chip.lanes.push_back(lanes_.size());
      chip.wires.push_back({.step = bit, .dir = bit + 1, .timing = spec.timing});
      bit += 2;
      indices_.push_back(a);
      edges_.emplace_back(generator->max_edges());
      room += generator->max_edges();
      lanes_.push_back({.generator = *generator, .edges = {}});
    }
    for (const std::size_t lane : chip.lanes) {
      const StepDirDrive& drive = its_drive(rig.axes[indices_[lane]]);
      if (!drive.enable) continue;
      const std::uint64_t line = std::uint64_t{1} << bit++;
      chip.enable_mask |= line;
      if (drive.enable_active == Level::high) chip.enable_levels |= line;
    }
    if (bit > static_cast<std::int32_t>(gpio::GpioChip::max_lines)) {
      refuse(rig.axes[indices_[chip.lanes.back()]],
             fmt::format("chip {} would drive {} lines", in_quotes(chip.label), bit),
             "64 are taken together at most; use another chip for some drives");
    }
    chip.instants.resize(room);
  }
  for (std::size_t i = 0; i < lanes_.size(); ++i) lanes_[i].edges = edges_[i];
  lane_states_.resize(lanes_.size());
  lists_.resize(lanes_.size());
}

void StepDrives::make_port() {
  std::int64_t max_late_ns = ns_per_s;
  for (Chip& chip : chips_) {
    const Result<StepMerge> merge = StepMerge::make(chip.wires);
    const RigAxis& first = rig_.axes[indices_[chip.lanes.front()]];
    if (!merge) refuse(first, merge.error().what, merge.error().remedy);
    port_chips_.push_back({&*chip.sink, *merge, chip.wires, chip.lanes.front(), chip.lanes.size(),
                           chip.enable_mask, chip.enable_levels, chip.instants});
    for (const std::size_t lane : chip.lanes) {
      max_late_ns = std::min(max_late_ns, its_drive(rig_.axes[indices_[lane]]).latest_ns);
    }
  }
  const StepPortTiming timing{
      .rate_hz = rig_.rate_hz, .lead_ns = played_lead_ns(rig_.rate_hz), .max_late_ns = max_late_ns};
  auto port = StepPort<double, HostStepSink>::make(lanes_, port_chips_, lane_states_, lists_, timing);
  if (!port) refuse(rig_.axes[indices_.front()], port.error().what, port.error().remedy);
  port_.emplace(*port);
}

std::unique_ptr<StepDrives> StepDrives::simulated(const RigFile& rig, const std::vector<double>& positions) {
  std::unique_ptr<StepDrives> steps(new StepDrives(rig));
  if (steps->lanes_.empty()) return nullptr;
  for (Chip& chip : steps->chips_) {
    for (std::size_t i = 0; i < chip.lanes.size(); ++i) {
      const std::size_t axis = steps->indices_[chip.lanes[i]];
      const SimulatedStepper::Settings settings{
          .lines = chip.wires[i], .steps_per_unit = its_drive(rig.axes[axis]).steps_per_unit, .torque = {}};
      const Result<SimulatedStepper> stepper = SimulatedStepper::make(settings, positions[axis]);
      if (!stepper) refuse(rig.axes[axis], stepper.error().what, stepper.error().remedy);
      chip.simulated.add(*stepper);
    }
    chip.sink.emplace(chip.simulated);
  }
  steps->make_port();
  for (std::size_t lane = 0; lane < steps->lanes_.size(); ++lane) {
    steps->place(lane, positions[steps->indices_[lane]]);
  }
  return steps;
}

void StepDrives::place(std::size_t lane, double position) {
  const Status placed = port_->place(lane, position);
  if (!placed) refuse(rig_.axes[indices_[lane]], placed.error().what, placed.error().remedy);
}

void StepDrives::open(Chip& chip, bool in_real_time) {
  const RigAxis& first = rig_.axes[indices_[chip.lanes.front()]];
  std::vector<gpio::OutputLine> lines;
  std::int64_t max_late_ns = ns_per_s;
  gpio::StepPaceLimits pace{.min_spacing_ns = ns_per_s};
  for (const std::size_t lane : chip.lanes) {
    const StepDirDrive& drive = its_drive(rig_.axes[indices_[lane]]);
    lines.push_back({.line = choice_of(drive.step)});
    lines.push_back({.line = choice_of(drive.dir)});
    max_late_ns = std::min(max_late_ns, drive.latest_ns);
    pace.min_spacing_ns = std::min(
        {pace.min_spacing_ns, drive.pulse_ns, drive.pause_ns, drive.dir_setup_ns, drive.dir_hold_ns});
  }
  for (const std::size_t lane : chip.lanes) {
    const StepDirDrive& drive = its_drive(rig_.axes[indices_[lane]]);
    if (!drive.enable) continue;
    lines.push_back({.line = choice_of(*drive.enable), .safe_level = drive.enable_active == Level::low});
  }
  const gpio::StepPlayerSettings settings{.pace = pace, .max_late_ns = max_late_ns};
  if (const auto refusal = chip.played.open(chip.label, lines, settings, in_real_time)) {
    refuse(first, refusal->what, refusal->remedy);
  }
  chip.sink.emplace(*chip.played.player());
}

std::unique_ptr<StepDrives> StepDrives::on_chips(const RigFile& rig, bool in_real_time) {
  std::unique_ptr<StepDrives> steps(new StepDrives(rig));
  if (steps->lanes_.empty()) return nullptr;
  for (Chip& chip : steps->chips_) steps->open(chip, in_real_time);
  steps->make_port();
  return steps;
}

void StepDrives::read(std::span<DriveState<double>> states, std::int64_t now_ns) {
  for (Chip& chip : chips_) chip.simulated.run(now_ns);
  port_->read(states, now_ns);
}

double StepDrives::shaft(std::size_t lane) const {
  for (const Chip& chip : chips_) {
    const auto found = std::ranges::find(chip.lanes, lane);
    if (found == chip.lanes.end()) continue;
    return chip.simulated.stepper(static_cast<std::size_t>(found - chip.lanes.begin())).position();
  }
  return 0;
}

std::vector<Counted> StepDrives::counts() const {
  std::vector<Counted> counts;
  for (const Chip& chip : chips_) {
    if (const gpio::StepPlayer* const player = chip.played.player(); player != nullptr) {
      counts.push_back({chip.label, counts_of(player->counters())});
    }
  }
  return counts;
}

std::string StepDrives::trouble() const {
  for (const Chip& chip : chips_) {
    if (chip.played.has_gone()) {
      return fmt::format("chip {} of the rig has gone; plug it in again", in_quotes(chip.label));
    }
    if (const auto late_us = chip.played.too_late_us()) {
      return fmt::format(
          "steps on chip {} came {:.0f} us late; free the machine of other work, or lower "
          "the step rate",
          in_quotes(chip.label), *late_us);
    }
  }
  for (std::size_t lane = 0; lane < lanes_.size(); ++lane) {
    if (!lane_states_[lane].has_failed) continue;
    return fmt::format("axis {} was to make more steps than its max_step_rate allows",
                       in_quotes(rig_.axes[indices_[lane]].name));
  }
  return "";
}

}  // namespace inbetween
