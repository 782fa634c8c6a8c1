// Time as an axis: playing, stopping at every tick, frames, loops.
#include "inbetween/play/playhead.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/check/planned_stops.hpp"
#include "host_tools/motions/staged_move.hpp"
#include "host_tools/plan/plan.hpp"
#include "tests/support/property.hpp"
#include "tests/support/recorded_play.hpp"
#include "tests/support/rig_near.hpp"

namespace inbetween {
namespace playhead_test {

using testing::HasSubstr;

constexpr std::int32_t rate_hz = 1000;
constexpr double tick_s = 1.0 / rate_hz;

/// Ten seconds on a bent path; at rest at both ends unless the speed says otherwise.
std::string bends(const std::string& speed = "0, 0, 10, 6, 10, 0, 0", const std::string& more = "") {
  return fmt::format(
      "name = \"bends\"\nfps = 24\nframes = 240\n[[track]]\naxes = [\"x\", \"y\"]\nkeys = [ {{ at = [0, 0] "
      "}}, "
      "{{ at = [60, 40] }}, {{ at = [110, -20] }}, {{ at = [160, 30] }} ]\nspeed = [{}]\n{}",
      speed, more);
}

/// A plan on a rig whose limits are 5 % above its peaks, and its stops.
struct Bench {
  Plan plan;
  PlannedStops stops;

