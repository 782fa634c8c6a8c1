// The supervisor's table, whole: every state times every event.
#include "inbetween/loop/supervisor.hpp"

#include <gtest/gtest.h>

#include <map>
#include <ostream>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace inbetween {
namespace supervisor_test {

using State = SupervisorState;
using Event = SupervisorEvent;
using Action = SupervisorAction;

std::vector<State> all_states() {
  std::vector<State> states;
  for (std::size_t i = 0; i < supervisor_states; ++i) states.push_back(static_cast<State>(i));
  return states;
}
std::vector<Event> all_events() {
  std::vector<Event> events;
  for (std::size_t i = 0; i < supervisor_events; ++i) events.push_back(static_cast<Event>(i));
  return events;
}

struct Cell {
  State state;
  Action action;
};

/// Written a second time, row by row as an operator would tell it. What is not here changes nothing, and who
/// asks for it is refused.
const std::map<State, std::map<Event, Cell>> expected{
    {State::disarmed, {{Event::arm, {State::enabling, Action::enable}}}},
    {State::enabling,
     {{Event::enabled, {State::ready, Action::hold_actual}},
      {Event::stop, {State::disarmed, Action::disable}},
      {Event::drive_fault, {State::faulted, Action::quick_stop}},
      {Event::power_lost, {State::faulted, Action::cease_setpoints}},
      {Event::disarm, {State::disarmed, Action::disable}}}},
    {State::ready,
     {{Event::start, {State::running, Action::play}},
      {Event::stop, {State::latched, Action::none}},
      {Event::drive_fault, {State::faulted, Action::quick_stop}},
      {Event::power_lost, {State::faulted, Action::cease_setpoints}},
      {Event::disarm, {State::disarmed, Action::disable}}}},
    {State::running,
     {{Event::finished, {State::ready, Action::none}},
      {Event::stop, {State::stopping, Action::slow_down}},
      {Event::drive_fault, {State::stopping, Action::slow_down}},
      {Event::power_lost, {State::faulted, Action::cease_setpoints}},
      {Event::disarm, {State::stopping, Action::slow_down}}}},
    {State::stopping,
     {{Event::finished, {State::latched, Action::none}},
      {Event::rested, {State::latched, Action::none}},
      {Event::power_lost, {State::faulted, Action::cease_setpoints}},
      {Event::disarm, {State::stopping, Action::refuse}}}},
    {State::latched,
     {{Event::drive_fault, {State::faulted, Action::quick_stop}},
      {Event::power_lost, {State::faulted, Action::cease_setpoints}},
      {Event::acknowledge, {State::enabling, Action::enable}},
      {Event::disarm, {State::disarmed, Action::disable}}}},
    {State::faulted,
     {{Event::cleared, {State::cut_off, Action::none}}, {Event::disarm, {State::disarmed, Action::disable}}}},
    {State::cut_off,
     {{Event::drive_fault, {State::faulted, Action::none}},
      {Event::power_lost, {State::faulted, Action::cease_setpoints}},
      {Event::acknowledge, {State::enabling, Action::enable}},
      {Event::disarm, {State::disarmed, Action::disable}}}},
};

Cell expected_of(State state, Event event) {
  const auto& row = expected.at(state);
  if (row.contains(event)) return row.at(event);
  const bool is_asked_for = event == Event::arm || event == Event::start || event == Event::acknowledge;
  return {state, is_asked_for ? Action::refuse : Action::none};
}

TEST(Supervisor, EveryStateTimesEveryEventIsAsTheOperatorIsTold) {
  ASSERT_EQ(expected.size(), supervisor_states);
  for (const State state : all_states()) {
    for (const Event event : all_events()) {
      const SupervisorStep step = supervise(state, event);
      const Cell cell = expected_of(state, event);
      EXPECT_EQ(step.state, cell.state) << name_of(state) << ", event " << static_cast<int>(event);
      EXPECT_EQ(step.action, cell.action) << name_of(state) << ", event " << static_cast<int>(event);
    }
  }
}

TEST(Supervisor, FromAStopToRunningTheWayIsAcknowledgeEnabledStart) {
  for (const State from : {State::stopping, State::latched, State::faulted, State::cut_off}) {
    // Every sequence of events that never contains acknowledge or disarm, then arm: by reachability.
    std::set<State> reached{from};
    for (std::size_t i = 0; i < supervisor_states; ++i) {
      for (const State state : std::set<State>(reached)) {
        for (const Event event : all_events()) {
          if (event == Event::acknowledge || event == Event::disarm) continue;
          reached.insert(supervise(state, event).state);
        }
      }
    }
    EXPECT_FALSE(reached.contains(State::running)) << name_of(from);
    EXPECT_FALSE(reached.contains(State::ready)) << name_of(from);
  }
  EXPECT_EQ(supervise(State::latched, Event::acknowledge).state, State::enabling);
  EXPECT_EQ(supervise(State::enabling, Event::enabled).action, Action::hold_actual);
}

TEST(Supervisor, EveryStateHasAName) {
  std::set<std::string> names;
  for (const State state : all_states()) names.insert(name_of(state));
  EXPECT_EQ(names.size(), supervisor_states);
}

}  // namespace supervisor_test
}  // namespace inbetween
