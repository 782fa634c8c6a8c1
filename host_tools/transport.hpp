// The keys of a tape recorder, and what they do to a running move.
#pragma once

#include <cstdint>

#include "host_tools/operator_keys.hpp"
#include "host_tools/run_snapshot.hpp"
#include "host_tools/staged_move.hpp"

namespace inbetween {

/// Plays a move that is loaded into a loop. Refers to both. Allocates nothing.
class Transport {
 public:
  Transport(SimulatedLoop& loop, StagedMove& staged)
      : loop_(loop), playhead_(staged.playhead()), move_(staged.plan().played()), keys_(loop) {}

  /// Errors: those of MotionLoop::start.
  Status begin() { return loop_.start(direction_); }
  void press(TransportKey key);
  void tick(std::int64_t now_ns) { loop_.tick(1, now_ns); }
  [[nodiscard]] const OperatorKeys& keys() const { return keys_; }
  /// It was played to one of its ends.
  [[nodiscard]] bool is_done() const {
    return loop_.state() == SupervisorState::ready && !keys_.was_stopped();
  }
  [[nodiscard]] RunSnapshot snapshot() const;

 private:
  void pause_or_play();
  void turn();
  void step(Direction direction);
  void change_override(double by);

  SimulatedLoop& loop_;
  Playhead<double>& playhead_;
  const Move<double>& move_;
  OperatorKeys keys_;
  Direction direction_ = Direction::forward;
};

}  // namespace inbetween
