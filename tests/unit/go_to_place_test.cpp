// By the keys of the run screen to a frame or a key, and back and forth: slowly, along the path.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/loop/loop_runner.hpp"
#include "host_tools/motions/run_checks.hpp"
#include "host_tools/motions/transport.hpp"
#include "tests/support/places.hpp"
#include "tests/support/ticked_rig.hpp"

namespace inbetween {
namespace go_to_place_test {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

/// The example on its rig with somebody before the screen. No axis may be faster than a tenth of its limit on
/// a distance that was asked for.
struct Desk {
  Plan plan{read_move_file(in_checkout("examples/reveal.toml")),
            read_rig_file(in_checkout("examples/camera_rig.toml")),
            {}};
  TickedRig rig{plan};
  std::unique_ptr<StagedMove> staged = checked_move(plan, 1, Repeat::none);
  Transport transport{rig.loop, *staged, true, {.key_frames = {0, 57.25, 192}}};
  double fastest = 0;  ///< since the last type(): of any axis, as a share of its limit

  explicit Desk(bool has_takes = false) {
    if (has_takes) transport.play_takes();
    EXPECT_TRUE(transport.begin());
    tick(2);
  }
  void type(std::string_view bytes) {
    TransportKeys keys;
    keys.feed(bytes);
    fastest = 0;
    while (const auto key = keys.next()) transport.press(*key);
  }
  void tick(int count = 1) {
    for (int i = 0; i < count; ++i) {
      rig.tick(transport, 1);
      for (std::size_t a = 0; a < plan.rig()->axes.size(); ++a) {
        const double speed = std::fabs(rig.loop.setpoints()[a].velocity);
        fastest = std::max(fastest, speed / plan.rig()->axes[a].max_velocity);
      }
    }
  }
  /// Paused at a frame behind this one.
  void pause_behind(double frame) {
    while (transport.snapshot().frame < frame) tick();
    type(" ");
    tick(200);
    ASSERT_EQ(phase_of(transport.snapshot()), "paused");
  }
  [[nodiscard]] double frame() const { return transport.snapshot().frame; }
  [[nodiscard]] std::string hint() const { return hint_line(transport.snapshot()); }
};

TEST(GoToPlace, AFrameAndAKeyAreGoneToSlowlyAlongThePathAfterEnter) {
  Desk desk;
  desk.pause_behind(120);
  const double before = desk.frame();
  desk.type("g96");
  desk.tick(500);
  EXPECT_EQ(desk.frame(), before) << "nothing moves before Enter";
  EXPECT_EQ(desk.hint(), "go to frame 96_: Enter goes there, Backspace corrects, Esc stops");
  desk.type(
      "\x7f"
      "0\r");
  EXPECT_THAT(desk.hint(), StartsWith("goes there slowly"));
  desk.tick(30'000);
  EXPECT_EQ(desk.frame(), 90);
  EXPECT_LT(desk.fastest, 0.1001);
  EXPECT_EQ(phase_of(desk.transport.snapshot()), "paused");
  desk.type("k1\r");
  desk.tick(30'000);
  EXPECT_EQ(desk.frame(), 57.25);
  EXPECT_LT(desk.fastest, 0.1001);
  desk.type(" ");
  desk.tick(500);
  EXPECT_EQ(desk.transport.snapshot().rate, 1) << "what is played is as fast as it was drawn";
}

TEST(GoToPlace, FromPlayItStopsFirstAndAStopOnTheWayEndsIt) {
  Desk desk;
  while (desk.frame() < 60) desk.tick();
  desk.type("g150\r");
  desk.tick(100);
  EXPECT_LT(std::fabs(desk.transport.snapshot().rate), 1);
  desk.tick(500);
  EXPECT_EQ(phase_of(desk.transport.snapshot()), "going along the path");
  desk.type("\x1b");
  desk.tick(500);
  EXPECT_EQ(desk.rig.loop.state(), SupervisorState::latched);
  const double stopped = desk.frame();
  EXPECT_LT(stopped, 150);
  desk.type("a");
  desk.tick(1000);
  EXPECT_EQ(desk.frame(), stopped) << "an acknowledged stop moves nothing";
  EXPECT_TRUE(desk.transport.snapshot().is_resting);
  EXPECT_THAT(desk.hint(), HasSubstr("g frame"));
  desk.type("g150\r");
  desk.tick(30'000);
  EXPECT_EQ(desk.frame(), 150);
}

TEST(GoToPlace, AStopBeforeItSetsOffEndsItToo) {
  Desk desk;
  while (desk.frame() < 60) desk.tick();
  desk.type("g150\r");
  desk.tick();
  desk.type("\x1b");
  desk.tick(500);
  EXPECT_EQ(desk.rig.loop.state(), SupervisorState::latched);
  EXPECT_TRUE(desk.transport.snapshot().is_resting);
  desk.type("a");
  desk.tick(1000);
  EXPECT_LT(desk.frame(), 100);
}

TEST(GoToPlace, StepsByFramesAreSlowAfterAMoveThatWasNot) {
  Desk desk;
  desk.pause_behind(100);
  desk.type("\x1b[<64;3;4M");
  desk.tick(500);
  desk.type(" ");
  desk.tick(20);
  desk.type(" ");
  desk.tick(500);
  ASSERT_EQ(phase_of(desk.transport.snapshot()), "paused");
  for (int i = 0; i < 10; ++i) desk.type("\x1b[<64;3;4M");
  desk.tick(5'000);
  EXPECT_LT(desk.fastest, 0.1001);
}

TEST(GoToPlace, WhatIsPlayedInsteadIsNotGoneBackFrom) {
  Desk desk;
  desk.pause_behind(100);
  desk.type("g50\r ");
  desk.tick(50);
  desk.type(" ");
  desk.tick(5'000);
  EXPECT_EQ(phase_of(desk.transport.snapshot()), "paused");
  EXPECT_GT(desk.frame(), 100);
}

TEST(GoToPlace, AMoveThatWaitsForItsTriggerWaitsOn) {
  Desk desk;
  const std::unique_ptr<StagedMove> staged = checked_move(desk.plan, 1, Repeat::none);
  TickedRig rig(desk.plan);
  Transport transport(rig.loop, *staged, true, {.start = [](std::int64_t) { return false; }});
  ASSERT_TRUE(transport.begin());
  rig.tick(transport, 10);
  for (const TransportKey key : {TransportKey::go_to_frame, TransportKey::size_3, TransportKey::start}) {
    transport.press(key);
  }
  transport.press(TransportKey::detent_forward);
  rig.tick(transport, 1000);
  EXPECT_EQ(rig.loop.state(), SupervisorState::ready);
  EXPECT_EQ(hint_line(transport.snapshot()), "it waits to be started");
}

TEST(GoToPlace, WhatIsNotThereIsSaidAndMovesNothing) {
  Desk desk;
  desk.pause_behind(100);
  const double before = desk.frame();
  for (const char* keys :
       {"g193\r", "k3\r", "g\r", "gk\r", "96\r", "g99\x1b[A", "g9\x7f\r", "g4294967392\r"}) {
    desk.type(keys);
    desk.tick(500);
    EXPECT_EQ(desk.frame(), before) << keys;
  }
  desk.type("k3\r");
  EXPECT_EQ(desk.hint(), "the move has no such key; the first is 0");
  desk.type("g193\r");
  EXPECT_EQ(desk.hint(), "that is not on the frames that are played");
}

TEST(GoToPlace, AHeldArrowScrubsUntilItIsLetGoAndAWheelGoesByFrames) {
  Desk desk;
  desk.pause_behind(100);
  desk.type("g96\r");
  desk.tick(10'000);
  ASSERT_EQ(desk.frame(), 96);
  desk.type("\x1b[C");  // pressed, and repeated by the keyboard half a second later, 30 times a second
  desk.tick(125);
  for (int i = 0; i < 90; ++i) {
    desk.type("\x1b[C");
    desk.tick(8);
  }
  const double scrubbed = desk.frame();
  EXPECT_GT(scrubbed, 100);
  EXPECT_LT(scrubbed, 192);
  desk.tick(300);
  const double rests = desk.frame();
  EXPECT_TRUE(desk.transport.snapshot().is_resting) << "nobody holds it any more";
  desk.tick(1000);
  EXPECT_EQ(desk.frame(), rests);
  desk.type("g120\r");
  desk.tick(30'000);
  for (int i = 0; i < 5; ++i) desk.type("\x1b[<65;3;4M");
  desk.tick(5'000);
  EXPECT_EQ(desk.frame(), 115);
  EXPECT_LT(desk.fastest, 0.1001);
}

TEST(GoToPlace, AnotherKeyEndsAScrubUntilTheArrowIsLetGo) {
  Desk desk;
  desk.pause_behind(100);
  const auto hold = [&](int repeats) {
    for (int i = 0; i < repeats; ++i) {
      desk.type("\x1b[D");
      desk.tick(8);
    }
  };
  hold(20);
  EXPECT_EQ(phase_of(desk.transport.snapshot()), "going along the path");
  desk.type(" ");
  hold(30);
  const double rests = desk.frame();
  hold(30);
  EXPECT_EQ(desk.frame(), rests);
  EXPECT_THAT(desk.hint(), StartsWith("two keys at once"));
}

TEST(GoToPlace, ArrowsThatComeLateAndAllAtOnceGoAFewFrames) {
  Desk desk;
  desk.pause_behind(100);
  desk.type("g96\r");
  desk.tick(10'000);
  std::string many;
  for (int i = 0; i < 30; ++i) many += "\x1b[C";
  desk.type(many);
  EXPECT_THAT(desk.hint(), HasSubstr("late ones: let go"));
  desk.tick(5'000);
  EXPECT_LE(desk.frame(), 100);
}

TEST(GoToPlace, ADeviceThatTellsWhenItIsLetGoScrubsAtOnce) {
  Desk desk;
  desk.pause_behind(100);
  desk.transport.press(TransportKey::hold_backward);
  for (int i = 0; i < 100; ++i) {
    desk.tick(8);
    desk.transport.press(TransportKey::still_held);
  }
  EXPECT_LT(desk.frame(), 99);
  desk.transport.press(TransportKey::let_go);
  desk.tick(200);
  EXPECT_TRUE(desk.transport.snapshot().is_resting);
  EXPECT_GT(desk.frame(), 0);
}

TEST(GoToPlace, BetweenTakesArrowsAndFramesAreGoneToAndATakeBeginsAtTheStartAlone) {
  Desk desk(true);
  EXPECT_THAT(desk.hint(), StartsWith("Enter begins a take, "));
  desk.type("\x1b[C\x1b[C");
  desk.tick(2000);
  EXPECT_EQ(desk.frame(), 2);
  EXPECT_EQ(desk.rig.loop.state(), SupervisorState::ready);
  EXPECT_THAT(desk.hint(), StartsWith("Home goes to the start, "));
  desk.type("g50\r");
  desk.tick(20'000);
  EXPECT_EQ(desk.frame(), 50);
  desk.type("\r");
  desk.tick(10);
  EXPECT_EQ(desk.transport.asks(), Transport::Ask::none);
  EXPECT_THAT(desk.hint(), StartsWith("a take begins at the start of the move"));
  desk.type("\x1b[H");
  desk.tick(10'000);
  EXPECT_EQ(desk.frame(), 0);
  desk.type("\r");
  EXPECT_EQ(desk.transport.asks(), Transport::Ask::begin_take);
}

TEST(GoToPlace, ATakeThatIsLeftSoIsNotWhole) {
  Desk desk(true);
  desk.type("\r");
  ASSERT_EQ(desk.transport.asks(), Transport::Ask::begin_take);
  LoopTrace trace(desk.plan.rig()->axes.size());
  desk.transport.take_is_ready(trace, {});
  ASSERT_TRUE(desk.transport.begin());
  while (desk.frame() < 50) desk.tick();
  desk.type("g20\r");
  for (int i = 0; i < 30'000 && desk.transport.asks() == Transport::Ask::none; ++i) desk.tick();
  ASSERT_EQ(desk.transport.asks(), Transport::Ask::end_take);
  EXPECT_FALSE(desk.transport.was_whole());
  EXPECT_EQ(desk.frame(), 20);
}

TEST(GoToPlace, TheFooterNamesNoKeyThatDoesNothing) {
  Desk desk;
  EXPECT_THAT(desk.hint(), StartsWith("space pauses"));
  desk.type("\x1b[C");
  EXPECT_EQ(desk.hint(), "space pauses it first");
  desk.pause_behind(50);
  EXPECT_THAT(desk.hint(), StartsWith("space plays, arrows step"));
  desk.type("g60\r");
  desk.tick(200);
  desk.type(" ");
  desk.tick(200);
  EXPECT_TRUE(desk.transport.snapshot().is_resting) << "space rests on the way";
  desk.type("\x1b");
  desk.tick(200);
  EXPECT_EQ(desk.hint(), "a acknowledges, q leaves");
  desk.type("a");
  desk.tick(2);
  EXPECT_THAT(desk.hint(), Not(HasSubstr("arrows"))) << "which do not begin anything";
  for (const std::string& hint : {desk.hint()}) EXPECT_LE(hint.size(), 79U);
}

TEST(GoToPlace, NoPositionIsKnownBeforeADriveIsOn) {
  const Desk desk;
  LoopTrace trace(desk.plan.rig()->axes.size());
  EXPECT_FALSE(trace.shown(desk.transport).axes[0].is_known);
  trace.take(desk.rig.loop);
  trace.take(desk.rig.loop);
  EXPECT_TRUE(trace.shown(desk.transport).axes[0].is_known);
  EXPECT_TRUE(trace.shown(desk.transport).axes[0].is_commanded);
}

}  // namespace go_to_place_test
}  // namespace inbetween
