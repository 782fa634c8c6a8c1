// Plays axes that move without a drawn move, until they rest.
#pragma once

#include <cstdint>
#include <optional>

#include "host_tools/loop/loop_task.hpp"
#include "host_tools/loop/operator_keys.hpp"
#include "host_tools/loop/run_loop.hpp"
#include "inbetween/loop/motion_loop.hpp"

namespace inbetween {

/// Refers to the loop and to what the spec refers to. A stop by whatever
/// is the end of it. Allocates nothing.
class ManualMotion final : public LoopTask {
 public:
  /// `doing` says what it is, "going to the start", and lives longer. How many ticks it takes if that is
  /// known.
  ManualMotion(RunLoop& loop, const FreeSpec& spec, const char* doing,
               std::optional<std::int64_t> last = std::nullopt)
      : loop_(loop), spec_(spec), keys_(loop, false), doing_(doing), last_(last) {}

  /// Errors: those of MotionLoop::load and begin.
  Status begin() override;
  void press(TransportKey key) override { keys_.press(key); }
  void tick(std::int32_t ticks, std::int64_t now_ns) override;
  [[nodiscard]] bool is_over() const override { return is_done() || keys_.has_left(); }
  /// It rests, and nobody and nothing has stopped it.
  [[nodiscard]] bool is_done() const {
    return loop_.state() == SupervisorState::ready && !keys_.was_stopped();
  }
  [[nodiscard]] const OperatorKeys& keys() const { return keys_; }
  [[nodiscard]] RunSnapshot snapshot() const override;

 private:
  RunLoop& loop_;
  FreeSpec spec_;
  OperatorKeys keys_;
  const char* doing_;
  std::optional<std::int64_t> last_;
  std::int64_t ticks_ = 0;
};

}  // namespace inbetween
