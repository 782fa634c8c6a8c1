#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/check/planned_stops.hpp"
#include "host_tools/fit/speed_fit.hpp"
#include "inbetween/play/playhead.hpp"
#include "tests/support/recorded_play.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/timing_kinds.hpp"

/// Every way of timing a move against what holds for all of them: the certificate, the rolls, stops, the fit.

namespace inbetween {
namespace every_timing_test {

/// The largest differences of the positions of an axis, per second and second^2, 32 to a frame: means of what
/// they approximate, and never above its peak.
struct Sampled {
  double lowest = 0, highest = 0, velocity = 0, acceleration = 0;
};
Sampled sampled(const Plan& plan, std::size_t axis, std::int32_t first_frame, std::int32_t last_frame) {
  constexpr int per_frame = 32;
  const double step_s = 1.0 / (24 * per_frame);
  std::vector<double> at;
  std::vector<double> positions(2);
  for (std::int32_t frame = first_frame; frame < last_frame; ++frame) {
    for (int part = 0; part < per_frame; ++part) {
      plan.motion().positions({frame, static_cast<double>(part) / per_frame}, positions);
      at.push_back(positions[axis]);
    }
  }
  plan.motion().positions({last_frame, 0}, positions);
  at.push_back(positions[axis]);
  Sampled peaks{*std::ranges::min_element(at), *std::ranges::max_element(at)};
  for (std::size_t i = 1; i + 1 < at.size(); ++i) {
    const double second = at[i + 1] - 2 * at[i] + at[i - 1];
    peaks.velocity = std::max(peaks.velocity, std::fabs(at[i] - at[i - 1]) / step_s);
    peaks.acceleration = std::max(peaks.acceleration, std::fabs(second) / (step_s * step_s));
  }
  return peaks;
}

class EveryTiming : public testing::TestWithParam<TimingKind> {
 protected:
  /// On a rig whose limits are `share` of what the move takes between its ends; all of it, or some frames.
  [[nodiscard]] static Plan plan(double share, const FrameRange& frames = {}) {
    const MoveFile move = move_of(GetParam());
    const Plan free(move, std::nullopt, {});
    std::vector<AxisText> axes{{.name = "x"}, {.name = "y"}};
    for (const std::size_t d : {0U, 1U}) {
      const Sampled peaks = sampled(free, d, 0, 48);
      axes[d].min = -1000;
      axes[d].max = 1000;
      axes[d].max_velocity = share * peaks.velocity;
      axes[d].max_acceleration = share * std::max(peaks.acceleration, peaks.velocity);
    }
    return {move, parse_rig(rig_text(axes, {.rate_hz = 480}), "r.toml"), {.frames = frames}};
  }
};

void expect_certified(const Plan& plan) {
  const CheckReport report = check(plan);
  ASSERT_TRUE(report.fits()) << report.refusals.front().message();
  const Move& move = plan.played();
  for (const std::size_t d : {0U, 1U}) {
    const Sampled found = sampled(plan, d, move.first_frame(), move.last_frame());
    const CheckedAxis& axis = report.axes[d];
    EXPECT_LE(found.velocity, axis.velocity.value * (1 + 1e-5));
    EXPECT_GE(found.velocity, axis.velocity.value * 0.98);
    EXPECT_LE(found.acceleration, axis.acceleration.value * (1 + 1e-4) + 1e-4);
    EXPECT_GE(found.acceleration, axis.acceleration.value * 0.95 - 1e-4);
    EXPECT_LE(axis.range->lowest.value, found.lowest + 1e-9);
    EXPECT_GE(axis.range->highest.value, found.highest - 1e-9);
  }
}

TEST_P(EveryTiming, IsCertifiedForWhatItDoesWithItsRolls) {
  const Plan plan = this->plan(2.5);
  expect_certified(plan);
  EXPECT_EQ(plan.played().first_frame() < 0, GetParam().rolls);
}

/// Some of them begin or end on keys, in holds, or where a hold begins or ends.
constexpr std::array<WholeFrames, 7> parts{
    {{5, 20}, {13, 30}, {14, 33}, {17, 48}, {0, 14}, {20, 41}, {30, 48}}};

TEST_P(EveryTiming, APartOfItIsCertifiedForWhatItDoesWithRollsOfItsOwn) {
  const Plan whole = plan(3);
  std::vector<double> of_part(2), of_whole(2);
  for (const auto& [first, last] : parts) {
    SCOPED_TRACE(testing::Message() << first << ".." << last);
    const Plan part = plan(3, {first, last});
    expect_certified(part);
    for (std::int32_t frame = first; frame <= last; ++frame) {
      for (const double fraction : {0.0, 0.37}) {
        if (frame == last && fraction > 0) continue;
        part.motion().positions({frame, fraction}, of_part);
        whole.motion().positions({frame, fraction}, of_whole);
        EXPECT_EQ(of_part, of_whole) << "to the last bit on frame " << frame + fraction;
      }
    }
  }
}

void expect_foretold_stops(const Plan& plan) {
  const CheckReport report = check(plan);
  ASSERT_TRUE(report.fits()) << report.refusals.front().message();
  const PlannedStops stops(plan);
  ASSERT_TRUE(stops.bounds().has_value());
  const std::int32_t rate_hz = plan.rig()->rate_hz;
  const double tick_s = 1.0 / rate_hz;
  Playhead playhead(plan.played(), *stops.bounds(), rate_hz);
  RecordedPlay record(plan, *stops.bounds(), tick_s);
  const auto take = [&] {
    static_cast<void>(playhead.tick());
    record.take(playhead);
  };
  for (const Direction direction : {Direction::forward, Direction::backward}) {
    int tries = 0;
    while (playhead.play(direction) && tries++ < 20) {
      for (int tick = 0; tick < 61; ++tick) take();
      const StopLength foretold = stops.bounds()->stop_from(playhead.time(), direction == Direction::forward);
      playhead.stop();
      int needed = 0;
      for (; !playhead.is_resting() && needed < 100'000; ++needed) take();
      EXPECT_LE(needed * tick_s, foretold.seconds + 3 * tick_s);
    }
  }
  EXPECT_EQ(record.complaint(), "");
  EXPECT_GT(record.acceleration_share(), 0.3) << "nothing was asked of it";
}

TEST_P(EveryTiming, StopsFromAnywhereWithinItsStopLimitsWhenItWasForetold) {
  expect_foretold_stops(plan(1.5));
  expect_foretold_stops(plan(1.5, {5, 20}));
}

TEST_P(EveryTiming, IsFittedWhereItHasADrawnSpeedAndElseTellsWhyNot) {
  const Plan plan = this->plan(0.9);
  const CheckReport report = check(plan);
  ASSERT_FALSE(report.fits());
  const SpeedFit fit = fit_speed(plan, report, {});
  if (!GetParam().is_drawn) {
    EXPECT_THAT(fit.reason, testing::HasSubstr("no speed curve to change"));
    return;
  }
  ASSERT_TRUE(fit.found) << fit.reason;
  MoveFile fitted = plan.move();
  replace_curve(fitted.tracks.front(), fit.tracks.front().speed);
  const Plan again(fitted, plan.rig(), {});
  EXPECT_TRUE(check(again).fits());
  const std::vector<double>& played = again.tracks().front().control_values();
  if (fitted.tracks.front().periodic) {
    EXPECT_EQ(played.front(), played.back());
  }
  ASSERT_EQ(played.size(), fit.tracks.front().speed.size());
  for (std::size_t i = 0; i < played.size(); ++i) {
    EXPECT_NEAR(played[i], fit.tracks.front().speed[i], 1e-5) << "the file plays another curve";
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, EveryTiming, testing::ValuesIn(timing_kinds()),
                         [](const auto& test) { return test.param.name; });

}  // namespace every_timing_test
}  // namespace inbetween
