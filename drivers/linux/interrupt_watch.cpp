#include "drivers/linux/interrupt_watch.hpp"

namespace inbetween {
namespace {

volatile std::sig_atomic_t has_come = 0;

void note(int) {
  has_come = 1;
}

}  // namespace

InterruptWatch::InterruptWatch()
    : interrupt_before_(std::signal(SIGINT, note)), terminate_before_(std::signal(SIGTERM, note)) {}

InterruptWatch::~InterruptWatch() {
  std::signal(SIGINT, interrupt_before_);
  std::signal(SIGTERM, terminate_before_);
  has_come = 0;
}

bool InterruptWatch::asked() {
  return has_come != 0;
}

}  // namespace inbetween
