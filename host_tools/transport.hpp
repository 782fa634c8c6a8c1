// What the keys of a tape recorder do to a running move.
#pragma once

#include <string>

#include "host_tools/transport_keys.hpp"
#include "inbetween/motion_loop.hpp"
#include "sim/simulated_rig.hpp"

namespace inbetween {

using SimulatedLoop = MotionLoop<double, SimulatedRig, SimulatedLines>;

/// Refers to the loop and its playhead.
class Transport {
 public:
  Transport(SimulatedLoop& loop, Playhead<double>& playhead) : loop_(loop), playhead_(playhead) {}

  void press(TransportKey key);
  /// Somebody wants to leave: the rig is stopped, and left when it rests.
  [[nodiscard]] bool wants_to_leave() const { return wants_to_leave_; }
  /// The move was stopped on its way and has not been started again: being ready is not being finished.
  [[nodiscard]] bool was_stopped() const { return was_stopped_; }
  /// One line: state, frame, rate, and what to press next or why the last key did nothing.
  [[nodiscard]] std::string status() const;
  /// Where on the time line, 0..1.
  [[nodiscard]] double share(const Move<double>& move) const;

 private:
  void pause_or_play();
  void turn();
  void step(Direction direction);
  void change_override(double by);
  void say(const Status& status);
  [[nodiscard]] bool is_running() const { return loop_.state() == SupervisorState::running; }

  SimulatedLoop& loop_;
  Playhead<double>& playhead_;
  Direction direction_ = Direction::forward;
  bool wants_to_leave_ = false;
  bool was_stopped_ = false;
  std::string words_;
};

}  // namespace inbetween
