#include "inbetween/steps/cue_timer.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <ostream>
#include <span>
#include <utility>
#include <vector>

namespace inbetween {
namespace cue_timer_test {

constexpr std::int64_t tick_ns = 10'000'000;
constexpr std::int64_t ms = 1'000'000;
/// At 25 frames a second a tick is a quarter of a frame.
constexpr FrameRate fps{25, 1};
constexpr std::int32_t last_frame = 100;

using Pulse = TimedPulse;
using Place = PlayheadPlace;

struct Change {
  std::int64_t at_ns;
  std::uint64_t levels, mask;
  friend bool operator==(const Change&, const Change&) = default;
  friend std::ostream& operator<<(std::ostream& out, const Change& change) {
    return out << "{" << change.at_ns << ", " << change.levels << ", " << change.mask << "}";
  }
};
using Changes = std::vector<Change>;

constexpr Change on(std::int64_t at_ns, std::uint64_t line = 1) {
  return {at_ns, line, line};
}
constexpr Change off(std::int64_t at_ns, std::uint64_t line = 1) {
  return {at_ns, 0, line};
}

/// A timer with its pulses and all that it has put out, tick after tick from time 0.
class Timed {
 public:
  explicit Timed(std::vector<Pulse> pulses, std::size_t room = 16)
      : pulses_(std::move(pulses)),
        begun_(room),
        instants_(instants_for(room)),
        timer_(CueTimer::make(pulses_, 0, last_frame, fps).value()) {}

  void go(const Place& from, const Place& to, Repeat repeated = Repeat::none,
          std::int64_t length_ns = tick_ns) {
    const CueTick tick{from, to, repeated, now_ns_, now_ns_ + length_ns};
    const Result<CueCount> count = timer_.advance(tick, {begun_, instants_});
    ASSERT_TRUE(count) << count.error().what;
    keep(*count);
    now_ns_ += length_ns;
  }
  /// Evenly, at a rate that needs `ticks` for it.
  void pass(double from, double to, int ticks = 1) {
    const double rate = (to - from) / ticks / 0.25;
    for (int i = 0; i < ticks; ++i) {
      go(at(from + (to - from) * i / ticks, rate), at(from + (to - from) * (i + 1) / ticks, rate));
    }
  }
  void rest(double place, int ticks = 1) {
    for (int i = 0; i < ticks; ++i) go(at(place), at(place));
  }
  void end_all() {
    const Result<CueCount> count = timer_.end_all({begun_, instants_});
    ASSERT_TRUE(count);
    keep(*count);
  }
  static Place at(double place, double rate = 0, double change = 0) {
    return {.time = moved_by({0, 0.0}, place), .rate = rate, .rate_change = change};
  }
  void wait(std::int64_t ns) { now_ns_ += ns; }

  [[nodiscard]] const Changes& changes() const { return changes_; }
  [[nodiscard]] const std::vector<BegunPulse>& begun() const { return all_begun_; }
  [[nodiscard]] const CueCounters& counters() const { return timer_.counters(); }
  CueTimer& timer() { return timer_; }

 private:
  void keep(const CueCount& count) {
    for (std::size_t i = 0; i < count.instants; ++i) {
      changes_.push_back({instants_[i].at_ns, instants_[i].levels, instants_[i].mask});
    }
    for (std::size_t i = 0; i < count.begun; ++i) all_begun_.push_back(begun_[i]);
  }

