#include "drivers/linux/emergency_signal.hpp"

namespace inbetween {
namespace {

volatile std::sig_atomic_t pressed = 0;

void note_emergency(int signal) {
  pressed = signal == SIGUSR1 ? 1 : 0;
}

}  // namespace

EmergencySignal::EmergencySignal()
    : press_before_(std::signal(SIGUSR1, note_emergency)),
      release_before_(std::signal(SIGUSR2, note_emergency)) {}

EmergencySignal::~EmergencySignal() {
  std::signal(SIGUSR1, press_before_);
  std::signal(SIGUSR2, release_before_);
  pressed = 0;
}

bool EmergencySignal::is_pressed() {
  return pressed != 0;
}

}  // namespace inbetween
