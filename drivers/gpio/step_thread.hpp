#pragma once

#include <latch>
#include <optional>
#include <thread>
#include <vector>

#include "drivers/gpio/step_player.hpp"
#include "drivers/linux/real_time.hpp"

namespace inbetween::gpio {

/// The thread that a StepPlayer runs in, from construction to destruction, which ends the player: with the
/// safe levels set.
///
/// It watches the clock before every instant. On the only processor, or on that of the loop, it therefore
/// takes away what it watches for; ask for a processor of its own.
class StepThread {
 public:
  /// With the request it is a real-time thread as far as the machine allows: see `rights`. The process's loop
  /// has locked the memory already, so `locks_memory` is to be false in it if there is one. Without one
  /// it is an ordinary thread. Returns when it runs; throws std::system_error if there can be no thread.
  StepThread(StepPlayer& player, const std::optional<RealTimeRequest>& request);
  ~StepThread();
  StepThread(const StepThread&) = delete;
  StepThread& operator=(const StepThread&) = delete;

  /// They are as RealTimeThread has them; there are none without a request.
  [[nodiscard]] const std::vector<RealTimeRight>& rights() const { return rights_; }

 private:
  void play(const std::optional<RealTimeRequest>& request);

  StepPlayer& player_;
  std::vector<RealTimeRight> rights_;
  std::latch is_ready_{1};
  std::thread thread_;
};

}  // namespace inbetween::gpio
