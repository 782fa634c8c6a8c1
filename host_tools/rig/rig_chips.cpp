#include "host_tools/rig/rig_chips.hpp"

#include <fmt/format.h>

#include <map>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace inbetween {
namespace {

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
  for (const RigAxis& axis : rig.axes) {
    add_drive(axis, lines);
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

}  // namespace

gpio::LineChoice choice_of(const GpioLine& line) {
  if (const int* const offset = std::get_if<int>(&line)) return static_cast<unsigned>(*offset);
  return std::get<std::string>(line);
}

void refuse(const LineAddress& address, const Refusal& refusal) {
  throw InputError(address.place, refusal.what + "; " + refusal.remedy);
}

void open_chip_of(const LineAddress& address, gpio::GpioChip& chip) {
  const auto refusal = address.chip.empty() ? chip.open_with_line(std::get<std::string>(address.line))
                                            : chip.open(address.chip);
  if (refusal) refuse(address, *refusal);
}

void refuse_unavailable_lines(const RigFile& rig) {
  std::map<std::pair<std::string, unsigned>, Place> known;
  std::vector<unsigned> offset;
  for (const LineAddress& line : lines_of(rig)) {
    gpio::GpioChip chip;
    open_chip_of(line, chip);
    const gpio::LineChoice choice = choice_of(line.line);
    if (const auto refusal = chip.find(std::span(&choice, 1), offset)) refuse(line, *refusal);
    const auto [other, is_new] = known.try_emplace({chip.label(), offset.front()}, line.place);
    if (is_new) continue;
    throw InputError(line.place, fmt::format("line {} of chip {} is used in line {} already; give each line "
                                             "one use",
                                             offset.front(), in_quotes(chip.label()), other->second.line));
  }
}

}  // namespace inbetween
