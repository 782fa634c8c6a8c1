// What a playhead did, in whatever way it was told to, another one does again to the last bit, and may be
// stopped on the way.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
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

namespace inbetween {
namespace followed_playhead_property_test {

constexpr int many_moves = 600;

void command(Playhead& playhead, const Move& move, double rate) {
  const auto frame = [&] { return *rc::gen::inRange(move.first_frame(), move.last_frame() + 1); };
  switch (*rc::gen::inRange(0, 6)) {
    case 0:
      static_cast<void>(playhead.play(Direction::backward));
      break;
    case 1:
      playhead.stop();
      break;
    case 2:
      static_cast<void>(playhead.go_to(frame()));
      break;
    case 3:
      static_cast<void>(playhead.set_override(rate * *rc::gen::inRange(1, 101) / 100.0));
      break;
    default:
      static_cast<void>(playhead.play(Direction::forward));
  }
}

/// From the beginning, through whatever it is told in so many ticks, to a rest.
std::vector<PlayheadPlace> played(Playhead& playhead, const Move& move, double rate) {
  std::vector<PlayheadPlace> places;
  const int busy = *rc::gen::inRange(1, 600);
  for (int tick = 0; tick < 10'000'000; ++tick) {
    if (tick == 0) {
      static_cast<void>(playhead.play(Direction::forward));
    } else if (tick < busy && *rc::gen::inRange(0, 50) == 0) {
      command(playhead, move, rate);
    } else if (tick == busy) {
      playhead.stop();
    }
    static_cast<void>(playhead.tick());
    places.push_back(place_of(playhead));
    if (tick >= busy && playhead.is_resting()) break;
  }
  return places;
}

/// Stopped in a tick of them it comes to rest inside the stop limits.
void stop_on_the_way(StagedMove& staged, const CheckReport& report, double rate,
                     const std::vector<PlayheadPlace>& places) {
  const Plan& plan = staged.plan();
  const PlannedStops wide(plan, rate);
  RecordedPlay record(plan, *wide.bounds(), 1.0 / plan.rig()->rate_hz);
  record.allow_steps_of(report);
  Playhead& playhead = staged.playhead();
  RC_ASSERT(playhead.follow(places).has_value());
  const auto last = *rc::gen::inRange<std::size_t>(0, places.size());
  for (std::size_t i = 0; i < last; ++i) {
    static_cast<void>(playhead.tick());
    record.take(playhead);
  }
  playhead.stop();
  for (int tick = 0; !playhead.is_resting() && tick < 10'000'000; ++tick) {
    static_cast<void>(playhead.tick());
    record.take(playhead);
  }
  RC_ASSERT(playhead.is_resting());
  if (!record.complaint().empty()) RC_FAIL(record.complaint());
}

/// A jump of time, and a jump of the rate in the middle, are not what a playhead does.
void refuses_what_no_playhead_does(const Plan& plan, const Playhead& playhead,
                                   std::vector<PlayheadPlace> places) {
  if (places.size() < 3) return;
  const auto at = *rc::gen::inRange<std::size_t>(1, places.size() - 1);
  const auto is_end = [&](const PlayheadPlace& place) {
    return place.time == FrameTime{plan.played().first_frame(), 0} ||
           place.time == FrameTime{plan.played().last_frame(), 0};
  };
  if (is_end(places[at - 1]) || is_end(places[at]) || is_end(places[at + 1])) return;
  std::vector<PlayheadPlace> cut = places;
  cut[at].time = moved_by(cut[at].time, 3);
  RC_ASSERT(!playhead.can_follow(cut).has_value());
  cut = places;
  cut[at].rate += cut[at].rate > 0.3 ? -0.6 : 0.6;
  RC_ASSERT(!playhead.can_follow(cut).has_value());
  places.resize(at);
  const PlayheadPlace& last = places.back();
  RC_ASSERT(playhead.can_follow(places).has_value() == (last.rate == 0 && last.rate_change == 0));
}

TEST(FollowedPlayheadProperty, DoesWhatAnotherDidToTheLastBitAndStopsInsideTheStopLimits) {
  int tried = 0;
  std::size_t ticks = 0;
  check_property(many_moves, [&] {
    const std::optional<FittingMove> fitting = fitting_move(160, true);
    if (!fitting) return;
    const auto& [plan, report] = *fitting;
    const double rate = *rc::gen::arbitrary<bool>() ? std::clamp(report.highest_rate, 1.0, 1.3) : 1.0;
    std::shared_ptr<const PlannedStops> stops;
    try {
      stops = StagedMove::stops_of(plan, rate);
    } catch (const LimitError&) {
      return;
    }
    StagedMove first(plan, stops), again(plan, stops), stopped(plan, stops), refused(plan, stops);
    const std::vector<PlayheadPlace> places = played(first.playhead(), plan.played(), rate);
    ++tried;
    ticks += places.size();
    const Status followed = again.playhead().can_follow(places);
    if (!followed)
      RC_FAIL("refused place " + std::to_string(followed.error().needed) + " of " +
              std::to_string(places.size()));
    RC_ASSERT(again.playhead().follow(places).has_value());
    PlayheadEvent event = PlayheadEvent::none;
    for (const PlayheadPlace& place : places) {
      RC_ASSERT(event == PlayheadEvent::none);
      event = again.playhead().tick();
      RC_ASSERT(place_of(again.playhead()) == place);
    }
    RC_ASSERT(event != PlayheadEvent::none);
    RC_ASSERT(again.playhead().is_resting());
    stop_on_the_way(stopped, report, rate, places);
    refuses_what_no_playhead_does(plan, refused.playhead(), places);
  });
  std::cout << tried << " moves, " << ticks << " ticks followed\n";
  if (counts_mean_something()) {
    EXPECT_GT(tried, many_moves / 10);
  }
}

}  // namespace followed_playhead_property_test
}  // namespace inbetween
