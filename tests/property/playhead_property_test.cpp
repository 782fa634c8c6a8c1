#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/check/planned_stops.hpp"
#include "host_tools/motions/staged_move.hpp"
#include "inbetween/play/playhead.hpp"
#include "tests/support/fitting_move.hpp"
#include "tests/support/property.hpp"
#include "tests/support/recorded_play.hpp"

/// Commands in any order at any time: the axes stay inside their stop limits, and a stop ends when it was
/// foretold.

namespace inbetween {
namespace playhead_property_test {

constexpr int many_sequences = 1500;
constexpr int ticks = 1000;

/// `wanted` is an exposure that is made as soon as the playhead rests and has gone to its run-up.
void command(Playhead& playhead, const PlayedMotion& played, std::optional<Exposure>& wanted) {
  const Move& move = played.move();
  const auto frame = [&] { return *rc::gen::inRange(move.first_frame(), move.last_frame() + 1); };
  const auto direction = [] {
    return *rc::gen::arbitrary<bool>() ? Direction::forward : Direction::backward;
  };
  const auto exposure = [&] {
    const FrameTime at{frame(), 0};
    const double open = *rc::gen::inRange(-10, 10) / 20.0;
    const double share = *rc::gen::inRange(1, 20) / 20.0;
    const double slower = *rc::gen::inRange(10, 400) / 10.0;
    return Exposure{moved_by(at, open), moved_by(at, open + share),
                    slower * share / move.frame_rate().frames_per_second()};
  };
  switch (*rc::gen::inRange(0, 9)) {
    case 0:
    case 1:
      static_cast<void>(playhead.play(direction()));
      break;
    case 2:
      playhead.stop();
      break;
    case 3:
      static_cast<void>(playhead.go_to(frame()));
      break;
    case 4:
      static_cast<void>(playhead.step(direction()));
      break;
    case 5:
      static_cast<void>(playhead.set_override(*rc::gen::inRange(1, 131) / 100.0));
      break;
    case 6:
    case 7:
      wanted = exposure();
      playhead.stop();
      break;
    default:
      if (const Repeat repeat = *rc::gen::element(Repeat::none, Repeat::loop, Repeat::ping_pong);
          repeat != Repeat::loop || can_loop(played))
        playhead.set_repeat(repeat);
  }
}

struct Tried {
  int played = 0;
  int parts = 0;
  int with_rolls = 0;
  int refused = 0;
  int exposures = 0;
  int faster = 0;
  int excused = 0;  ///< ticks across a step of the acceleration that the certificate lists
};

/// Commands at random for so many ticks; then a stop, which takes no longer than foretold.
void play_at_random(const Plan& plan, const PlannedStops& stops, const CheckReport& report, Tried& tried) {
  const std::int32_t rate_hz = plan.rig()->rate_hz;
  const double tick_s = 1.0 / rate_hz;
  Playhead playhead(plan.played(), *stops.bounds(), rate_hz);
  RecordedPlay record(plan, *stops.bounds(), tick_s);
  record.allow_steps_of(report);
  std::optional<Exposure> wanted;
  RC_ASSERT(playhead.play(Direction::forward).has_value());
  for (int tick = 0; tick < ticks; ++tick) {
    if (*rc::gen::inRange(0, 40) == 0) command(playhead, plan.motion(), wanted);
    if (wanted && playhead.is_resting()) {
      if (playhead.expose(*wanted)) {
        ++tried.exposures;
        wanted.reset();
      } else if (!playhead.go_to_run_up(*wanted)) {
        wanted.reset();
      }
    }
    static_cast<void>(playhead.tick());
    record.take(playhead);
    if (!record.complaint().empty()) RC_FAIL("tick " + std::to_string(tick) + ": " + record.complaint());
  }
  const bool forward = playhead.rate() >= 0;
  const StopLength foretold = stops.bounds()->stop_from(playhead.time(), forward);
  playhead.stop();
  int needed = 0;
  for (; !playhead.is_resting() && needed < 10'000'000; ++needed) static_cast<void>(playhead.tick());
  RC_ASSERT(playhead.is_resting());
  RC_ASSERT(needed * tick_s <= foretold.seconds + 3 * tick_s);
  tried.excused += record.excused();
}

/// On a path whose acceleration steps at its keys, a rig that allows the steps sees them and nothing else.
TEST(PlayheadProperty, AnyCommandsAtAnyTimeKeepTheStopLimits) {
  Tried tried;
  check_property(many_sequences, [&] {
    const std::optional<FittingMove> fitting = fitting_move(160, true);
    if (!fitting) return;
    const auto& [plan, report] = *fitting;
    const double rate = *rc::gen::arbitrary<bool>() ? std::clamp(report.highest_rate, 1.0, 1.3) : 1.0;
    const PlannedStops stops(plan, rate);
    if (stops.obstacle()) {
      // Beside a cusp, where a peak lasts shorter than time is known, its bound may be far above it.
      RC_ASSERT(stops.obstacle()->value > stops.obstacle()->limit);
      ++tried.refused;
      return;
    }
    ++tried.played;
    if (!plan.is_whole()) ++tried.parts;
    if (plan.played().first_frame() < plan.part().first) ++tried.with_rolls;
    if (rate > 1) ++tried.faster;
    play_at_random(plan, stops, report, tried);
  });
  std::cout << tried.played << " moves played, " << tried.parts << " of them parts, " << tried.with_rolls
            << " of them from a pre-roll, " << tried.faster << " faster than drawn; " << tried.refused
            << " refused; " << tried.exposures << " exposures in motion; " << tried.excused
            << " ticks across a step that was listed\n";
  if (!counts_mean_something()) return;
  EXPECT_GT(tried.played, many_sequences / 10);
  EXPECT_GT(tried.parts, tried.played / 5);
  EXPECT_GT(tried.exposures, 0);
  EXPECT_LE(tried.refused, tried.played / 5);
}

// --- what is no stop

struct Gentle {
  int played = 0;
  int refused = 0;
  int finished = 0;
  double acceleration_share = 0;
  double jerk_share = 0;
};

/// Until a stop has come to rest, or until its rate change is gone if it is taken back, the stop limits hold.
class StopWatch {
 public:
  void stops(const Playhead& playhead) {
    is_stop_ = !playhead.is_resting();
    sign_ = playhead.rate() < 0 ? -1 : 1;
  }
  bool takes(const Playhead& playhead) {
    const bool is_taken_back = playhead.state() != PlayheadState::slowing && !playhead.is_turning();
    if (playhead.is_resting() || (is_taken_back && sign_ * playhead.rate_change() >= 0)) is_stop_ = false;
    return !is_stop_;
  }