  std::vector<Pulse> pulses_;
  std::vector<BegunPulse> begun_;
  std::vector<EdgeInstant> instants_;
  CueTimer timer_;
  std::int64_t now_ns_ = 0;
  Changes changes_;
  std::vector<BegunPulse> all_begun_;
};

std::vector<Pulse> one_at(std::int32_t frame, double phase = 0, std::int64_t width_ns = 3 * ms) {
  return {{{frame, phase}, width_ns, 0}};
}

TEST(CueTimer, APulseBeginsWhenThePlayheadPassesItsPlaceAndLastsItsWidth) {
  Timed timed(one_at(10, 0.125));
  timed.pass(9, 11, 8);
  EXPECT_EQ(timed.changes(), (Changes{on(45 * ms), off(48 * ms)}));
}

TEST(CueTimer, APulseOutlastsTicksAndWhateverThePlayheadDoes) {
  Timed timed(one_at(10, 0.125, 25 * ms));
  timed.pass(10, 10.25);
  timed.rest(10.25);
  timed.pass(10.25, 10);
  EXPECT_EQ(timed.changes(), (Changes{on(5 * ms)}));
  timed.rest(10);
  EXPECT_EQ(timed.changes(), (Changes{on(5 * ms), off(30 * ms)}));
}

TEST(CueTimer, WhatIsPassedAtTheEndOfATickBeginsWithTheNext) {
  Timed timed(one_at(10));
  timed.pass(9.75, 10);
  EXPECT_EQ(timed.changes(), Changes{});
  timed.pass(10, 10.25);
  EXPECT_EQ(timed.changes(), (Changes{on(10 * ms), off(13 * ms)}));
}

TEST(CueTimer, AnArrivalOnThePlaceBeginsThePulseThoughThePlayheadRestsThere) {
  Timed timed(one_at(last_frame));
  timed.pass(99.75, last_frame);
  timed.rest(last_frame, 3);
  EXPECT_EQ(timed.changes(), (Changes{on(10 * ms), off(13 * ms)}));
}

TEST(CueTimer, AnEndOfTheTimeLineWithinATickIsReachedAtTheRateBefore) {
  Timed timed(one_at(last_frame));
  timed.go(Timed::at(99.8, 1), Timed::at(last_frame));
  EXPECT_EQ(timed.changes(), (Changes{on(8 * ms)}));
}

TEST(CueTimer, APauseOnThePlaceBeginsItOnce) {
  Timed timed(one_at(10));
  timed.pass(9.5, 10, 2);
  timed.rest(10, 5);
  timed.pass(10, 11, 4);
  EXPECT_EQ(timed.changes(), (Changes{on(20 * ms), off(23 * ms)}));
}

TEST(CueTimer, AtThePlaceFromWhichThePlayheadStartsItBeginsAtTheStart) {
  Timed timed(one_at(0));
  timed.rest(0, 2);
  EXPECT_EQ(timed.changes(), Changes{});
  timed.pass(0, 1, 4);
  EXPECT_EQ(timed.changes(), (Changes{on(20 * ms), off(23 * ms)}));
}

TEST(CueTimer, BackwardBeginsNothingAndArmsWhatWasPassed) {
  Timed timed(one_at(10));
  timed.pass(9.5, 10.5, 4);
  timed.pass(10.5, 9.5, 4);
  EXPECT_EQ(timed.begun().size(), 1U);
  timed.pass(9.5, 10.5, 4);
  EXPECT_EQ(timed.changes(), (Changes{on(20 * ms), off(23 * ms), on(100 * ms), off(103 * ms)}));
}

TEST(CueTimer, ATurnExactlyOnThePlaceArmsIt) {
  Timed timed(one_at(10));
  timed.pass(10.5, 10, 2);
  timed.rest(10);
  timed.pass(10, 10.5, 2);
  EXPECT_EQ(timed.changes(), (Changes{on(30 * ms), off(33 * ms)}));
}

TEST(CueTimer, WherePlayheadIsPutDownElsewhereAllAreArmed) {
  Timed timed(one_at(10));
  timed.pass(9.5, 10.5, 4);
  timed.pass(10, 10.5, 2);
  EXPECT_EQ(timed.begun().size(), 2U);
}

TEST(CueTimer, ALoopPassesBothEnds) {
  Timed timed({{{0, 0}, ms, 0}, {{1, 0}, ms, 1}, {{last_frame, 0}, ms, 2}});
  timed.go(Timed::at(99.9, 1), Timed::at(0.15, 1), Repeat::loop);
  EXPECT_EQ(timed.changes(), (Changes{{4 * ms, 5, 5}, {5 * ms, 0, 5}}));
}

TEST(CueTimer, ALoopThatEndsExactlyWithATickPassesBothEndsInTheNext) {
  Timed timed({{{0, 0}, ms, 0}, {{last_frame, 0}, ms, 1}});
  timed.go(Timed::at(99.75, 1), Timed::at(0, 1), Repeat::loop);
  timed.pass(0, 0.5, 2);
  EXPECT_EQ(timed.changes(), (Changes{{10 * ms, 3, 3}, {11 * ms, 0, 3}}));
}

TEST(CueTimer, ABackwardLoopBeginsNothing) {
  Timed timed({{{0, 0}, ms, 0}, {{last_frame, 0}, ms, 1}});
  timed.go(Timed::at(0.1, -1), Timed::at(99.85, -1), Repeat::loop);
  timed.go(Timed::at(0, -1), Timed::at(99.75, -1), Repeat::loop);
  EXPECT_EQ(timed.changes(), Changes{});
}

TEST(CueTimer, PingPongTurnsAtTheLastFrameOnce) {
  Timed timed({{{99, 0.9}, ms, 0}, {{last_frame, 0}, ms, 1}});
  timed.go(Timed::at(99.85, 1), Timed::at(99.9, -1), Repeat::ping_pong);
  timed.pass(99.9, 99.4, 2);
  EXPECT_EQ(timed.changes(), (Changes{on(2 * ms), off(3 * ms), on(6 * ms, 2), off(7 * ms, 2)}));
}

TEST(CueTimer, PingPongTurnsAtTheLastFrameExactlyWithATickOnce) {
  Timed timed(one_at(last_frame));
  timed.go(Timed::at(99.75, 1), Timed::at(last_frame, -1), Repeat::ping_pong);
  timed.pass(last_frame, 99.5, 2);
  EXPECT_EQ(timed.changes(), (Changes{on(10 * ms), off(13 * ms)}));
}

TEST(CueTimer, PingPongTurnsAtTheFirstFrameAndPassesForward) {
  Timed timed({{{0, 0}, ms, 0}, {{0, 0.1}, ms, 1}});
  timed.go(Timed::at(0.1, -1), Timed::at(0.15, 1), Repeat::ping_pong);
  EXPECT_EQ(timed.changes(), (Changes{on(4 * ms), off(5 * ms), on(8 * ms, 2), off(9 * ms, 2)}));
}

TEST(CueTimer, LateTicksBeginAllThatWasPassedInOrderWithTheirTimes) {
  Timed timed({{{1, 0}, ms, 0}, {{2, 0}, ms, 1}, {{2, 0.5}, ms, 0}});
  timed.go(Timed::at(0.5, 1), Timed::at(3, 1), Repeat::none, 10 * tick_ns);
  EXPECT_EQ(timed.changes(),
            (Changes{on(20 * ms), off(21 * ms), on(60 * ms, 2), off(61 * ms, 2), on(80 * ms), off(81 * ms)}));
}

TEST(CueTimer, OverlappingPulsesOfALineAreOneAndCounted) {
  Timed timed({{{0, 0}, 5 * ms, 0}, {{0, 0.1}, 3 * ms, 0}, {{0, 0.2}, 2 * ms, 0}});
  timed.pass(0, 0.5, 2);
  EXPECT_EQ(timed.changes(), (Changes{on(0), off(7 * ms), on(8 * ms), off(10 * ms)}));
  EXPECT_EQ(timed.counters().merged, 1U);
  ASSERT_EQ(timed.begun().size(), 3U);
  EXPECT_FALSE(timed.begun()[0].is_merged);
  EXPECT_TRUE(timed.begun()[1].is_merged);
}

TEST(CueTimer, ALongPulseIsNotShortenedByAShortOne) {
  Timed timed({{{0, 0}, 9 * ms, 0}, {{0, 0.1}, ms, 0}});
  timed.pass(0, 0.25);
  EXPECT_EQ(timed.changes(), (Changes{on(0), off(9 * ms)}));
}

TEST(CueTimer, PulsesThatTouchAreOne) {
  Timed timed({{{0, 0}, 4 * ms, 0}, {{0, 0.1}, 2 * ms, 0}});
  timed.pass(0, 0.25);
  EXPECT_EQ(timed.changes(), (Changes{on(0), off(6 * ms)}));
  EXPECT_EQ(timed.counters().merged, 1U);
}

TEST(CueTimer, AnEndBetweenTwoTicksComesWithTheLaterOneAndIsCounted) {
  Timed timed(one_at(0, 0, 15 * ms));
  timed.pass(0, 0.25);
  timed.wait(20 * ms);
  timed.rest(0.25);
  EXPECT_EQ(timed.changes(), (Changes{on(0), off(30 * ms)}));
  EXPECT_EQ(timed.counters().late_ends, 1U);
}

TEST(CueTimer, ALateEndAndABeginningAtOnceLeaveTheLineOn) {
  Timed timed({{{0, 0}, 15 * ms, 0}, {{0, 0.25}, 3 * ms, 0}});
  timed.pass(0, 0.25);
  timed.wait(20 * ms);
  timed.rest(0.25);
  ASSERT_EQ(timed.changes().size(), 3U);
  EXPECT_EQ(timed.changes()[1], on(30 * ms));
  EXPECT_EQ(timed.changes()[2], off(33 * ms));
  EXPECT_EQ(timed.counters().merged, 1U);
}

TEST(CueTimer, PulsesBeyondTheRoomOfATickAreCounted) {
  Timed timed({{{0, 0}, ms, 0}, {{0, 0.1}, ms, 1}, {{0, 0.2}, ms, 2}}, 2);
  timed.pass(0, 0.5, 2);
  EXPECT_EQ(timed.begun().size(), 2U);
  EXPECT_EQ(timed.counters().lost, 1U);
}

TEST(CueTimer, EndAllEndsWhatHasBegun) {
  Timed timed({{{0, 0}, 50 * ms, 0}, {{0, 0}, 40 * ms, 1}});
  timed.pass(0, 0.25);
  timed.end_all();
  EXPECT_EQ(timed.changes(), (Changes{{0, 3, 3}, off(40 * ms, 2), off(50 * ms)}));
}

TEST(CueTimer, EndAllBeginsWhatWasPassedAtTheEndOfTheLastTick) {
  Timed timed(one_at(last_frame));
  timed.pass(99.75, last_frame);
  timed.end_all();
  EXPECT_EQ(timed.changes(), (Changes{on(10 * ms), off(13 * ms)}));
}

TEST(CueTimer, FromRestThePlaceIsReachedAsTheRateRises) {
  // Rate change 0 at first, bending evenly: the way is t^3.
  Timed timed(one_at(0, 0.001));
  const double tick_s = 0.01;
  const double frames = 0.008;
  const double per_s = 1 / 25.0;
  const Place to{moved_by({0, 0.0}, frames), 3 * frames / tick_s * per_s,
                 6 * frames / tick_s / tick_s * per_s};
  timed.go(Timed::at(0), to);
  EXPECT_EQ(timed.changes(), (Changes{on(5 * ms), off(8 * ms)}));
}

TEST(CueTimer, WhatIsNoPulseIsRefused) {
  const auto refused = [](std::vector<Pulse> pulses) {
    const auto timer = CueTimer::make(pulses, 0, last_frame, fps);
    return !timer && timer.error().code == ErrorCode::out_of_range;
  };
  EXPECT_TRUE(refused({{{0, 1.0}, ms, 0}}));
  EXPECT_TRUE(refused({{{0, -0.1}, ms, 0}}));
  EXPECT_TRUE(refused({{{0, 0}, 0, 0}}));
  EXPECT_TRUE(refused({{{0, 0}, ms, 64}}));
  EXPECT_TRUE(refused({{{0, 0}, ms, -1}}));
  EXPECT_TRUE(refused({{{1, 0}, ms, 0}, {{0, 0.5}, ms, 0}}));
  EXPECT_FALSE(CueTimer::make({}, 1, 0, fps));
}

TEST(CueTimer, TicksOutOfOrderAndTooLittleRoomAreRefused) {
  Timed timed(one_at(0));
  timed.pass(0, 0.25);
  std::vector<BegunPulse> begun(4);
  std::vector<EdgeInstant> instants(instants_for(4));
  const CueTick early{Timed::at(0.25), Timed::at(0.5), Repeat::none, 9 * ms, 19 * ms};
  const CueTick no_time{Timed::at(0.25), Timed::at(0.5), Repeat::none, 10 * ms, 10 * ms};
  const CueTick good{Timed::at(0.25), Timed::at(0.5), Repeat::none, 10 * ms, 20 * ms};
  EXPECT_EQ(timed.timer().advance(early, {begun, instants}).error().code, ErrorCode::out_of_range);
  EXPECT_EQ(timed.timer().advance(no_time, {begun, instants}).error().code, ErrorCode::out_of_range);
  const auto small = std::span(instants).first(instants_for(4) - 1);
  EXPECT_EQ(timed.timer().advance(good, {begun, small}).error().needed,
            static_cast<std::int64_t>(instants_for(4)));
  EXPECT_TRUE(timed.timer().advance(good, {begun, instants}));
}

}  // namespace cue_timer_test
}  // namespace inbetween
