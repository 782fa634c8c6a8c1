// Exposures in motion (go-motion): even while the shutter is open, at rest before and after, inside the
// limits.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "host_tools/check/planned_stops.hpp"
#include "host_tools/plan/plan.hpp"
#include "inbetween/play/playhead.hpp"
#include "tests/support/recorded_play.hpp"
#include "tests/support/rig_near.hpp"

namespace inbetween {
namespace exposure_test {

using testing::HasSubstr;

constexpr std::int32_t rate_hz = 500;
constexpr double tick_s = 1.0 / rate_hz;

/// A move whose rig is 5 % above its peaks; with speed at its ends it has a pre-roll and a post-roll.
struct Bench {
  Plan plan;
  PlannedStops stops;

  explicit Bench(const std::string& speed = "0, 0, 10, 6, 10, 0, 0") : plan(make(speed)), stops(plan) {
    EXPECT_TRUE(stops.bounds().has_value());
  }
  static Plan make(const std::string& speed) {
    const MoveFile move = parse_move(
        fmt::format(
            "name = \"bends\"\nfps = 24\nframes = 48\n[[track]]\naxes = [\"x\", \"y\"]\nkeys = [ {{ at "
            "= [0, 0] }}, {{ at = [60, 40] }}, {{ at = [110, -20] }}, {{ at = [160, 30] }} ]\n"
            "speed = [{}]\n",
            speed),
        "move.toml");
    // Twice the peaks, because rolls ask for more than the move alone.
    return {move, rig_near(move, {.share = [] { return 2.0; }, .limits_jerk = true, .rate_hz = rate_hz}), {}};
  }
  [[nodiscard]] Playhead playhead() const { return {plan.played(), *stops.bounds(), rate_hz}; }
  [[nodiscard]] std::vector<double> at(const FrameTime& time) const {
    std::vector<double> positions(2);
    plan.motion().positions(time, positions);
    return positions;
  }
};

Exposure exposure_of(std::int32_t frame, double open, double close, double seconds) {
  const FrameTime at{frame, 0};
  return {moved_by(at, open), moved_by(at, close), seconds};
}

void rest(Playhead& playhead, RecordedPlay& record) {
  for (int i = 0; i < 100'000 && !playhead.is_resting(); ++i) {
    playhead.tick();
    record.take(playhead);
  }
  ASSERT_TRUE(playhead.is_resting());
}

/// Goes to the run-up, exposes, and looks at every tick.
void expect_exposed(const Bench& bench, Playhead& playhead, RecordedPlay& record, const Exposure& exposure) {
  ASSERT_TRUE(playhead.go_to_run_up(exposure));
  rest(playhead, record);
  ASSERT_TRUE(playhead.expose(exposure));
  const double even = frames_between(exposure.open, exposure.close) / exposure.seconds * tick_s;
  const double open_ticks = exposure.seconds / tick_s;
  int since_open = -1;
  int closes_after = -1;
  FrameTime before = playhead.time();
  while (!playhead.is_resting()) {
    const PlayheadEvent event = playhead.tick();
    record.take(playhead);
    if (since_open >= 0) ++since_open;
    if (event == PlayheadEvent::opened) since_open = 0;
    if (since_open == 0) {
      ASSERT_NEAR(frames_between(exposure.open, playhead.time()), 0, 1e-9);
    } else if (since_open > 0 && closes_after < 0) {
      ASSERT_NEAR(frames_between(before, playhead.time()), even, 1e-9) << "constant rate, " << since_open;
    }
    if (event == PlayheadEvent::closed) closes_after = since_open;
    if (since_open > 0 && std::fabs(since_open - open_ticks) < 1e-6) {
      const std::vector<double> closing = bench.at(exposure.close);
      const std::vector<double> now = bench.at(playhead.time());
      for (std::size_t d = 0; d < now.size(); ++d) ASSERT_NEAR(now[d], closing[d], 1e-6);
    }
    before = playhead.time();
  }
  ASSERT_EQ(closes_after, static_cast<int>(std::ceil(open_ticks - 1e-6)));
  ASSERT_EQ(record.complaint(), "");
}

TEST(Exposure, OfEveryFrameBeginsAndEndsWherePlannedAndIsEvenBetween) {
  const Bench bench;
  Playhead playhead = bench.playhead();
  RecordedPlay record(bench.plan, *bench.stops.bounds(), tick_s);
  for (std::int32_t frame = 0; frame <= 48; ++frame) {
    SCOPED_TRACE(frame);
    expect_exposed(bench, playhead, record, exposure_of(frame, 0, 0.5, 0.5));
  }
  EXPECT_GT(record.acceleration_share(), 0.1) << "it does move";
}

TEST(Exposure, OfASecondThatIsNoWholeNumberOfTicksIsEvenUntilTheTickThatEndsIt) {
  const Bench bench;
  Playhead playhead = bench.playhead();
  RecordedPlay record(bench.plan, *bench.stops.bounds(), tick_s);
  for (const double seconds : {0.1001, 0.33333, 1.0 / 24, 2.00001}) {
    SCOPED_TRACE(seconds);
    expect_exposed(bench, playhead, record, exposure_of(20, -0.25, 0.25, seconds));
  }
}

TEST(Exposure, OfAMoveInMotionRunsUpWithinItsPreRollAndOutWithinItsPostRoll) {
  const Bench bench("10, 8, 10, 6, 10");
  ASSERT_LT(bench.plan.played().first_frame(), 0);
  Playhead playhead = bench.playhead();
  RecordedPlay record(bench.plan, *bench.stops.bounds(), tick_s);
  for (const std::int32_t frame : {0, 1, 47, 48, 0}) {
    SCOPED_TRACE(frame);
    expect_exposed(bench, playhead, record, exposure_of(frame, -0.5, 0.5, 0.2));
  }
}

TEST(Exposure, AtTheDrawnSpeedIsTheFrameAsItWouldBeFilmed) {
  const Bench bench;
  Playhead playhead = bench.playhead();
  RecordedPlay record(bench.plan, *bench.stops.bounds(), tick_s);
  expect_exposed(bench, playhead, record, exposure_of(24, 0, 0.5, 0.5 / 24));
}

TEST(Exposure, ThatWouldNeedMoreThanTheProvenRateIsRefusedAndNothingMoves) {
  const Bench bench;
  Playhead playhead = bench.playhead();
  const Status refused = playhead.go_to_run_up(exposure_of(24, 0, 0.5, 0.5 / 24 * 0.999));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().what, HasSubstr("so short"));
  EXPECT_TRUE(playhead.is_resting());
  EXPECT_FALSE(playhead.go_to_run_up(exposure_of(24, 0.5, 0.5, 1))) << "it covers nothing";
  EXPECT_FALSE(playhead.go_to_run_up(exposure_of(24, 0, 0.5, 0))) << "it lasts no time";
}

TEST(Exposure, BeginsOnlyWhereItsRunUpStarts) {
  const Bench bench;
  Playhead playhead = bench.playhead();
  ASSERT_TRUE(playhead.place_on(24));
  EXPECT_EQ(playhead.expose(exposure_of(24, 0, 0.5, 0.5)).error().code, ErrorCode::wrong_state);
  ASSERT_TRUE(playhead.go_to_run_up(exposure_of(24, 0, 0.5, 0.5)));
  playhead.tick();
  EXPECT_EQ(playhead.expose(exposure_of(24, 0, 0.5, 0.5)).error().code, ErrorCode::wrong_state)
      << "it is on its way";
  EXPECT_EQ(playhead.go_to_run_up(exposure_of(24, 0, 0.5, 0.5)).error().code, ErrorCode::wrong_state);
}

/// Whoever plays while the playhead is beyond an end, on its way to a run-up, in it or at rest there.
TEST(Exposure, PlayedFromBeyondAnEndTheMoveBeginsOnThatEnd) {
  const Bench bench("0, 0, 10, 6, 10, 0, 0");
  const Exposure exposure = exposure_of(0, -0.5, 0.5, 0.5);
  const FrameTime first{bench.plan.played().first_frame(), 0};
  int beyond = 0;
  for (const Repeat repeat : {Repeat::none, Repeat::ping_pong}) {
    for (const Direction direction : {Direction::forward, Direction::backward}) {
      Playhead playhead = bench.playhead();
      playhead.set_repeat(repeat);
      RecordedPlay record(bench.plan, *bench.stops.bounds(), tick_s);
      ASSERT_TRUE(playhead.go_to_run_up(exposure));
      for (bool is_exposed = false; !is_exposed || !playhead.is_resting();) {
        if (playhead.is_resting()) {
          ASSERT_TRUE(playhead.expose(exposure));
          is_exposed = true;
        }
        playhead.tick();
        record.take(playhead);
        if (!(playhead.time() < first)) continue;
        ++beyond;
        Playhead played = playhead;
        RecordedPlay watch = record;
        const bool has_frames = direction == Direction::forward || repeat == Repeat::ping_pong;
        ASSERT_EQ(played.play(direction).has_value(), has_frames);
        if (!has_frames) {
          ASSERT_EQ(played.time(), playhead.time());
          ASSERT_EQ(played.state(), playhead.state());
          continue;
        }
        ASSERT_EQ(played.time(), first);
        played.tick();
        ASSERT_NEAR(frames_between(first, played.time()), 24 * tick_s, 1e-12);
        for (int i = 0; i < 200; ++i, played.tick()) watch.take(played);
        ASSERT_EQ(watch.complaint(), "");
      }
    }
  }
  EXPECT_GT(beyond, 100);
}

TEST(Exposure, CanBeStoppedAtEveryTick) {
  const Bench bench;
  Playhead playhead = bench.playhead();
  RecordedPlay record(bench.plan, *bench.stops.bounds(), tick_s);
  const Exposure exposure = exposure_of(30, 0, 0.5, 0.1);
  ASSERT_TRUE(playhead.go_to_run_up(exposure));
  rest(playhead, record);
  ASSERT_TRUE(playhead.expose(exposure));
  int ticks = 0;
  while (!playhead.is_resting()) {
    playhead.tick();
    record.take(playhead);
    ++ticks;
    Playhead stopped = playhead;
    RecordedPlay stop = record;
    const StopLength foretold = bench.stops.bounds()->stop_from(playhead.time(), true);
    const FrameTime from = playhead.time();
    stopped.stop();
    int stop_ticks = 0;
    for (; !stopped.is_resting() && stop_ticks < 10'000; ++stop_ticks) {
      stopped.tick();
      stop.take(stopped);
    }
    ASSERT_EQ(stop.complaint(), "") << ticks;
    ASSERT_LE(stop_ticks * tick_s, foretold.seconds + 2 * tick_s) << ticks;
    ASSERT_LE(frames_between(from, stopped.time()), foretold.frames + 0.2) << ticks;
  }
  EXPECT_GT(ticks, 50);
}

}  // namespace exposure_test
}  // namespace inbetween
