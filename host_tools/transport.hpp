// The keys of a tape recorder, and what they do to a running move.
#pragma once

#include <string>

#include "host_tools/operator_keys.hpp"
#include "host_tools/staged_move.hpp"

namespace inbetween {

/// Plays a move that is loaded into a loop. Refers to both.
class Transport {
 public:
  Transport(SimulatedLoop& loop, StagedMove& staged)
      : loop_(loop), playhead_(staged.playhead()), move_(staged.plan().played()), keys_(loop) {}

  /// Errors: those of MotionLoop::start.
  Status begin() { return loop_.start(direction_); }
  void press(TransportKey key);
  void tick() { loop_.tick(1); }
  [[nodiscard]] const OperatorKeys& keys() const { return keys_; }
  /// It was played to one of its ends.
  [[nodiscard]] bool is_done() const {
    return loop_.state() == SupervisorState::ready && !keys_.was_stopped();
  }
  /// One line: state, frame, rate, and what to press next or why the last key did nothing.
  [[nodiscard]] std::string status() const;
  /// Where on the time line, 0..1.
  [[nodiscard]] double share() const;

 private:
  void pause_or_play();
  void turn();
  void step(Direction direction);
  void change_override(double by);
  [[nodiscard]] bool is_paused() const { return keys_.is_running() && playhead_.is_resting(); }

  SimulatedLoop& loop_;
  Playhead<double>& playhead_;
  const Move<double>& move_;
  OperatorKeys keys_;
  Direction direction_ = Direction::forward;
};

}  // namespace inbetween
