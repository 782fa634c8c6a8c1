#include "inbetween/homing/homing_table.hpp"

#include <array>

namespace inbetween {
namespace {

using enum HomingPhase;
using Action = HomingAction;
using Failure = HomingFailure;

using Row = std::array<HomingStep, homing_signals>;

constexpr std::size_t index_of(HomingPhase phase) {
  return static_cast<std::size_t>(phase);
}
constexpr std::size_t index_of(HomingSignal signal) {
  return static_cast<std::size_t>(signal);
}

/// Every other signal changes nothing, except that a moving axis can be stopped.
constexpr Row usual(HomingPhase phase) {
  Row row;
  row.fill({.phase = phase});
  if (phase == waiting || phase == referenced || phase == failed) return row;
  row[index_of(HomingSignal::abort)] = {.phase = stopping, .action = Action::stop};
  row[index_of(HomingSignal::cut)] = {.phase = failed};
  return row;
}

constexpr std::array<Row, homing_phases> make_table() {
  std::array<Row, homing_phases> table;
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = usual(static_cast<HomingPhase>(i));
  const auto on = [&](HomingPhase from, HomingSignal signal, HomingPhase to, Action action) {
    table[index_of(from)][index_of(signal)] = {.phase = to, .action = action};
  };
  const auto fail = [&](HomingPhase from, HomingSignal signal, Failure failure) {
    table[index_of(from)][index_of(signal)] = {.phase = stopping, .action = Action::stop, .failure = failure};
  };
  using enum HomingSignal;
  on(waiting, begin, sensing, Action::none);

  on(sensing, rested_off, searching, Action::search);
  on(sensing, rested_on, leaving, Action::leave);

  // An axis on its switch never searches: it would run against the end behind the switch.
  on(leaving, released, clearing, Action::clear);
  fail(leaving, rested_on, Failure::stuck);

  on(clearing, rested_off, approaching, Action::approach);
  // A switch that closes while the axis moves away from it has bounced for too long.
  fail(clearing, activated, Failure::chattering);

  on(searching, edge, overrunning, Action::stop);
  on(searching, activated, turning, Action::mark_stop);
  fail(searching, rested_off, Failure::never_reached);

  // The distance to search counts from the start, so a spike does not lengthen the search.
  on(overrunning, noise, searching, Action::search);
  on(overrunning, activated, turning, Action::mark);

  on(turning, rested_on, backing, Action::back_off);
  fail(turning, released, Failure::chattering);

  on(backing, rested_off, approaching, Action::approach);
  fail(backing, rested_on, Failure::stuck);
  fail(backing, activated, Failure::chattering);

  on(approaching, edge, settling, Action::stop);
  on(approaching, activated, latching, Action::mark_stop);
  fail(approaching, rested_off, Failure::never_reached);

  on(settling, noise, approaching, Action::approach);
  on(settling, activated, latching, Action::mark);

  on(latching, rested_on, referenced, Action::refer);
  fail(latching, released, Failure::chattering);

  // A second reason to stop changes nothing: the first one is reported.
  on(stopping, abort, stopping, Action::none);
  on(stopping, rested_off, failed, Action::none);
  on(stopping, rested_on, failed, Action::none);
  return table;
}

constexpr std::array<Row, homing_phases> table = make_table();

struct Words {
  const char* what;
  const char* remedy;
};
constexpr std::array<Words, homing_failures> words{{
    {"nothing", ""},
    {"the switch was not reached within the distance to look for it",
     "see whether its wire is broken and the direction is right, or let the axis look further"},
    {"the switch stays actuated although the axis has left it",
     "see whether it sticks or its wires touch, or let the axis back off further than it takes to open"},
    {"the switch chatters", "see whether it is loose, or its wire beside that of a motor"},
    {"edges of the switches were lost, so that it is not known where the switch is",
     "find out what keeps the machine from reading its inputs in time, and home again"},
    {"a limit switch was hit", "drive the axis off it, and see whether the direction is right"},
    {"a drive reports a fault", "see what the drive tells"},
    {"it was stopped", "home again"},
    {"another axis failed", "see what is wrong with that one"},
}};

}  // namespace

HomingStep homing_step(HomingPhase phase, HomingSignal signal) {
  return table[index_of(phase)][index_of(signal)];
}

const char* words_of(HomingFailure failure) {
  return words[static_cast<std::size_t>(failure)].what;
}
const char* remedy_of(HomingFailure failure) {
  return words[static_cast<std::size_t>(failure)].remedy;
}

}  // namespace inbetween
