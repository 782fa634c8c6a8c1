#pragma once

#include <cstddef>
#include <cstdint>

/// What follows from what while an axis looks for its switch, as one table.

namespace inbetween {

enum class HomingPhase : std::uint8_t {
  waiting,      ///< not begun
  sensing,      ///< finds out whether it stands on its switch
  leaving,      ///< away from the switch, on which it stood at the start
  clearing,     ///< it opened: further, by the way to back off
  searching,    ///< towards the switch, fast
  overrunning,  ///< the first edge has come: stops, until it is known what it was
  turning,      ///< the switch is actuated: stops
  backing,      ///< to the way to back off before the edge
  approaching,  ///< towards the switch, slowly
  settling,     ///< the first edge has come: stops, until it is known what it was
  latching,     ///< the switch is actuated, and where: stops
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

/// What has to be done on a transition.
enum class HomingAction : std::uint8_t {
  none,
  leave,      ///< away from the switch, by the way to leave it at most
  clear,      ///< to the way to back off before the edge that has just been
  search,     ///< towards the switch, fast, by the way to search at most
  stop,       ///< slow down
  mark,       ///< note where the edge was that has just turned out to be one
  mark_stop,  ///< both
  back_off,   ///< to the way to back off before the noted edge
  approach,   ///< towards the switch, slowly, at least as far beyond the noted edge
  refer,      ///< the noted edge is where the rig says
};

/// Why an axis does not know where it is.
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

/// In words, for people: "searching".
const char* name_of(HomingPhase phase);
/// One clause each: "the switch was not reached within the way to search".
const char* words_of(HomingFailure failure);
/// What to do about it.
const char* remedy_of(HomingFailure failure);

}  // namespace inbetween
