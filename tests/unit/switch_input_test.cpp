// A switch told by edges and levels, tick by tick, with times in milliseconds.
#include "inbetween/homing/switch_input.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace inbetween {
namespace switch_input_test {

constexpr std::uint8_t line = 2;

std::int64_t ms(double milliseconds) {
  return std::llround(milliseconds * 1e6);
}

LineEvent edge(double at_ms, bool level = true) {
  return {.at_ns = ms(at_ms), .line = line, .level = level};
}

/// Looked at every millisecond, or whenever a test says.
struct Watched {
  explicit Watched(const SwitchSettings& settings = {.line = line}, bool level = false)
      : input(*SwitchInput::make(settings)) {
    input.start(ms(-10), level);
    input.update(ms(-5), level, {});
  }
  SwitchChange tick(double now_ms, bool level, const std::vector<LineEvent>& events = {}) {
    return input.update(ms(now_ms), level, events);
  }
  SwitchInput input;
};

TEST(SwitchInput, AnEdgeCountsOnceItsLevelHasStayed) {
  Watched watched;
  EXPECT_EQ(watched.tick(1, false), SwitchChange::none);
  EXPECT_EQ(watched.tick(2, true, {edge(1.3)}), SwitchChange::edge);
  EXPECT_TRUE(watched.input.is_changing());
  EXPECT_FALSE(watched.input.is_active());
  EXPECT_EQ(watched.tick(3, true), SwitchChange::none);
  EXPECT_EQ(watched.tick(4, true), SwitchChange::activated);
  EXPECT_TRUE(watched.input.is_active());
  EXPECT_FALSE(watched.input.is_changing());
  EXPECT_EQ(watched.input.edge_ns(), ms(1.3));
  EXPECT_TRUE(watched.input.is_timed());
  EXPECT_EQ(watched.tick(20, false, {edge(19.9, false)}), SwitchChange::edge);
  EXPECT_EQ(watched.tick(22, false), SwitchChange::released);
  EXPECT_EQ(watched.input.edge_ns(), ms(19.9));
}

TEST(SwitchInput, OnASlowTickTheEdgeAndItsProofComeTogether) {
  Watched watched;
  EXPECT_EQ(watched.tick(10, true, {edge(1.3)}), SwitchChange::activated);
  EXPECT_EQ(watched.input.edge_ns(), ms(1.3));
}

TEST(SwitchInput, BouncesDelayTheProofAndKeepTheTimeOfTheFirst) {
  Watched watched;
  EXPECT_EQ(watched.tick(2, false, {edge(1.3), edge(1.6, false)}), SwitchChange::edge);
  EXPECT_EQ(watched.tick(3, true, {edge(2.5)}), SwitchChange::none);
  EXPECT_EQ(watched.tick(4, true, {edge(3.1, false), edge(3.2)}), SwitchChange::none);
  EXPECT_EQ(watched.tick(5, true), SwitchChange::none);
  EXPECT_EQ(watched.tick(6, true), SwitchChange::activated);
  EXPECT_EQ(watched.input.edge_ns(), ms(1.3));
  EXPECT_EQ(watched.input.noise_count(), 0U);
}

TEST(SwitchInput, ASpikeIsNoEdgeButCounted) {
  Watched watched;
  EXPECT_EQ(watched.tick(2, false, {edge(1.3), edge(1.4, false)}), SwitchChange::edge);
  EXPECT_EQ(watched.tick(4, false), SwitchChange::noise);
  EXPECT_FALSE(watched.input.is_active());
  EXPECT_EQ(watched.tick(14, true, {edge(12.5)}), SwitchChange::edge);
  EXPECT_EQ(watched.tick(15, true), SwitchChange::activated);
  EXPECT_EQ(watched.input.edge_ns(), ms(12.5)) << "the spike has left no trace";
  EXPECT_EQ(watched.input.noise_count(), 1U);
}

TEST(SwitchInput, ASpikeLongBeforeTheEdgeIsNotItsFirstBounceOnASlowTick) {
  Watched watched;
  EXPECT_EQ(watched.tick(20, true, {edge(1.3), edge(1.4, false), edge(12.5)}), SwitchChange::activated);
  EXPECT_EQ(watched.input.edge_ns(), ms(12.5));
  EXPECT_EQ(watched.input.noise_count(), 1U);
  EXPECT_EQ(watched.tick(40, false, {edge(21, false), edge(30), edge(30.1, false)}), SwitchChange::released);
  EXPECT_EQ(watched.input.edge_ns(), ms(21)) << "the spike came after the change";
}

/// The kernel may tell the level of later for both edges of a short pulse.
TEST(SwitchInput, LevelsInEventsAreNotTrusted) {
  Watched watched;
  EXPECT_EQ(watched.tick(2, false, {edge(1.3, true), edge(1.4, true)}), SwitchChange::edge);
  EXPECT_EQ(watched.tick(4, false), SwitchChange::noise);
}

TEST(SwitchInput, BothPolarities) {
  Watched watched({.line = line, .active_level = false}, true);
  EXPECT_FALSE(watched.input.is_active());
  EXPECT_EQ(watched.tick(4, false, {edge(1, false)}), SwitchChange::activated);
  watched.input.start(ms(5), false);
  EXPECT_TRUE(watched.input.is_active());
}

TEST(SwitchInput, EdgesOfOtherLinesAreOthers) {
  Watched watched;
  EXPECT_EQ(watched.tick(2, false, {{.at_ns = ms(1), .line = 5, .level = true}}), SwitchChange::none);
  EXPECT_FALSE(watched.input.is_changing());
}

TEST(SwitchInput, WhatOnlyTheLevelTellsHasNoTimeUntilItsEventComes) {
  Watched watched;
  EXPECT_EQ(watched.tick(2, true), SwitchChange::edge);
  EXPECT_FALSE(watched.input.is_timed());
  EXPECT_EQ(watched.input.edge_ns(), ms(2));
  EXPECT_EQ(watched.tick(3, true, {edge(1.9)}), SwitchChange::none);
  EXPECT_TRUE(watched.input.is_timed());
  EXPECT_EQ(watched.input.edge_ns(), ms(1.9));
  EXPECT_EQ(watched.tick(4, true), SwitchChange::activated);

  Watched between;
  EXPECT_EQ(between.tick(2, true), SwitchChange::edge);
  EXPECT_EQ(between.tick(3, true, {edge(2.1)}), SwitchChange::none) << "after the events, before the level";
  EXPECT_TRUE(between.input.is_timed());
  EXPECT_EQ(between.input.edge_ns(), ms(2.1));
  EXPECT_EQ(between.tick(4, true), SwitchChange::none) << "not yet quiet for 2 ms";
  EXPECT_EQ(between.tick(4.2, true), SwitchChange::activated);

  Watched silent;
  EXPECT_EQ(silent.tick(2, true), SwitchChange::edge);
  EXPECT_EQ(silent.tick(3, true, {edge(2.5)}), SwitchChange::none) << "an edge of later, not the first";
  EXPECT_EQ(silent.tick(5, true), SwitchChange::activated);
  EXPECT_FALSE(silent.input.is_timed());
}

/// Edges every `every_ms`: what is never quiet, and what settles each time and still opens too often.
TEST(SwitchInput, MoreEdgesThanASwitchThatBouncesIsChattering) {
  for (const double every_ms : {0.1, 1.9, 2.9}) {
    Watched watched({.line = line, .quiet_ns = every_ms > 2 ? 1'000'000 : 3'000'000});
    std::size_t edges = 0;
    bool level = false;
    for (double now = every_ms; edges < SwitchInput::max_edges; now += every_ms, ++edges) {
      level = !level;
      watched.tick(now, level, {edge(now, level)});
    }
    EXPECT_FALSE(watched.input.is_chattering()) << every_ms;
    const double next = every_ms * static_cast<double>(edges + 1);
    watched.tick(next, !level, {edge(next, !level)});
    EXPECT_TRUE(watched.input.is_chattering()) << every_ms;
    watched.input.start(ms(200), false);
    EXPECT_FALSE(watched.input.is_chattering());
  }
}

TEST(SwitchInput, FrequentUseIsNotChattering) {
  Watched watched;
  bool level = false;
  for (int i = 1; i < 1000; ++i) {
    level = !level;
    watched.tick(4 * i, level, {edge(4 * i - 3, level)});
  }
  EXPECT_FALSE(watched.input.is_chattering());
}

TEST(SwitchInput, ASpikeAtTheStartIsNotTakenForTheLevel) {
  SwitchInput input = *SwitchInput::make({.line = line});
  input.start(ms(1), true);
  EXPECT_TRUE(input.is_changing());
  EXPECT_EQ(input.update(ms(2), false, std::vector{edge(1.1, false)}), SwitchChange::none);
  EXPECT_TRUE(input.is_changing());
  EXPECT_EQ(input.update(ms(4), false, {}), SwitchChange::none);
  EXPECT_FALSE(input.is_changing());
  EXPECT_FALSE(input.is_active());
  EXPECT_EQ(input.noise_count(), 0U);
}

TEST(SwitchInput, EventsOfBeforeTheStartAreForgotten) {
  SwitchInput input = *SwitchInput::make({.line = line});
  input.start(ms(1), false);
  const std::vector<LineEvent> stale{{.at_ns = ms(0.9), .line = line, .level = true, .lost_before = true}};
  EXPECT_EQ(input.update(ms(3), false, stale), SwitchChange::none);
  EXPECT_FALSE(input.has_lost_events());
  EXPECT_FALSE(input.is_changing());
}

TEST(SwitchInput, LostEventsOfAnyLineAreNotForgotten) {
  Watched watched;
  watched.tick(2, false, {{.at_ns = ms(1), .line = 5, .level = true, .lost_before = true}});
  watched.tick(3, false);
  EXPECT_TRUE(watched.input.has_lost_events());
  watched.input.start(ms(200), false);
  EXPECT_FALSE(watched.input.has_lost_events());
}

TEST(SwitchInput, TheTimeToSettleIsOneToThreeMilliseconds) {
  for (const std::int64_t quiet_ns : {std::int64_t{0}, std::int64_t{999'999}, std::int64_t{3'000'001}}) {
    EXPECT_FALSE(SwitchInput::make({.quiet_ns = quiet_ns}));
  }
  EXPECT_TRUE(SwitchInput::make({.quiet_ns = 1'000'000}));
  EXPECT_TRUE(SwitchInput::make({.quiet_ns = 3'000'000}));
}

TEST(EmergencyInput, LevelEdgeBrokenWireAndLostEventsAllStopInBothPolarities) {
  for (const bool healthy : {true, false}) {
    const EmergencyInput input{.line = line, .healthy_level = healthy};
    const auto asks = [&](bool level, const std::vector<LineEvent>& events = {}) {
      return input.asks_to_stop(level, events);
    };
    EXPECT_FALSE(asks(healthy));
    EXPECT_TRUE(asks(!healthy)) << "pressed, or its wire is broken: the level alone";
    EXPECT_TRUE(asks(healthy, {edge(1, !healthy)})) << "pressed for less than a tick: the edge alone";
    EXPECT_TRUE(asks(healthy, {edge(1, healthy)})) << "released: it was pressed";
    EXPECT_FALSE(asks(healthy, {{.at_ns = 1, .line = 5, .level = !healthy}})) << "of another line";
    EXPECT_TRUE(asks(healthy, {{.at_ns = 1, .line = 5, .level = true, .lost_before = true}}));
  }
}

}  // namespace switch_input_test
}  // namespace inbetween