  explicit Bench(const std::string& text, double rate = 1, bool limits_jerk = true)
      : plan(make(text, limits_jerk)), stops(plan, rate) {
    EXPECT_TRUE(check(plan).fits());
    EXPECT_TRUE(stops.bounds().has_value());
  }
  static Plan make(const std::string& text, bool limits_jerk) {
    const MoveFile move = parse_move(text, "move.toml");
    return {move,
            rig_near(move, {.share = [] { return 1.05; }, .limits_jerk = limits_jerk, .rate_hz = rate_hz}),
            {}};
  }
  [[nodiscard]] Playhead playhead() const { return {plan.played(), *stops.bounds(), rate_hz}; }
};

double frames_of(const FrameTime& time) {
  return time.frame + time.fraction;
}

PlayheadEvent tick_until_rest(Playhead& playhead, RecordedPlay* record = nullptr, int most = 200'000) {
  PlayheadEvent last = PlayheadEvent::none;
  for (int i = 0; i < most && !playhead.is_resting(); ++i) {
    last = playhead.tick();
    if (record != nullptr) record->take(playhead);
  }
  EXPECT_TRUE(playhead.is_resting());
  return last;
}

TEST(Playhead, PlaysAMoveInExactlyItsFrames) {
  const Bench bench(bends());
  Playhead playhead = bench.playhead();
  ASSERT_TRUE(playhead.play(Direction::forward));
  const std::int64_t last = last_tick(240, {24, 1}, rate_hz);
  for (std::int64_t tick = 1; tick < last; ++tick) {
    ASSERT_EQ(playhead.tick(), PlayheadEvent::none) << tick;
    const FrameTime expected = frame_time_of_tick(tick, {24, 1}, rate_hz);
    ASSERT_EQ(playhead.time().frame, expected.frame) << tick;
    ASSERT_EQ(playhead.time().fraction, expected.fraction) << tick;
  }
  EXPECT_EQ(playhead.tick(), PlayheadEvent::finished);
  EXPECT_TRUE(playhead.is_resting());
  EXPECT_EQ(frames_of(playhead.time()), 240);
}

TEST(Playhead, PlaysBackTheSameWay) {
  const Bench bench(bends());
  Playhead playhead = bench.playhead();
  ASSERT_TRUE(playhead.place_on(240));
  ASSERT_TRUE(playhead.play(Direction::backward));
  for (std::int64_t tick = 1; tick < 10'000; ++tick) {
    ASSERT_EQ(playhead.tick(), PlayheadEvent::none) << tick;
    ASSERT_NEAR(frames_of(playhead.time()), 240 - static_cast<double>(tick) * 24 / rate_hz, 1e-12 * 240);
  }
  EXPECT_EQ(playhead.tick(), PlayheadEvent::finished);
  EXPECT_EQ(frames_of(playhead.time()), 0);
}

/// Stops the playhead where it is and looks at everything until it rests.
void expect_a_stop_in_time(const Bench& bench, Playhead playhead, RecordedPlay record,
                           const std::string& where) {
  const bool forward = playhead.rate() > 0 || (playhead.rate() == 0 && playhead.rate_change() >= 0);
  const StopLength foretold = bench.stops.bounds()->stop_from(playhead.time(), forward);
  const double from = frames_of(playhead.time());
  playhead.stop();
  int ticks = 0;
  while (!playhead.is_resting() && ticks < 100'000) {
    const double before = frames_of(playhead.time());
    playhead.tick();
    record.take(playhead);
    ++ticks;
    const double gone = frames_of(playhead.time()) - before;
    ASSERT_TRUE(forward ? gone >= 0 : gone <= 0) << "turned back " << where;
  }
  ASSERT_EQ(record.complaint(), "") << where;
  ASSERT_LE(ticks * tick_s, foretold.seconds + 2 * tick_s) << where;
  ASSERT_LE(std::fabs(frames_of(playhead.time()) - from), foretold.frames + 2 * 24 * tick_s) << where;
  ASSERT_EQ(playhead.rate(), 0) << where;
  const double rest = frames_of(playhead.time());
  for (int i = 0; i < 10; ++i) ASSERT_EQ(playhead.tick(), PlayheadEvent::none) << where;
  ASSERT_EQ(frames_of(playhead.time()), rest) << "no motion after a stop, " << where;
}

/// A stop at every tick of what `begin` starts.
void expect_stops_everywhere(const Bench& bench, Playhead playhead) {
  RecordedPlay record(bench.plan, *bench.stops.bounds(), tick_s);
  constexpr int every = sanitized ? 37 : 1;
  for (int tick = 0; !playhead.is_resting() && tick < 200'000; ++tick) {
    if (tick % every == 0) {
      expect_a_stop_in_time(bench, playhead, record, fmt::format("from tick {}", tick));
      if (testing::Test::HasFatalFailure()) return;
    }
    playhead.tick();
    record.take(playhead);
  }
  EXPECT_EQ(record.complaint(), "");
}

TEST(Playhead, AStopAtEveryTickStaysInsideTheStopLimits) {
  const Bench bench(bends());
  Playhead playhead = bench.playhead();
  ASSERT_TRUE(playhead.play(Direction::forward));
  expect_stops_everywhere(bench, playhead);
}

TEST(Playhead, AStopAtEveryTickBackwardStaysInsideTheStopLimits) {
  const Bench bench(bends());
  Playhead playhead = bench.playhead();
  ASSERT_TRUE(playhead.place_on(240));
  ASSERT_TRUE(playhead.play(Direction::backward));
  expect_stops_everywhere(bench, playhead);
}

// docs/faults.md 3, 40
TEST(Playhead, AStopAtEveryTickOfTheRollsStaysInsideTheStopLimits) {
  const Bench bench(bends("6, 10, 6, 10, 4"));
  ASSERT_LT(bench.plan.played().first_frame(), 0);
  Playhead playhead = bench.playhead();
  ASSERT_TRUE(playhead.play(Direction::forward));
  expect_stops_everywhere(bench, playhead);
}

TEST(Playhead, AStopAtEveryTickWithoutALimitOfTheJerk) {
  const Bench bench(bends(), 1, false);
  Playhead playhead = bench.playhead();
  ASSERT_TRUE(playhead.play(Direction::forward));
  expect_stops_everywhere(bench, playhead);
}

TEST(Playhead, AStopAtEveryTickOfSeveralTracksTimedInTheirOwnWays) {
  const Bench bench(bends() + R"([[track]]
axes = ["focus"]
keys = [ { at = [3], frame = 0 }, { at = [9], frame = 90 }, { at = [4], frame = 170 }, { at = [5], frame = 240 } ]
spline = "catmull-rom"
timing = "frames"
kinetic = "monotone"
[[track]]
axes = ["zoom", "iris"]
keys = [ { at = [0, 1] }, { at = [20, 2], frame = 100, hold = 12 }, { at = [30, 4] } ]
speed = [0, 0, 8, 8, 8, 8, 8, 8, 0, 0]
)",
                    1, false);
  ASSERT_EQ(bench.plan.played().axis_count(), 5U);
  Playhead playhead = bench.playhead();
  ASSERT_TRUE(playhead.play(Direction::forward));
  expect_stops_everywhere(bench, playhead);
}

/// The acceleration of a catmull-rom path steps at its keys, and the rig allows these steps.
TEST(Playhead, WhereTheAccelerationStepsOnlyTheListedStepsExceedTheJerk) {
  const MoveFile move = parse_move(bends("0, 0, 10, 6, 10, 0, 0", "spline = \"catmull-rom\"\n"), "move.toml");
  const Plan plan(
      move,
      rig_near(move,
               {.share = [] { return 1.05; }, .limits_jerk = true, .allows_steps = true, .rate_hz = rate_hz}),
      {});
  const CheckReport report = check(plan);
  ASSERT_TRUE(report.fits());
  ASSERT_EQ(report.steps.size(), 4U) << "two keys, two axes";
  const PlannedStops stops(plan);
  Playhead playhead(plan.played(), *stops.bounds(), rate_hz);
  RecordedPlay record(plan, *stops.bounds(), tick_s);
  record.allow_steps_of(report);
  ASSERT_TRUE(playhead.play(Direction::forward));
  int ticks = 0;
  for (; !playhead.is_resting(); ++ticks) {
    playhead.tick();
    record.take(playhead);
    Playhead stopped = playhead;
    RecordedPlay stop = record;
    stopped.stop();
    while (!stopped.is_resting()) {
      stopped.tick();
      stop.take(stopped);
    }
    ASSERT_EQ(stop.complaint(), "") << ticks;
  }
  EXPECT_EQ(record.complaint(), "");
  EXPECT_GT(record.excused(), 0) << "they do step";
  EXPECT_LE(record.excused(), 2 * 2 * 3) << "at two keys, two axes, in three differences each";
}

TEST(Playhead, AStopAtEveryTickOfAStepToTheNextFrame) {
  const Bench bench(bends());
  Playhead playhead = bench.playhead();
  ASSERT_TRUE(playhead.place_on(100));
  ASSERT_TRUE(playhead.step(Direction::forward));
  expect_stops_everywhere(bench, playhead);
}

TEST(Playhead, AStopAtEveryTickOfATravelAcrossTheMove) {
  const Bench bench(bends());
  Playhead playhead = bench.playhead();
  ASSERT_TRUE(playhead.place_on(200));
  ASSERT_TRUE(playhead.go_to(40));
  expect_stops_everywhere(bench, playhead);
}

TEST(Playhead, AStopAtEveryTickOfAResumeAndOfASecondStop) {
  const Bench bench(bends());
  for (const int pause_at : {1500, 4000, 7000}) {
    Playhead playhead = bench.playhead();
    ASSERT_TRUE(playhead.play(Direction::forward));
    for (int i = 0; i < pause_at; ++i) playhead.tick();
    playhead.stop();
    Playhead stopping = playhead;
    tick_until_rest(playhead);
    ASSERT_TRUE(playhead.play(Direction::forward));
    RecordedPlay record(bench.plan, *bench.stops.bounds(), tick_s);
    for (int tick = 0; tick < 1500; ++tick) {
      playhead.tick();
      record.take(playhead);
      expect_a_stop_in_time(bench, playhead, record,
                            fmt::format("resuming from {}, tick {}", pause_at, tick));
      if (HasFatalFailure()) return;
    }
    // The stop is broken off and begun again at each of its ticks.
    for (int tick = 0; !stopping.is_resting(); ++tick) {
      stopping.tick();
      Playhead again = stopping;
      if (again.is_resting()) break;
      ASSERT_TRUE(again.play(Direction::forward));
      RecordedPlay other(bench.plan, *bench.stops.bounds(), tick_s);
      for (int i = 0; i < 120; ++i) {
        again.tick();
        other.take(again);
      }
      expect_a_stop_in_time(bench, again, other,
                            fmt::format("a stop again, from {}, tick {}", pause_at, tick));
      if (HasFatalFailure()) return;
    }
  }
}

TEST(Playhead, APauseAndAResumeEndWhereTheMoveEnds) {
  const Bench bench(bends());
  Playhead playhead = bench.playhead();
  RecordedPlay record(bench.plan, *bench.stops.bounds(), tick_s);
  ASSERT_TRUE(playhead.play(Direction::forward));
  for (int i = 0; i < 4321; ++i) {
    playhead.tick();
    record.take(playhead);
  }
  playhead.stop();
  EXPECT_EQ(tick_until_rest(playhead, &record), PlayheadEvent::stopped);
  ASSERT_TRUE(playhead.play(Direction::forward));
  EXPECT_EQ(tick_until_rest(playhead, &record), PlayheadEvent::finished);
  EXPECT_EQ(frames_of(playhead.time()), 240);
  EXPECT_EQ(record.complaint(), "");
}

TEST(Playhead, GoesToAFrameAndRestsOnItExactly) {
  const Bench bench(bends());
  Playhead playhead = bench.playhead();
  for (const std::int32_t frame : {100, 101, 99, 0, 240, 7}) {
    RecordedPlay record(bench.plan, *bench.stops.bounds(), tick_s);
    ASSERT_TRUE(playhead.go_to(frame));
    EXPECT_EQ(tick_until_rest(playhead, &record), PlayheadEvent::arrived);
    EXPECT_EQ(playhead.time().frame, frame);
    EXPECT_EQ(playhead.time().fraction, 0);
    EXPECT_EQ(record.complaint(), "");
  }
  ASSERT_TRUE(playhead.step(Direction::forward));
  EXPECT_EQ(tick_until_rest(playhead), PlayheadEvent::arrived);
  EXPECT_EQ(frames_of(playhead.time()), 8);
  ASSERT_TRUE(playhead.step(Direction::backward));
  ASSERT_TRUE(playhead.step(Direction::backward)) << "two steps, pressed quickly";
  EXPECT_EQ(tick_until_rest(playhead), PlayheadEvent::arrived);
  EXPECT_EQ(frames_of(playhead.time()), 6);
  EXPECT_FALSE(playhead.go_to(241));
  EXPECT_FALSE(playhead.go_to(-1));
}

TEST(Playhead, APlaceThatIsNotWrittenAsAFrameAndLessThanOneMoreIsRefused) {
  const Bench bench(bends());
  Playhead playhead = bench.playhead();
  for (const double fraction : {1.0, 1.5, -0.25}) {
    EXPECT_FALSE(playhead.go_to({10, fraction})) << fraction;
  }
  EXPECT_TRUE(playhead.is_resting());
}

TEST(Playhead, AStepFromBetweenTwoFramesGoesToTheOneOnThatSide) {
  const Bench bench(bends());
  for (const auto& [direction, frame] :
       {std::pair(Direction::forward, 11), std::pair(Direction::backward, 10)}) {
    Playhead playhead = bench.playhead();
    ASSERT_TRUE(playhead.go_to({10, 0.25}));
    EXPECT_EQ(tick_until_rest(playhead), PlayheadEvent::arrived);
    ASSERT_TRUE(playhead.step(direction));
    EXPECT_EQ(tick_until_rest(playhead), PlayheadEvent::arrived);
    EXPECT_EQ(frames_of(playhead.time()), frame);
  }
}

TEST(Playhead, GoingToAFrameWhilePlayingStopsFirst) {
  const Bench bench(bends());
  Playhead playhead = bench.playhead();
  RecordedPlay record(bench.plan, *bench.stops.bounds(), tick_s);
  ASSERT_TRUE(playhead.play(Direction::forward));
  for (int i = 0; i < 4000; ++i) {
    playhead.tick();
    record.take(playhead);
  }
  EXPECT_EQ(playhead.step(Direction::forward).error().code, ErrorCode::wrong_state)
      << "there is no next frame while time runs";
  ASSERT_TRUE(playhead.go_to(10));
  EXPECT_EQ(tick_until_rest(playhead, &record), PlayheadEvent::arrived);
  EXPECT_EQ(frames_of(playhead.time()), 10);
  EXPECT_EQ(record.complaint(), "");
}

TEST(Playhead, PlayingOnForgetsThePlaceThatWasAskedFor) {
  const Bench bench(bends());
  Playhead playhead = bench.playhead();
  ASSERT_TRUE(playhead.play(Direction::forward));
  for (int i = 0; i < 4000; ++i) playhead.tick();
  ASSERT_TRUE(playhead.go_to(10));
  playhead.tick();
  ASSERT_TRUE(playhead.play(Direction::forward));
  EXPECT_EQ(tick_until_rest(playhead), PlayheadEvent::finished);
  EXPECT_EQ(frames_of(playhead.time()), 240);
  ASSERT_TRUE(playhead.go_to(200));
  EXPECT_EQ(tick_until_rest(playhead), PlayheadEvent::arrived);
  EXPECT_EQ(frames_of(playhead.time()), 200);
}

TEST(Playhead, ATurnIsAStopAndAStartTheOtherWay) {
  const Bench bench(bends());
  Playhead playhead = bench.playhead();
  RecordedPlay record(bench.plan, *bench.stops.bounds(), tick_s);
  ASSERT_TRUE(playhead.play(Direction::forward));
  for (int i = 0; i < 5000; ++i) {
    playhead.tick();
    record.take(playhead);
  }
  ASSERT_TRUE(playhead.play(Direction::backward));
  EXPECT_EQ(tick_until_rest(playhead, &record), PlayheadEvent::finished);
  EXPECT_EQ(frames_of(playhead.time()), 0);
  EXPECT_EQ(record.complaint(), "");
}

TEST(Playhead, ToAndFroItTurnsAtTheEndsWithoutATick) {
  const Bench bench(bends("6, 10, 6, 10, 4"));
  Playhead playhead = bench.playhead();
  RecordedPlay record(bench.plan, *bench.stops.bounds(), tick_s);
  playhead.set_repeat(Repeat::ping_pong);
  ASSERT_TRUE(playhead.play(Direction::forward));
  int turns = 0;
  for (int i = 0; i < 40'000; ++i) {
    if (playhead.tick() == PlayheadEvent::repeated) ++turns;
    record.take(playhead);
  }
  EXPECT_GE(turns, 3);
  EXPECT_EQ(record.complaint(), "");
}

TEST(Playhead, WhatATickPassesBeyondAnEndIsGoneBackInTheSameTick) {
  const Bench bench(bends());
  Playhead playhead = bench.playhead();
  constexpr double rate = 0.7;  // no whole number of ticks from end to end
  ASSERT_TRUE(playhead.set_override(rate));
  playhead.set_repeat(Repeat::ping_pong);
  ASSERT_TRUE(playhead.play(Direction::forward));
  for (int tick = 1; tick <= 40'000; ++tick) {
    playhead.tick();
    const double travelled = std::fmod(rate * 24 * tick * tick_s, 480);
    ASSERT_NEAR(frames_of(playhead.time()), travelled < 240 ? travelled : 480 - travelled, 1e-6) << tick;
  }
}

// docs/faults.md 4
TEST(Playhead, ALoopThatWouldStepIsRefusedWithTheAxis) {
  const Bench bench(bends());
  const Status refused = can_loop(bench.plan.motion());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().axis, 0);
  EXPECT_THAT(refused.error().what, HasSubstr("would step"));
}

