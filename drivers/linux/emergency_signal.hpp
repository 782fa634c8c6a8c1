#pragma once

#include <csignal>

namespace inbetween {

/// An emergency stop without wiring, for simulations and tests: SIGUSR1 presses it, SIGUSR2 releases it, for
/// as long as this lives. One at a time. No substitute for a switch that cuts the power.
class EmergencySignal {
 public:
  EmergencySignal();
  ~EmergencySignal();
  EmergencySignal(const EmergencySignal&) = delete;
  EmergencySignal& operator=(const EmergencySignal&) = delete;

  [[nodiscard]] static bool is_pressed();

 private:
  using Handler = void (*)(int);
  Handler press_before_;
  Handler release_before_;
};

}  // namespace inbetween
