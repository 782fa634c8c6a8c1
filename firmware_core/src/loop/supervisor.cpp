#include "inbetween/loop/supervisor.hpp"

#include <array>

namespace inbetween {
namespace {

using enum SupervisorState;
using Action = SupervisorAction;

constexpr std::size_t index_of(SupervisorState state) {
  return static_cast<std::size_t>(state);
}
constexpr std::size_t index_of(SupervisorEvent event) {
  return static_cast<std::size_t>(event);
}

using Row = std::array<SupervisorStep, supervisor_events>;

/// Where nothing else is said: the operator's requests are refused, what the rig reports changes nothing, and
/// lost power is a fault.
constexpr Row usual(SupervisorState state) {
  Row row;
  row.fill({state, Action::none});
  for (const SupervisorEvent request :
       {SupervisorEvent::arm, SupervisorEvent::start, SupervisorEvent::acknowledge}) {
    row[index_of(request)] = {state, Action::refuse};
  }
  row[index_of(SupervisorEvent::power_lost)] = {faulted, Action::cease_setpoints};
  row[index_of(SupervisorEvent::disarm)] = {disarmed, Action::disable};
  return row;
}

constexpr std::array<Row, supervisor_states> make_table() {
  std::array<Row, supervisor_states> table;
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = usual(static_cast<SupervisorState>(i));
  const auto on = [&](SupervisorState from, SupervisorEvent event, SupervisorState to, Action action) {
    table[index_of(from)][index_of(event)] = {to, action};
  };
  using enum SupervisorEvent;
  on(disarmed, arm, enabling, Action::enable);
  on(disarmed, power_lost, disarmed, Action::none);
  on(disarmed, disarm, disarmed, Action::none);

  on(enabling, enabled, ready, Action::hold_actual);
  on(enabling, stop, disarmed, Action::disable);
  on(enabling, drive_fault, faulted, Action::quick_stop);

  on(ready, start, running, Action::play);
  on(ready, stop, latched, Action::none);
  on(ready, drive_fault, faulted, Action::quick_stop);

  on(running, finished, ready, Action::none);
  on(running, stop, stopping, Action::slow_down);
  on(running, drive_fault, stopping, Action::slow_down);
  on(running, disarm, stopping, Action::slow_down);

  on(stopping, rested, latched, Action::none);
  on(stopping, finished, latched, Action::none);
  on(stopping, disarm, stopping, Action::refuse);

  // The drives may be on or off by now: enabling finds out.
  on(latched, acknowledge, enabling, Action::enable);
  on(latched, drive_fault, faulted, Action::quick_stop);

  on(faulted, cleared, cut_off, Action::none);
  on(faulted, power_lost, faulted, Action::none);

  on(cut_off, acknowledge, enabling, Action::enable);
  on(cut_off, drive_fault, faulted, Action::none);
  return table;
}

constexpr std::array<Row, supervisor_states> table = make_table();

constexpr std::array<const char*, supervisor_states> state_names{
    "disarmed", "enabling", "ready", "running", "stopping", "must be acknowledged", "faulted", "cut off"};

}  // namespace

SupervisorStep supervise(SupervisorState state, SupervisorEvent event) {
  return table[index_of(state)][index_of(event)];
}

const char* name_of(SupervisorState state) {
  return state_names[index_of(state)];
}

}  // namespace inbetween
