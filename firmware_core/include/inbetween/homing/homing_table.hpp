#pragma once

#include <cstddef>
#include <cstdint>

/// The phases of an axis that looks for its switch, and their transitions, as one table.

namespace inbetween {

enum class HomingPhase : std::uint8_t {
  waiting,      ///< not begun
  sensing,      ///< learns whether it stands on its switch
  leaving,      ///< moves off the switch, on which it stood at the start
  clearing,     ///< the switch has opened: moves on, by the distance to back off
  searching,    ///< towards the switch, fast
  overrunning,  ///< the first edge has come: stops, until the switch has settled
  turning,      ///< the switch is actuated: stops
  backing,      ///< moves back, to the distance to back off before the edge
  approaching,  ///< towards the switch, slowly
  settling,     ///< the first edge has come: stops, until the switch has settled
  latching,     ///< the switch is actuated, and its place is known: stops
  referenced,   ///< rests, and knows where
  stopping,     ///< failed, or another axis has: slows down
  failed,       ///< rests, and does not know where
};
inline constexpr std::size_t homing_phases = 14;

enum class HomingSignal : std::uint8_t {
  begin,
  edge,  ///< those of SwitchChange
  noise,
  activated,
  released,
  rested_off,  ///< the axis rests, and the switch has settled and is not actuated
  rested_on,   ///< ... and is
  abort,       ///< something that ends the homing of every axis
  cut,         ///< no setpoints are sent any more, and the axis rests
};
inline constexpr std::size_t homing_signals = 9;

/// The action on a transition.
enum class HomingAction : std::uint8_t {
  none,
  leave,      ///< away from the switch, by the distance to leave it at most
  clear,      ///< to the distance to back off before the edge that has just been
  search,     ///< towards the switch, fast, by the distance to search at most
  stop,       ///< slow down
  mark,       ///< note the position of the edge that has just proved to be one
  mark_stop,  ///< both
  back_off,   ///< to the distance to back off before the noted edge
  approach,   ///< towards the switch, slowly, at least as far beyond the noted edge
  refer,      ///< the noted edge gets the position that the rig gives it
};

/// The reason why an axis is not referenced.
enum class HomingFailure : std::uint8_t {
  none,
  never_reached,
  stuck,
  chattering,
  events_lost,
  limit_hit,
  drive_fault,
  stopped,
  other_axis,
};
inline constexpr std::size_t homing_failures = 9;

struct HomingStep {
  HomingPhase phase = HomingPhase::waiting;
  HomingAction action = HomingAction::none;
  HomingFailure failure = HomingFailure::none;  ///< with which the homing ends
};

/// The whole table. A failure leads to stopping and from there to failed, and failed leads nowhere. O(1).
HomingStep homing_step(HomingPhase phase, HomingSignal signal);

/// One clause each: "the switch was not reached within the distance to search".
const char* words_of(HomingFailure failure);
/// The remedy of a failure.
const char* remedy_of(HomingFailure failure);

}  // namespace inbetween
