// An operator can stop any running move, acknowledge a stop, and leave.
#pragma once

#include "host_tools/loop/run_loop.hpp"
#include "host_tools/loop/transport_keys.hpp"

namespace inbetween {

/// Refers to the loop. Allocates nothing: it works in the loop's own thread.
class OperatorKeys {
 public:
  /// Without somebody who attends nobody can acknowledge a stop: it is the end.
  OperatorKeys(RunLoop& loop, bool is_attended) : loop_(loop), is_attended_(is_attended) {}

  /// Whether it was one of stop, acknowledge, quit and refused, which mean the same everywhere.
  bool press(TransportKey key);
  /// After a stop the move was begun again.
  void begun() { was_stopped_ = false; }
  /// Somebody wants to leave: the rig is stopped, and left when it rests.
  [[nodiscard]] bool wants_to_leave() const { return wants_to_leave_; }
  /// The move was stopped on its way, by whatever, and has not been begun again: being ready is not being
  /// finished.
  [[nodiscard]] bool was_stopped() const { return was_stopped_; }
  [[nodiscard]] bool is_running() const { return loop_.state() == SupervisorState::running; }
  /// Nothing moves, and nothing will.
  [[nodiscard]] bool has_left() const;

  /// Takes the result of a tick.
  void note(const LoopTick& tick);
  /// A tick came so late that an axis would have jumped: the rig was stopped.
  [[nodiscard]] bool has_lost_time() const { return has_lost_time_; }
  /// Sets the answer to the last key, a literal; "" for none.
  void say(const char* words) { words_ = words; }
  void say(const Status& status) { words_ = status ? "" : status.error().what; }
  [[nodiscard]] const char* words() const { return words_; }

 private:
  RunLoop& loop_;
  bool is_attended_;
  bool wants_to_leave_ = false;
  bool was_stopped_ = false;
  bool has_lost_time_ = false;
  const char* words_ = "";
};

}  // namespace inbetween
