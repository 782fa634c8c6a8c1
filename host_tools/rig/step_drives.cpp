#include "host_tools/rig/step_drives.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "drivers/gpio/gpio_chip.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "inbetween/loop/tick_time.hpp"

namespace inbetween {
namespace {

const StepDirDrive* step_dir_of(const RigAxis& axis) {
  return std::get_if<StepDirDrive>(&axis.drive);
}

/// The drive of an axis that has one.
const StepDirDrive& its_drive(const RigAxis& axis) {
  return std::get<StepDirDrive>(axis.drive);
}

StepSpec spec_of(const StepDirDrive& drive, std::int32_t rate_hz) {
  return {.steps_per_unit = drive.steps_per_unit,
          .timing = {.pulse_ns = drive.pulse_ns,
                     .pause_ns = drive.pause_ns,
                     .dir_setup_ns = drive.dir_setup_ns,
                     .dir_hold_ns = drive.dir_hold_ns},
          .max_step_rate = drive.max_step_rate,
          .tick_ns = ns_per_s / rate_hz};
}

}  // namespace

void refuse_step_rates(const RigFile& rig) {
  for (const RigAxis& axis : rig.axes) {
    const StepDirDrive* const drive = step_dir_of(axis);
    if (drive == nullptr) continue;
    value_or_refuse(check_step_rate(spec_of(*drive, rig.rate_hz), axis.max_velocity), axis.place,
                    named(axis));
  }
}

// Lanes are in the order of their chips.
StepDrives::StepDrives(const RigFile& rig, RigHardware& hardware) : rig_(rig) {
  refuse_step_rates(rig);
  for (const RigAxis& axis : rig.axes) {
    const StepDirDrive* const drive = step_dir_of(axis);
    if (drive == nullptr || std::ranges::find(chips_, drive->chip, &Chip::label) != chips_.end()) continue;
    chips_.emplace_back().label = drive->chip;
  }
  for (Chip& chip : chips_) add_lanes(chip);
  for (std::size_t i = 0; i < lanes_.size(); ++i) lanes_[i].edges = edges_[i];
  lane_states_.resize(lanes_.size());
  lists_.resize(lanes_.size());
  for (Chip& chip : chips_) {
    chip.outputs = hardware.open_steps(
        chip.label, std::span(indices_).subspan(chip.lanes.front(), chip.lanes.size()), chip.wires);
  }
  make_port();
  for (std::size_t lane = 0; lane < lanes_.size(); ++lane) {
    place(lane, hardware.counted_from(indices_[lane]));
  }
}

void StepDrives::add_lanes(Chip& chip) {
  std::int32_t bit = 0;
  std::size_t room = 0;
  for (std::size_t a = 0; a < rig_.axes.size(); ++a) {
    const RigAxis& axis = rig_.axes[a];
    const StepDirDrive* const drive = step_dir_of(axis);
    if (drive == nullptr || drive->chip != chip.label) continue;
    const StepSpec spec = spec_of(*drive, rig_.rate_hz);
    const auto generator = value_or_refuse(StepGenerator::make(spec), axis.place, named(axis));
    chip.lanes.push_back(lanes_.size());
    chip.wires.push_back({.step = bit, .dir = bit + 1, .timing = spec.timing});
    bit += 2;
    indices_.push_back(a);
    edges_.emplace_back(generator.max_edges());
    room += generator.max_edges();
    lanes_.push_back({.generator = generator, .edges = {}});
  }
  for (const std::size_t lane : chip.lanes) {
    const StepDirDrive& drive = its_drive(rig_.axes[indices_[lane]]);
    if (!drive.enable) continue;
    const std::uint64_t line = std::uint64_t{1} << bit++;
    chip.enable_mask |= line;
    if (drive.enable_active == Level::high) chip.enable_levels |= line;
  }
  if (bit > static_cast<std::int32_t>(gpio::GpioChip::max_lines)) {
    const RigAxis& last = rig_.axes[indices_[chip.lanes.back()]];
    throw InputError(last.place, fmt::format("{}: chip {} would drive {} lines; 64 are taken together at "
                                             "most; use another chip for some drives",
                                             named(last), in_quotes(chip.label), bit));
  }
  chip.instants.resize(room);
}

void StepDrives::make_port() {
  std::int64_t max_late_ns = ns_per_s;
  for (Chip& chip : chips_) {
    const RigAxis& first = rig_.axes[indices_[chip.lanes.front()]];
    const auto merge = value_or_refuse(StepMerge::make(chip.wires), first.place, named(first));
    port_chips_.push_back({chip.outputs.get(), merge, chip.wires, chip.lanes.front(), chip.lanes.size(),
                           chip.enable_mask, chip.enable_levels, chip.instants});
    for (const std::size_t lane : chip.lanes) {
      max_late_ns = std::min(max_late_ns, its_drive(rig_.axes[indices_[lane]]).latest_ns);
    }
  }
  const StepPortTiming timing{
      .rate_hz = rig_.rate_hz, .lead_ns = played_lead_ns(rig_), .max_late_ns = max_late_ns};
  const RigAxis& first = rig_.axes[indices_.front()];
  port_.emplace(
      value_or_refuse(StepPort<ChipOutputs>::make(lanes_, port_chips_, lane_states_, lists_, timing),
                      first.place, named(first)));
}

void StepDrives::place(std::size_t lane, double position) {
  const RigAxis& axis = rig_.axes[indices_[lane]];
  value_or_refuse(port_->place(lane, position), axis.place, named(axis));
}

void StepDrives::count(Counters& counts) const {
  for (Counted& chip : counts_of_chips(chips_)) counts.chips.push_back(std::move(chip));
  for (std::size_t lane = 0; lane < lanes_.size(); ++lane) {
    counts.drives.push_back({rig_.axes[indices_[lane]].name, counts_of(lanes_[lane].generator.delays())});
  }
}

std::string StepDrives::trouble() const {
  for (const Chip& chip : chips_) {
    if (chip.outputs->has_ended()) {
      return fmt::format("chip {} of the rig has gone; plug it in again", in_quotes(chip.label));
    }
    if (const auto late_us = chip.outputs->too_late_us()) {
      return fmt::format(
          "steps on chip {} came {:.0f} us late; free the machine of other work, or lower "
          "the step rate",
          in_quotes(chip.label), *late_us);
    }
  }
  for (std::size_t lane = 0; lane < lanes_.size(); ++lane) {
    if (!lane_states_[lane].has_failed) continue;
    return fmt::format(
        "axis {} was to make more steps than its max_step_rate allows; lower its max_velocity, or "
        "raise max_step_rate",
        in_quotes(rig_.axes[indices_[lane]].name));
  }
  return "";
}

}  // namespace inbetween
