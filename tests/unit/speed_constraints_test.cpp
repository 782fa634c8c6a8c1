#include "host_tools/fit/speed_constraints.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "host_tools/plan/plan.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace speed_constraints_test {

const std::vector<double> drawn = {0, 0, 6, 16, 6, 7, 0, 0};

Plan plan_of(const std::string& spline) {
  std::vector<AxisText> axes{{.name = "x"}, {.name = "y"}};
  for (AxisText& axis : axes) {
    axis.max_velocity = 200;
    axis.max_acceleration = 700;
    axis.more = "max_jerk = 9000\nmax_acceleration_step = 50";
  }
  const std::string move =
      "name = \"m\"\nfps = 24\nframes = 96\n[[track]]\naxes = [\"x\", \"y\"]\nspline = \"" + spline +
      "\"\nkeys = [ { at = [10, 0] }, { at = [60, 40] }, { at = [110, -20] }, { at = [160, 10] } ]\n"
      "weights = [1, 2]\nspeed = [0, 0, 6, 16, 6, 7, 0, 0]\n";
  return {parse_move(move, "move.toml"), parse_rig(rig_text(axes), "rig.toml"), {}};
}

TEST(MotionSamples, AreTheSharesOfTheMotion) {
  const Plan plan = plan_of("smooth");
  const Track& track = plan.tracks()[0].track();
  MotionSamples samples(track, plan.rig()->axes, 0, {});
  samples.evaluate(ControlCurve(drawn));
  constexpr std::array<double, 3> limits = {200, 700, 9000};
  std::vector<AxisMotion> motion(2);
  int compared = 0;
  for (const Moment& moment : samples.moments()) {
    const double frame = (moment.place.span + moment.place.t) * 96 / 7;
    const FrameTime time{static_cast<std::int32_t>(frame), frame - std::floor(frame)};
    const double t = track.locate(time).t;
    if (t < 1e-4 || t > 1 - 1e-4) continue;  // on which side of a key, rounding decides
    track.motion(time, motion);
    for (std::size_t i = moment.first; i < moment.end; ++i) {
      const LimitedValue& value = samples.values()[i];
      const AxisMotion& axis = motion[value.axis];
      const std::array<double, 3> rates = {axis.velocity, axis.acceleration, axis.jerk};
      const auto q = static_cast<std::size_t>(value.quantity);
      EXPECT_NEAR(value.share, rates.at(q) / limits.at(q), 1e-4) << q << " at frame " << frame;
      ++compared;
    }
  }
  EXPECT_GT(compared, 1000);
}

TEST(MotionSamples, TellHowTheSharesFollowTheCurve) {
  for (const std::string spline : {"smooth", "catmull-rom"}) {
    const Plan plan = plan_of(spline);
    MotionSamples samples(plan.tracks()[0].track(), plan.rig()->axes, 0, {.begin = true, .end = true});
    samples.evaluate(ControlCurve(drawn));
    const std::vector<Moment> moments(samples.moments().begin(), samples.moments().end());
    const std::vector<LimitedValue> values(samples.values().begin(), samples.values().end());
    std::vector<double> change = {0, 0, 1, -1, 0.5, 0, 0, 0};
    const double rest = ControlCurve(change).total();
    change[5] -= rest;  // at equal Phi(f)
    std::vector<double> moved = drawn;
    constexpr double step = 1e-6;
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i] += step * change[i];
    samples.evaluate(ControlCurve(moved));
    ASSERT_EQ(samples.moments().size(), moments.size());
    ASSERT_EQ(samples.values().size(), values.size());
    const ControlCurve by(change);
    for (std::size_t m = 0; m < moments.size(); ++m) {
      const CurveValues at = by.at(moments[m].place);
      const double a = moments[m].place.span + moments[m].place.t;
      if (std::abs(a - std::round(a)) < 1e-5) continue;  // phi''' steps at knots
      for (std::size_t i = moments[m].first; i < moments[m].end; ++i) {
        const CurveWeights& w = values[i].weights;
        const double expected =
            w.area * at.area + w.value * at.value + w.first * at.first + w.second * at.second;
        const double seen = (samples.values()[i].share - values[i].share) / step;
        EXPECT_NEAR(seen, expected, 1e-2 * (1 + std::abs(expected)))
            << spline << ' ' << a << ' ' << static_cast<int>(values[i].quantity);
      }
    }
  }
}

}  // namespace speed_constraints_test
}  // namespace inbetween