 private:
  bool is_stop_ = false;
  int sign_ = 1;
};

void play_gently(StagedMove& staged, const Plan& held_to, const CheckReport& report, double rate,
                 Gentle& tried) {
  Playhead& playhead = staged.playhead();
  const PlannedStops wide(staged.plan(), rate);
  RecordedPlay record(held_to, *wide.bounds(), 1.0 / held_to.rig()->rate_hz);
  record.allow_steps_of(report);
  StopWatch watch;
  RC_ASSERT(playhead.play(Direction::forward).has_value());
  for (int tick = 0; tick < ticks; ++tick) {
    if (*rc::gen::inRange(0, 60) == 0) {
      switch (*rc::gen::inRange(0, 6)) {
        case 0:
        case 1:
          static_cast<void>(playhead.play(Direction::forward));
          break;
        case 2:
          playhead.stop();
          watch.stops(playhead);
          break;
        case 3:
          static_cast<void>(playhead.play(Direction::backward));
          break;
        default:
          static_cast<void>(playhead.set_override(rate * *rc::gen::inRange(1, 101) / 100.0));
      }
      if (playhead.is_turning()) watch.stops(playhead);
    }
    const PlayheadEvent event = playhead.tick();
    if (event == PlayheadEvent::finished) ++tried.finished;
    if (!watch.takes(playhead)) {
      record.restart();
      continue;
    }
    record.take(playhead);
    if (!record.complaint().empty()) RC_FAIL("tick " + std::to_string(tick) + ": " + record.complaint());
  }
  tried.acceleration_share = std::max(tried.acceleration_share, record.acceleration_share());
  tried.jerk_share = std::max(tried.jerk_share, record.jerk_share());
}

TEST(PlayheadProperty, WhatIsNoStopKeepsTheMotionLimits) {
  Gentle tried;
  check_property(many_sequences, [&] {
    const std::optional<FittingMove> fitting = fitting_move(300, true);
    if (!fitting) return;
    const auto& [plan, report] = *fitting;
    const double rate = *rc::gen::arbitrary<bool>() ? std::clamp(report.highest_rate, 1.0, 1.3) : 1.0;
    std::unique_ptr<StagedMove> staged;
    try {
      staged = std::make_unique<StagedMove>(plan, StagedMove::stops_of(plan, rate));
    } catch (const LimitError&) {
      ++tried.refused;
      return;
    }
    ++tried.played;
    play_gently(*staged, without_stop_limits(plan), report, rate, tried);
  });
  std::cout << tried.played << " moves played, " << tried.refused << " refused, " << tried.finished
            << " ends reached; at most " << tried.acceleration_share << " of the acceleration, "
            << tried.jerk_share << " of the jerk\n";
  if (!counts_mean_something()) return;
  EXPECT_GT(tried.played, many_sequences / 10);
  EXPECT_GE(tried.acceleration_share, 0.9);
}

}  // namespace playhead_property_test
}  // namespace inbetween
