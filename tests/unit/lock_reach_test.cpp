#include "host_tools/fit/lock_reach.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/fit/fewest_frames.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace lock_reach_test {

struct Limits {
  double velocity = 0;
  double acceleration = 0;
};

Plan plan_of(const std::string& track, int frames, const std::vector<Limits>& limits) {
  std::vector<AxisText> axes;
  std::string names;
  for (const Limits& of_axis : limits) {
    AxisText axis{.name = std::string(1, static_cast<char>('x' + axes.size()))};
    axis.min = -1e4;
    axis.max = 1e4;
    axis.max_velocity = of_axis.velocity;
    axis.max_acceleration = of_axis.acceleration;
    names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", axis.name);
    axes.push_back(axis);
  }
  const std::string move =
      fmt::format("name = \"m\"\nfps = 10\nframes = {}\n[[track]]\naxes = [{}]\n{}", frames, names, track);
  return {parse_move(move, "move.toml"), parse_rig(rig_text(axes), "rig.toml"), {}};
}

/// Keys 100 mm apart on a line. The frames of all but the first and the last are given.
std::string line_of(const std::vector<int>& frames, const std::string& speed = "speed = [1, 1]\n") {
  std::string keys = "keys = [ { at = [0] }";
  double position = 0;
  for (const int frame : frames) keys += fmt::format(", {{ at = [{}], frame = {} }}", position += 100, frame);
  return keys + fmt::format(", {{ at = [{}] }} ]\n", position + 100) + speed;
}
std::optional<UnreachedLock> unreached(const std::string& track, int frames, const Limits& limits) {
  return unreached_lock(plan_of(track, frames, {limits}), 0);
}

TEST(UnreachedLock, ASpeedThatCannotBeLeftInTime) {
  // 100 mm in 6 s and 100 mm in 14 s: in their middles, 10 s apart, the velocity is 16.7 and 7.1 mm/s.
  const std::string uneven = line_of({60});
  EXPECT_FALSE(unreached(uneven, 200, {1000, 1.0}));
  const std::optional<UnreachedLock> told = unreached(uneven, 200, {1000, 0.9});
  ASSERT_TRUE(told);
  EXPECT_EQ(told->begin_key, 0);
  EXPECT_EQ(told->begin_frame, 0);
  EXPECT_EQ(told->end_key, 2);
  EXPECT_EQ(told->end_frame, 200);
  EXPECT_EQ(told->axis, 0U);
  EXPECT_FALSE(shortest_stretch(plan_of(uneven, 200, {{1000, 0.9}}), 0)) << "each stretch alone is possible";
  EXPECT_FALSE(unreached(line_of({100}), 200, {1000, 1e-3})) << "even";
}

TEST(UnreachedLock, OnlyTheLocksThatProveItAreTold) {
  const std::optional<UnreachedLock> told = unreached(line_of({100, 200, 260, 400, 500}), 600, {1000, 0.9});
  ASSERT_TRUE(told);
  EXPECT_EQ(told->begin_key, 2);
  EXPECT_EQ(told->begin_frame, 200);
  EXPECT_EQ(told->end_key, 4);
  EXPECT_EQ(told->end_frame, 400);
}

TEST(UnreachedLock, AnAxisThatDoesNotTurnGoesNotBackEither) {
  // 100 mm in 1 s, and then 1 mm in 9 s.
  const std::string keys =
      "keys = [ { at = [0] }, { at = [100], frame = 10 }, { at = [101] } ]\nspeed = [1, 1]\n";
  EXPECT_TRUE(unreached(keys, 100, {1000, 50})) << "75 mm/s at least at the key, and 56 mm to a rest";
  EXPECT_FALSE(unreached(keys, 100, {1000, 200}));
}

TEST(UnreachedLock, AHoldIsARest) {
  const std::string keys =
      "keys = [ { at = [0] }, { at = [100], frame = 50, hold = 100 }, { at = [200] } ]\nspeed = [1, 1]\n";
  EXPECT_FALSE(unreached(keys, 200, {30, 10}));
  EXPECT_FALSE(unreached(keys, 200, {1000, 8.01})) << "100 mm are 8 / 2 mm/s^2 times (5 s)^2";
  EXPECT_TRUE(unreached(keys, 200, {1000, 7.99}));
}

