#include "drivers/gpio/step_thread.hpp"

namespace inbetween::gpio {

StepThread::StepThread(StepPlayer& player, const std::optional<RealTimeWishes>& wishes)
    : player_(player), thread_([this, wishes] { play(wishes); }) {
  is_ready_.wait();
}

StepThread::~StepThread() {
  player_.end();
  thread_.join();
}

void StepThread::play(const std::optional<RealTimeWishes>& wishes) {
  std::optional<RealTimeThread> real_time;
  if (wishes) {
    real_time.emplace(*wishes);
    rights_ = real_time->rights();
  }
  is_ready_.count_down();
  player_.run();
}

}  // namespace inbetween::gpio