TEST(Playhead, ALoopThatEndsWhereItStartsGoesRound) {
  const Bench bench(bends("0, 0, 10, 6, 10, 0, 0", "closed = true\n"));
  Playhead playhead = bench.playhead();
  RecordedPlay record(bench.plan, *bench.stops.bounds(), tick_s);
  ASSERT_TRUE(can_loop(bench.plan.motion()));
  playhead.set_repeat(Repeat::loop);
  ASSERT_TRUE(playhead.play(Direction::forward));
  int rounds = 0;
  for (int i = 0; i < 25'000; ++i) {
    if (playhead.tick() == PlayheadEvent::repeated) ++rounds;
    record.take(playhead);
  }
  EXPECT_EQ(rounds, 2);
  EXPECT_EQ(record.complaint(), "");
}

TEST(Playhead, TheOverrideSlowsWhatRunsAndIsCappedAtTheProvenRate) {
  const Bench bench(bends());
  Playhead playhead = bench.playhead();
  RecordedPlay record(bench.plan, *bench.stops.bounds(), tick_s);
  EXPECT_FALSE(playhead.set_override(1.01));
  EXPECT_FALSE(playhead.set_override(0));
  EXPECT_FALSE(playhead.set_override(std::nan("")));
  ASSERT_TRUE(playhead.play(Direction::forward));
  for (const double rate : {0.3, 1.0, 0.05, 0.7, 0.31, 0.3}) {
    ASSERT_TRUE(playhead.set_override(rate));
    for (int i = 0; i < 1500; ++i) {
      playhead.tick();
      record.take(playhead);
    }
    EXPECT_EQ(playhead.rate(), rate);
    EXPECT_EQ(playhead.rate_change(), 0);
  }
  EXPECT_EQ(tick_until_rest(playhead, &record), PlayheadEvent::finished);
  EXPECT_EQ(record.complaint(), "");
}

