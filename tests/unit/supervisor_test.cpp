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

/// Written a second time, row by row as an operator would tell it.
const std::map<State, std::vector<Cell>> expected{
    // arm, enabled, start, finished, stop, rested, drive fault, power lost, cleared, acknowledge, disarm
    {State::disarmed,
     {{State::enabling, Action::enable},
      {State::disarmed, Action::none},
      {State::disarmed, Action::refuse},
      {State::disarmed, Action::none},
      {State::disarmed, Action::none},
      {State::disarmed, Action::none},
      {State::disarmed, Action::none},
      {State::disarmed, Action::none},
      {State::disarmed, Action::none},
      {State::disarmed, Action::refuse},
      {State::disarmed, Action::none}}},
    {State::enabling,
     {{State::enabling, Action::refuse},
      {State::ready, Action::hold_actual},
      {State::enabling, Action::refuse},
      {State::enabling, Action::none},
      {State::disarmed, Action::disable},
      {State::enabling, Action::none},
      {State::faulted, Action::quick_stop},
      {State::faulted, Action::cease_setpoints},
      {State::enabling, Action::none},
      {State::enabling, Action::refuse},
      {State::disarmed, Action::disable}}},
    {State::ready,
     {{State::ready, Action::refuse},
      {State::ready, Action::none},
      {State::running, Action::play},
      {State::ready, Action::none},
      {State::latched, Action::none},
      {State::ready, Action::none},
      {State::faulted, Action::quick_stop},
      {State::faulted, Action::cease_setpoints},
      {State::ready, Action::none},
      {State::ready, Action::refuse},
      {State::disarmed, Action::disable}}},
    {State::running,
     {{State::running, Action::refuse},
      {State::running, Action::none},
      {State::running, Action::refuse},
      {State::ready, Action::none},
      {State::stopping, Action::slow_down},
      {State::running, Action::none},
      {State::stopping, Action::slow_down},
      {State::faulted, Action::cease_setpoints},
      {State::running, Action::none},
      {State::running, Action::refuse},
      {State::stopping, Action::slow_down}}},
    {State::stopping,
     {{State::stopping, Action::refuse},
      {State::stopping, Action::none},
      {State::stopping, Action::refuse},
      {State::latched, Action::none},
      {State::stopping, Action::none},
      {State::latched, Action::none},
      {State::stopping, Action::none},
      {State::faulted, Action::cease_setpoints},
      {State::stopping, Action::none},
      {State::stopping, Action::refuse},
      {State::stopping, Action::refuse}}},
    {State::latched,
     {{State::latched, Action::refuse},
      {State::latched, Action::none},
      {State::latched, Action::refuse},
      {State::latched, Action::none},
      {State::latched, Action::none},
      {State::latched, Action::none},
      {State::faulted, Action::quick_stop},
      {State::faulted, Action::cease_setpoints},
      {State::latched, Action::none},
      {State::enabling, Action::enable},
      {State::disarmed, Action::disable}}},
    {State::faulted,
     {{State::faulted, Action::refuse},
      {State::faulted, Action::none},
      {State::faulted, Action::refuse},
      {State::faulted, Action::none},
      {State::faulted, Action::none},
      {State::faulted, Action::none},
      {State::faulted, Action::none},
      {State::faulted, Action::none},
      {State::cut_off, Action::none},
      {State::faulted, Action::refuse},
      {State::disarmed, Action::disable}}},
    {State::cut_off,
     {{State::cut_off, Action::refuse},
      {State::cut_off, Action::none},
      {State::cut_off, Action::refuse},
      {State::cut_off, Action::none},
      {State::cut_off, Action::none},
      {State::cut_off, Action::none},
      {State::faulted, Action::none},
      {State::faulted, Action::cease_setpoints},
      {State::cut_off, Action::none},
      {State::enabling, Action::enable},
      {State::disarmed, Action::disable}}},
};

TEST(Supervisor, EveryStateTimesEveryEventIsAsTheOperatorIsTold) {
  for (const State state : all_states()) {
    ASSERT_EQ(expected.at(state).size(), supervisor_events);
    for (const Event event : all_events()) {
      const SupervisorStep step = supervise(state, event);
      const Cell& cell = expected.at(state)[static_cast<std::size_t>(event)];
      EXPECT_EQ(step.state, cell.state) << name_of(state) << ", event " << static_cast<int>(event);
      EXPECT_EQ(step.action, cell.action) << name_of(state) << ", event " << static_cast<int>(event);
    }
  }
}

TEST(Supervisor, NothingRunsButByAnExplicitStartFromReady) {
  for (const State state : all_states()) {
    for (const Event event : all_events()) {
      const SupervisorStep step = supervise(state, event);
      const bool begins = step.state == State::running && state != State::running;
      EXPECT_EQ(begins, state == State::ready && event == Event::start)
          << name_of(state) << ", event " << static_cast<int>(event);
      EXPECT_EQ(step.action == Action::play, begins)
          << name_of(state) << ", event " << static_cast<int>(event);
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
