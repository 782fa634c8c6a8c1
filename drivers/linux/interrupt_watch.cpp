#include "drivers/linux/interrupt_watch.hpp"

namespace inbetween {
namespace {

volatile std::sig_atomic_t has_come = 0;

void note_interrupt(int) {
  has_come = 1;
}

}  // namespace

InterruptWatch::InterruptWatch() {
  for (std::size_t i = 0; i < signals.size(); ++i) before_[i] = std::signal(signals[i], note_interrupt);
}

InterruptWatch::~InterruptWatch() {
  for (std::size_t i = 0; i < signals.size(); ++i) std::signal(signals[i], before_[i]);
  has_come = 0;
}

bool InterruptWatch::asked() {
  return has_come != 0;
}

}  // namespace inbetween