// --- what is no stop keeps the motion limits

/// A move on a rig with so much room above its peaks, staged as for a run, and the recorder that holds it to
/// its motion limits.
struct GentleBench {
  Plan plan;
  StagedMove staged;
  Plan held_to;
  PlannedStops wide;
  RecordedPlay record;

  explicit GentleBench(double room, double rate = 1)
      : plan(make(room, false)),
        staged(plan, StagedMove::stops_of(plan, rate)),
        held_to(make(room, true)),
        wide(plan, rate),
        record(held_to, *wide.bounds(), tick_s) {
    EXPECT_TRUE(staged.playhead().set_override(rate));
    EXPECT_TRUE(staged.playhead().play(Direction::forward));
  }
  static Plan make(double room, bool without_stop_limits) {
    const MoveFile move = parse_move(bends(), "move.toml");
    std::optional<RigFile> rig =
        rig_near(move, {.share = [room] { return room; }, .limits_jerk = true, .rate_hz = rate_hz});
    for (RigAxis& axis : rig->axes) {
      if (!without_stop_limits) continue;
      axis.stop_acceleration = axis.max_acceleration;
      axis.stop_jerk = axis.max_jerk;
    }
    return {move, rig, {}};
  }
  /// Until it rests, or for so many ticks; returns the highest rate.
  double play(int ticks, bool records = true) {
    double highest = 0;
    for (int i = 0; i < ticks && !staged.playhead().is_resting(); ++i) {
      staged.playhead().tick();
      if (records) record.take(staged.playhead());
      highest = std::max(highest, std::fabs(staged.playhead().rate()));
    }
    return highest;
  }
  /// What a stop does is not held to the motion limits.
  void stop() {
    staged.playhead().stop();
    play(100'000, false);
    EXPECT_TRUE(staged.playhead().is_resting());
    record.restart();
  }
};

TEST(Playhead, ThatPlaysOnAfterAStopKeepsTheMotionLimits) {
  for (const double room : {1.05, 2.5}) {
    for (int ticks = 500; ticks < 10'000; ticks += 700) {
      GentleBench bench(room);
      bench.play(ticks);
      bench.stop();
      ASSERT_TRUE(bench.staged.playhead().play(Direction::forward));
      const double highest = bench.play(1'000'000);
      ASSERT_EQ(bench.record.complaint(), "") << "stopped at tick " << ticks << ", room " << room;
      EXPECT_EQ(frames_of(bench.staged.playhead().time()), 240);
      if (ticks > 6000) continue;
      EXPECT_TRUE(room < 2 || highest == 1) << "with room it is played as drawn again";
      EXPECT_GE(highest, StagedMove::travel_share) << "at " << ticks;
    }
  }
}

TEST(Playhead, AnOverrideKeepsTheMotionLimits) {
  for (const double rate : {1.0, 1.02}) {
    GentleBench bench(1.1, rate);
    Playhead& playhead = bench.staged.playhead();
    bench.play(1500);
    for (const double next : {0.6, rate, 0.3, 0.9, 0.05, rate}) {
      ASSERT_TRUE(playhead.set_override(next));
      bench.play(1700);
    }
    bench.play(1'000'000);
    EXPECT_EQ(bench.record.complaint(), "");
    EXPECT_GT(bench.record.acceleration_share(), 0.7);
    EXPECT_EQ(frames_of(playhead.time()), 240);
  }
}

TEST(Playhead, AStopThatIsTakenBackIsReleasedAndGoesOnWithinTheMotionLimits) {
  GentleBench bench(1.3);
  Playhead& playhead = bench.staged.playhead();
  bench.play(4000);
  playhead.stop();
  for (int i = 0; i < 40; ++i) playhead.tick();
  ASSERT_LT(playhead.rate_change(), 0);
  ASSERT_TRUE(playhead.play(Direction::forward));
  for (int i = 0; i < 2000 && playhead.rate_change() < 0; ++i) playhead.tick();
  ASSERT_GE(playhead.rate_change(), 0);
  bench.record.restart();
  bench.play(1'000'000);
  EXPECT_EQ(bench.record.complaint(), "");
  EXPECT_EQ(frames_of(playhead.time()), 240);
}

TEST(Playhead, AtItsEndThereIsNothingMoreToPlay) {
  const Bench bench(bends());
  Playhead playhead = bench.playhead();
  EXPECT_EQ(playhead.play(Direction::backward).error().code, ErrorCode::wrong_state);
  ASSERT_TRUE(playhead.place_on(240));
  EXPECT_EQ(playhead.play(Direction::forward).error().code, ErrorCode::wrong_state);
  EXPECT_TRUE(playhead.is_resting());
}

}  // namespace playhead_test
}  // namespace inbetween
