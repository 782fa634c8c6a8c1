#include "host_tools/rig/played_chip.hpp"

#include <algorithm>

#include "drivers/gpio/gpio_chip.hpp"
#include "drivers/linux/real_time.hpp"
#include "inbetween/loop/tick_time.hpp"

namespace inbetween {

std::int64_t played_lead_ns(std::int32_t rate_hz) {
  const gpio::StepPlayerSettings player;
  return std::max(ns_per_s / rate_hz, player.nap_ns + 2 * player.watch_ns);
}

std::optional<Refusal> PlayedChip::open(const std::string& label, std::span<const gpio::OutputLine> lines,
                                        const gpio::StepPlayerSettings& settings, bool in_real_time,
                                        gpio::StepPlayer::PlayedRing* played) {
  gpio::GpioChip machine;
  if (auto refusal = machine.open(label)) return refusal;
  if (auto refusal = outputs_.open(machine, lines)) return refusal;
  player_.emplace(outputs_, settings, played);
  std::optional<RealTimeWishes> wishes;
  if (in_real_time) wishes = RealTimeWishes{.locks_memory = false};
  thread_.emplace(*player_, wishes);
  for (const RealTimeRight& right : thread_->rights()) {
    if (right.is_needed && right.refusal) return right.refusal;
  }
  return std::nullopt;
}

std::optional<double> PlayedChip::too_late_us() const {
  if (!player_ || !player_->is_too_late()) return std::nullopt;
  return static_cast<double>(player_->counters().worst_late_ns) * 1e-3;
}

}  // namespace inbetween
