#include "host_tools/rig/awaited_pulses.hpp"

namespace inbetween {

bool AwaitedPulses::add(const BegunPulse& begun, std::size_t chip, std::uint64_t bit) {
  if (end_ - first_ == awaited_.size()) return false;
  at(end_++) = {.pulse = {.begun = begun}, .chip = chip, .bit = bit, .is_known = begun.is_merged};
  return true;
}

void AwaitedPulses::note_played(std::size_t chip, std::int64_t at_ns, std::uint64_t on,
                                std::int64_t late_ns) {
  for (std::uint64_t i = first_; i < end_; ++i) {
    Awaited& awaited = at(i);
    if (awaited.is_known || awaited.chip != chip || (awaited.bit & on) == 0) continue;
    if (awaited.pulse.begun.at_ns != at_ns) continue;
    awaited.pulse.late_ns = late_ns;
    awaited.pulse.is_played = awaited.is_known = true;
  }
}

std::optional<PlayedPulse> AwaitedPulses::next() {
  if (first_ == end_ || !at(first_).is_known) return std::nullopt;
  return at(first_++).pulse;
}

std::optional<PlayedPulse> AwaitedPulses::rest() {
  if (first_ == end_) return std::nullopt;
  return at(first_++).pulse;
}

}  // namespace inbetween
