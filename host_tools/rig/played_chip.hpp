// A GPIO chip of the machine whose output lines change at planned times.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "drivers/gpio/gpio_outputs.hpp"
#include "drivers/gpio/step_player.hpp"
#include "drivers/gpio/step_thread.hpp"
#include "drivers/refusal.hpp"

namespace inbetween {

/// How long before its time the motion of a tick is written: a tick, and never less than the thread of a chip
/// needs to notice it.
std::int64_t played_lead_ns(std::int32_t rate_hz);

/// Lines of one chip, the player of their instants and its thread. Destroyed in the opposite order.
class PlayedChip {
 public:
  /// Takes the lines, at their safe levels, and starts the thread, with the rights of a real-time thread if
  /// `in_real_time`. What is played goes into `played`. Once. Refused where something is not there, busy, or
  /// not allowed.
  [[nodiscard]] std::optional<Refusal> open(const std::string& label, std::span<const gpio::OutputLine> lines,
                                            const gpio::StepPlayerSettings& settings, bool in_real_time,
                                            gpio::StepPlayer::PlayedRing* played = nullptr);
  /// Null before it is open: in simulation.
  [[nodiscard]] gpio::StepPlayer* player() { return player_ ? &*player_ : nullptr; }
  [[nodiscard]] const gpio::StepPlayer* player() const { return player_ ? &*player_ : nullptr; }
  /// The chip was there, and is no more.
  [[nodiscard]] bool has_gone() const { return player_ && player_->has_ended(); }
  /// By how much an instant was late, if that was more than its limit.
  [[nodiscard]] std::optional<double> too_late_us() const;

 private:
  gpio::GpioOutputs outputs_;
  std::optional<gpio::StepPlayer> player_;
  std::optional<gpio::StepThread> thread_;
};

}  // namespace inbetween
