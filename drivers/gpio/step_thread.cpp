#include "drivers/gpio/step_thread.hpp"

namespace inbetween::gpio {

StepThread::StepThread(StepPlayer& player, const std::optional<RealTimeRequest>& request)
    : player_(player), thread_([this, request] { play(request); }) {
  is_ready_.wait();
}

StepThread::~StepThread() {
  player_.end();
  thread_.join();
}

void StepThread::play(const std::optional<RealTimeRequest>& request) {
  std::optional<RealTimeThread> real_time;
  if (request) {
    real_time.emplace(*request);
    rights_ = real_time->rights();
  }
  is_ready_.count_down();
  player_.run();
}

}  // namespace inbetween::gpio
