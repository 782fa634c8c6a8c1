#pragma once

#include <cstddef>
#include <cstdint>

/// Who may move when: the states of a rig between power-on and motion, as one table.

namespace inbetween {

enum class SupervisorState : std::uint8_t {
  disarmed,  ///< no setpoint is sent, the drives are off
  enabling,  ///< the drives are being switched on and their actual positions read
  ready,     ///< the drives hold the position that they had; nothing has been commanded
  running,   ///< setpoints come from the playhead; a pause is running at rate 0
  stopping,  ///< a controlled stop: all axes slow down together on the path
  latched,  ///< after a controlled stop that was not the end of the move: holds its last setpoint on the path
            ///< and waits for somebody to acknowledge it
  faulted,  ///< setpoints have ceased, and what caused it is still there
  cut_off,  ///< the cause is gone, and somebody has to acknowledge it: nothing is sent, because the last
            ///< setpoints are not where the rig is any more
};
inline constexpr std::size_t supervisor_states = 8;

enum class SupervisorEvent : std::uint8_t {
  arm,       ///< the operator wants to use the rig
  enabled,   ///< every drive is on and has told its actual position
  start,     ///< the operator starts the move
  finished,  ///< the playhead rests at the end of the move
  stop,  ///< the operator stops, or something that a controlled stop answers (a late tick beyond the limits)
  rested,       ///< the playhead has come to rest
  drive_fault,  ///< a drive cannot follow; the others can, so that they slow down together
  power_lost,   ///< e-stop, bus off, link down: setpoints cannot or must not reach the drives any more
  cleared,      ///< the cause of a fault is gone
  acknowledge,  ///< the operator has seen why it stopped
  disarm,       ///< the operator is done
};
inline constexpr std::size_t supervisor_events = 11;

/// The action of a transition, before anything else is sent.
enum class SupervisorAction : std::uint8_t {
  none,
  refuse,           ///< the operator's request is not for this state: tell so
  enable,           ///< switch the drives on, read their actual positions
  hold_actual,      ///< the first setpoint of every axis is its actual position
  play,             ///< let the playhead go
  slow_down,        ///< Playhead::stop
  quick_stop,       ///< no setpoints any more; the drives stop by their own ramps
  cease_setpoints,  ///< send nothing: the drive's own watchdog stops the motor
  disable,          ///< switch the drives off
};

struct SupervisorStep {
  SupervisorState state;
  SupervisorAction action;
};

/// The whole table: what follows from a state and an event. No other state is kept anywhere. Nothing leads
/// from latched, faulted or cut_off to running but acknowledge, enabled and start, in this order. O(1).
SupervisorStep supervise(SupervisorState state, SupervisorEvent event);

/// The state in words for people: "must be acknowledged".
const char* name_of(SupervisorState state);

}  // namespace inbetween
