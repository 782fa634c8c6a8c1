#include "host_tools/rig/level_outputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

LevelOutputs::LevelOutputs(const RigFile& rig, RigHardware& hardware) : lead_ns_(played_lead_ns(rig)) {
  for (const Output& output : std::span(rig.outputs).first(std::min(rig.outputs.size(), max_outputs))) {
    const std::uint32_t bit = std::uint32_t{1} << lines_.size();
    lines_.push_back(
        {{output.name, &output.line, &output.place}, hardware.chip_of(output.line.address), bit});
  }
  std::ranges::stable_sort(lines_, {}, &Line::chip);
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    if (chips_.empty() || chips_.back().label != lines_[i].chip)
      chips_.push_back({.label = lines_[i].chip, .first = i, .outputs = {}});
    ++chips_.back().lines;
  }
  const std::vector<PulseLine> wanted(lines_.begin(), lines_.end());
  for (Chip& chip : chips_)
    chip.outputs = hardware.open_pulses(chip.label, std::span(wanted).subspan(chip.first, chip.lines));
}

std::unique_ptr<LevelOutputs> LevelOutputs::open(const RigFile& rig, RigHardware& hardware) {
  if (rig.outputs.empty()) return nullptr;
  return std::unique_ptr<LevelOutputs>(new LevelOutputs(rig, hardware));
}

void LevelOutputs::set(std::uint32_t bits, std::int64_t now_ns) {
  const std::uint32_t changed = bits ^ bits_;
  for (Chip& chip : chips_) {
    EdgeInstant instant{.at_ns = now_ns + lead_ns_};
    for (std::size_t i = 0; i < chip.lines; ++i) {
      const std::uint32_t bit = lines_[chip.first + i].bit;
      const std::uint64_t line = std::uint64_t{1} << i;
      if ((changed & bit) != 0) instant.mask |= line;
      if ((changed & bits & bit) != 0) instant.levels |= line;
    }
    if (instant.mask != 0 && !chip.outputs->push(instant)) has_refused_ = true;
  }
  bits_ = bits;
}

std::string LevelOutputs::trouble() const {
  for (const Chip& chip : chips_) {
    if (chip.outputs->has_ended())
      return fmt::format("chip {} of the outputs has gone; plug it in again", in_quotes(chip.label));
  }
  return has_refused_ ? "an output did not take a level; look whether its chip is still there" : "";
}

}  // namespace inbetween
