// The table of the homing, whole: every phase times every signal.
#include "inbetween/homing/homing_table.hpp"

#include <gtest/gtest.h>

#include <map>
#include <ostream>
#include <set>
#include <string>
#include <vector>

namespace inbetween {
namespace homing_table_test {

using Phase = HomingPhase;
using Signal = HomingSignal;
using Action = HomingAction;
using Failure = HomingFailure;

/// Written a second time, row by row as one would tell it. What is not here stays in its phase.
struct Told {
  Phase phase = Phase::waiting;
  Action action = Action::none;
  Failure failure = Failure::none;
};
const Told aborted{Phase::stopping, Action::stop};
const Told cut{Phase::failed};
const std::map<Phase, std::map<Signal, Told>> expected{
    {Phase::waiting, {{Signal::begin, {Phase::sensing}}}},
    {Phase::sensing,
     {{Signal::rested_off, {Phase::searching, Action::search}},
      {Signal::rested_on, {Phase::leaving, Action::leave}},
      {Signal::abort, aborted},
      {Signal::cut, cut}}},
    {Phase::leaving,
     {{Signal::released, {Phase::clearing, Action::clear}},
      {Signal::rested_on, {Phase::stopping, Action::stop, Failure::stuck}},
      {Signal::abort, aborted},
      {Signal::cut, cut}}},
    {Phase::clearing,
     {{Signal::activated, {Phase::stopping, Action::stop, Failure::chattering}},
      {Signal::rested_off, {Phase::approaching, Action::approach}},
      {Signal::abort, aborted},
      {Signal::cut, cut}}},
    {Phase::searching,
     {{Signal::edge, {Phase::overrunning, Action::stop}},
      {Signal::activated, {Phase::turning, Action::mark_stop}},
      {Signal::rested_off, {Phase::stopping, Action::stop, Failure::never_reached}},
      {Signal::abort, aborted},
      {Signal::cut, cut}}},
    {Phase::overrunning,
     {{Signal::noise, {Phase::searching, Action::search}},
      {Signal::activated, {Phase::turning, Action::mark}},
      {Signal::abort, aborted},
      {Signal::cut, cut}}},
    {Phase::turning,
     {{Signal::released, {Phase::stopping, Action::stop, Failure::chattering}},
      {Signal::rested_on, {Phase::backing, Action::back_off}},
      {Signal::abort, aborted},
      {Signal::cut, cut}}},
    {Phase::backing,
     {{Signal::activated, {Phase::stopping, Action::stop, Failure::chattering}},
      {Signal::rested_on, {Phase::stopping, Action::stop, Failure::stuck}},
      {Signal::rested_off, {Phase::approaching, Action::approach}},
      {Signal::abort, aborted},
      {Signal::cut, cut}}},
    {Phase::approaching,
     {{Signal::edge, {Phase::settling, Action::stop}},
      {Signal::activated, {Phase::latching, Action::mark_stop}},
      {Signal::rested_off, {Phase::stopping, Action::stop, Failure::never_reached}},
      {Signal::abort, aborted},
      {Signal::cut, cut}}},
    {Phase::settling,
     {{Signal::noise, {Phase::approaching, Action::approach}},
      {Signal::activated, {Phase::latching, Action::mark}},
      {Signal::abort, aborted},
      {Signal::cut, cut}}},
    {Phase::latching,
     {{Signal::released, {Phase::stopping, Action::stop, Failure::chattering}},
      {Signal::rested_on, {Phase::referenced, Action::refer}},
      {Signal::abort, aborted},
      {Signal::cut, cut}}},
    {Phase::referenced, {}},
    {Phase::stopping,
     {{Signal::rested_off, {Phase::failed}}, {Signal::rested_on, {Phase::failed}}, {Signal::cut, cut}}},
    {Phase::failed, {}},
};

TEST(HomingTable, EveryPhaseAndSignalLeadsWhereItShould) {
  ASSERT_EQ(expected.size(), homing_phases);
  for (std::size_t p = 0; p < homing_phases; ++p) {
    const auto phase = static_cast<Phase>(p);
    for (std::size_t s = 0; s < homing_signals; ++s) {
      const auto signal = static_cast<Signal>(s);
      const auto& row = expected.at(phase);
      const Told told = row.contains(signal) ? row.at(signal) : Told{phase};
      const HomingStep step = homing_step(phase, signal);
      const std::string where = "phase " + std::to_string(p) + ", signal " + std::to_string(s);
      EXPECT_EQ(step.phase, told.phase) << where;
      EXPECT_EQ(step.action, told.action) << where;
      EXPECT_EQ(step.failure, told.failure) << where;
    }
  }
}

TEST(HomingTable, EveryFailureHasItsOwnWords) {
  std::set<std::string> words;
  for (std::size_t f = 0; f < homing_failures; ++f) {
    words.insert(words_of(static_cast<Failure>(f)));
    EXPECT_EQ(std::string(remedy_of(static_cast<Failure>(f))).empty(), f == 0);
  }
  EXPECT_EQ(words.size(), homing_failures);
}

}  // namespace homing_table_test
}  // namespace inbetween
