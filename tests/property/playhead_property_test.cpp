#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <iostream>
#include <optional>

#include "host_tools/check.hpp"
#include "host_tools/planned_stops.hpp"
#include "inbetween/playhead.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random_move.hpp"
#include "tests/support/recorded_play.hpp"
#include "tests/support/rig_near.hpp"

/// Commands in any order at any time: the axes stay inside their stop limits, and a stop ends when it was
/// foretold.

namespace inbetween {
namespace {

constexpr int many_sequences = 400;
constexpr int ticks = 1000;

void command(Playhead<double>& playhead, const Move<double>& move) {
  const auto frame = [&] { return *rc::gen::inRange(move.first_frame(), move.last_frame() + 1); };
  const auto direction = [] {
    return *rc::gen::arbitrary<bool>() ? Direction::forward : Direction::backward;
  };
  switch (*rc::gen::inRange(0, 8)) {
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
      static_cast<void>(playhead.set_override(*rc::gen::inRange(1, 101) / 100.0));
      break;
    case 6:
      static_cast<void>(playhead.scrub_to({frame(), 0}));
      break;
    default:
      static_cast<void>(
          playhead.set_repeat(*rc::gen::element(Repeat::none, Repeat::loop, Repeat::ping_pong)));
  }
}

TEST(PlayheadProperty, AnyCommandsAtAnyTimeKeepTheStopLimits) {
  int played = 0;
  int with_rolls = 0;
  int refused = 0;
  check_property(many_sequences, [&] {
    const RandomMove random = *regular_move();
    const std::optional<MoveFile> move = for_a_rig(random);
    if (!move) return;
    const std::optional<RigFile> rig =
        rig_near(*move, {.share = [] { return *rc::gen::inRange(102, 160) / 100.0; },
                         .limits_jerk = *rc::gen::arbitrary<bool>(),
                         .rate_hz = *rc::gen::element(100, 250, 1000)});
    if (!rig) return;
    const Plan plan(*move, rig, {});
    if (!check(plan).fits()) return;
    const PlannedStops stops(plan);
    if (stops.obstacle()) {
      // Beside a cusp, where a peak lasts shorter than time is known, its bound may be far above it.
      RC_ASSERT(stops.obstacle()->value > stops.obstacle()->limit);
      ++refused;
      return;
    }
    ++played;
    if (plan.played().first_frame() < 0) ++with_rolls;
    Playhead<double> playhead(plan.played(), *stops.bounds(), rig->rate_hz);
    const double tick_s = 1.0 / rig->rate_hz;
    RecordedPlay record(plan, *stops.bounds(), tick_s);
    RC_ASSERT(playhead.play(Direction::forward).has_value());
    for (int tick = 0; tick < ticks; ++tick) {
      if (*rc::gen::inRange(0, 40) == 0) command(playhead, plan.played());
      static_cast<void>(playhead.tick());
      record.take(playhead);
      if (!record.complaint().empty()) RC_FAIL("tick " + std::to_string(tick) + ": " + record.complaint());
    }
    const bool forward = playhead.rate() >= 0;
    const StopLength<double> foretold = stops.bounds()->stop_from(playhead.time(), forward);
    playhead.stop();
    int needed = 0;
    for (; !playhead.is_resting() && needed < 10'000'000; ++needed) static_cast<void>(playhead.tick());
    RC_ASSERT(playhead.is_resting());
    RC_ASSERT(needed * tick_s <= foretold.seconds + 3 * tick_s);
  });
  std::cout << played << " moves played, " << with_rolls << " of them from a pre-roll, " << refused
            << " refused\n";
  if (!counts_mean_something()) return;
  EXPECT_GT(played, many_sequences / 10);
  EXPECT_LE(refused, played / 5);
}

}  // namespace
}  // namespace inbetween