TEST(UnreachedLock, AllAxesHaveOneSpeedAlongThePath) {
  const std::string keys =
      "spline = \"linear\"\nkeys = [ { at = [0, 0] }, { at = [100, 100], frame = 100 }, { at = [200, 200] } "
      "]\n"
      "speed = [1, 1]\n";
  EXPECT_FALSE(unreached_lock(plan_of(keys, 200, {{1000, 1}, {1000, 1}}), 0));
  const std::string uneven =
      "spline = \"linear\"\nkeys = [ { at = [0, 0] }, { at = [100, 1], frame = 60 }, { at = [200, 2] } ]\n"
      "speed = [1, 1]\n";
  const std::optional<UnreachedLock> told =
      unreached_lock(plan_of(uneven, 200, {{1000, 100}, {1000, 0.005}}), 0);
  ASSERT_TRUE(told);
  EXPECT_EQ(told->axis, 1U);
}

TEST(UnreachedLock, AtACornerItIsAtRest) {
  const std::string there_and_back =
      "spline = \"linear\"\nkeys = [ { at = [0] }, { at = [100], frame = 100 }, { at = [0] } ]\nspeed = [1, "
      "1]\n";
  EXPECT_FALSE(unreached(there_and_back, 200, {20, 2.0}));
  EXPECT_FALSE(unreached(there_and_back, 200, {11, 6.1})) << "11 mm/s for 10 s, less 11^2 / 2 / 6.1 mm";
  EXPECT_TRUE(unreached(there_and_back, 200, {11, 6.0})) << "it is at rest in the corner";
}

TEST(UnreachedLock, WithoutLocksNothingIsTold) {
  EXPECT_FALSE(unreached("keys = [ { at = [0] }, { at = [100] } ]\nspeed = [1, 1]\n", 10, {1, 1}));
}

/// Every plan keeps limits that are its own peaks: what is done is not impossible.
TEST(LimitsOfLocks, AreNeverToldToExcludeAMotionThatKeepsThem) {
  std::mt19937 random(7);
  const auto number = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int tried = 0;
  for (int i = 0; i < 400; ++i) {
    const int keys = 4 + i % 5;
    const int frames = 30 * keys;
    std::string track = i % 3 == 0 ? "spline = \"catmull_rom\"\nkeys = [" : "keys = [";
    for (int k = 0; k < keys; ++k) {
      track += fmt::format("{}{{ at = [{:.3f}, {:.3f}]", k == 0 ? "" : ", ", 40 * k + number(-15, 15),
                           number(0, 60));
      if (k > 0 && k + 1 < keys && number(0, 1) < 0.7) {
        track += fmt::format(", frame = {}", frames * k / (keys - 1) + static_cast<int>(number(-6, 6)));
        if (number(0, 1) < 0.2) track += ", hold = 5";
      }
      track += " }";
    }
    track += i % 2 == 0 ? "]\nspeed = [0, 0" : "]\nspeed = [3";
    for (int k = 0; k < 6; ++k) track += fmt::format(", {:.2f}", number(1, 4));
    track += i % 2 == 0 ? ", 0, 0]\n" : "]\n";
    std::vector<Limits> limits(2, {1e6, 1e9});
    try {
      const CheckReport report = check(plan_of(track, frames, limits));
      if (!report.fits()) continue;  // a corner
      for (std::size_t d = 0; d < limits.size(); ++d)
        limits[d] = {report.axes[d].velocity.value, report.axes[d].acceleration.value};
    } catch (const std::exception&) {
      continue;  // no curve meets these locks
    }
    const Plan plan = plan_of(track, frames, limits);
    ++tried;
    EXPECT_LE(fewest_frames(plan).frames, frames) << track;
    EXPECT_FALSE(shortest_stretch(plan, 0)) << track;
    EXPECT_FALSE(unreached_lock(plan, 0)) << track;
  }
  EXPECT_GE(tried, 200);
}

}  // namespace lock_reach_test
}  // namespace inbetween
