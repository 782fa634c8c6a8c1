#include "host_tools/fit/fewest_frames.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "host_tools/check/check.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace fewest_frames_test {

Plan plan_of(const std::string& track, double velocity, double acceleration, int frames = 100) {
  const std::string move =
      fmt::format("name = \"m\"\nfps = 10\nframes = {}\n[[track]]\naxes = [\"x\", \"y\"]\n{}", frames, track);
  std::vector<AxisText> axes{{.name = "x"}, {.name = "y"}};
  for (AxisText& axis : axes) {
    axis.min = -1e4;
    axis.max = 1e4;
    axis.max_velocity = velocity;
    axis.max_acceleration = acceleration;
  }
  return {parse_move(move, "move.toml"), parse_rig(rig_text(axes), "rig.toml"), {}};
}

const std::string rests = "speed = [0, 0, 1, 0, 0]\n";
const std::string moves = "speed = [1, 1]\n";
const std::string line = "keys = [ { at = [0, 5] }, { at = [100, 5] } ]\n";

TEST(FewestFrames, ADistanceAtFullVelocity) {
  const FewestFrames least = fewest_frames(plan_of(line + moves, 20, 1e6));
  EXPECT_EQ(least.frames, 50) << "100 mm at 20 mm/s are 5 s";
  EXPECT_EQ(least.axis, 0U);
  EXPECT_FALSE(least.by_acceleration);
}

TEST(FewestFrames, FromRestToRestItTakesTheRampsToo) {
  EXPECT_EQ(fewest_frames(plan_of(line + rests, 20, 10)).frames, 70) << "5 s and a ramp of 2 s";
  const std::string shorter = "keys = [ { at = [0, 5] }, { at = [60, 5] } ]\n";
  EXPECT_EQ(fewest_frames(plan_of(shorter + rests, 20, 10)).frames, 50) << "3 s and the ramp";
  EXPECT_EQ(fewest_frames(plan_of(line + rests, 1e6, 16)).frames, 50)
      << "no full velocity: 2 sqrt(100 / 16) s";
  EXPECT_TRUE(fewest_frames(plan_of(line + rests, 1e6, 16)).by_acceleration);
  EXPECT_EQ(fewest_frames(plan_of(line + "speed = [0, 0, 1, 1]\n", 20, 10)).frames, 60) << "one ramp";
}

TEST(FewestFrames, WhereAnAxisTurnsItStandsStill) {
  const std::string there_and_back =
      "spline = \"linear\"\nkeys = [ { at = [0, 0] }, { at = [100, 0] }, { at = [0, 0] } ]\n";
  const FewestFrames least = fewest_frames(plan_of(there_and_back + moves, 20, 10));
  EXPECT_EQ(least.frames, 120) << "twice 5 s and a ramp on either side of the turn";
}

TEST(FewestFrames, AnotherAxisMayBeInTheWayOnAnotherStretch) {
  const std::string corner =
      "spline = \"linear\"\nkeys = [ { at = [0, 0] }, { at = [100, 0] }, { at = [100, 60] } ]\n";
  const FewestFrames least = fewest_frames(plan_of(corner + moves, 20, 1e6));
  EXPECT_EQ(least.frames, 80);
  EXPECT_EQ(least.axis, 0U) << "for most of the time";
}

TEST(FewestFrames, AKeyWithinRoundingOfALineIsNoTurn) {
  const std::string still = "keys = [ { at = [0, 5] }, { at = [50, 5.0000000000001] }, { at = [100, 5] } ]\n";
  EXPECT_EQ(fewest_frames(plan_of(still + moves, 20, 1e-3)).axis, 0U);
}

TEST(FewestFrames, APathWithoutLengthTakesOneFrame) {
  EXPECT_EQ(fewest_frames(plan_of("keys = [ { at = [1, 2] } ]\n" + moves, 20, 10)).frames, 1);
}

// --- from one locked key to the next

std::string three_keys(const std::string& request_of_second) {
  return "keys = [ { at = [0, 5] }, { at = [100, 5]" + request_of_second + " }, { at = [200, 5] } ]\n";
}
std::optional<ShortStretch> shortest_of(const std::string& track) {
  return shortest_stretch(plan_of(track, 20, 10, 200), 0);
}
bool is_short(const std::string& track) {
  return shortest_of(track).has_value();
}

TEST(ShortestStretch, IsTheOneThatMissesTheLargestShareOfItsFrames) {
  const std::optional<ShortStretch> early = shortest_of(three_keys(", frame = 40") + moves);
  ASSERT_TRUE(early.has_value());
  EXPECT_EQ(early->begin_key, 0);
  EXPECT_EQ(early->end_key, 1);
  EXPECT_EQ(early->begin_frame, 0);
  EXPECT_EQ(early->end_frame, 40);
  EXPECT_NEAR(early->needed, 50, 1e-6) << "100 mm at 20 mm/s are 5 s";
  EXPECT_EQ(early->axis, 0U);
  EXPECT_FALSE(early->by_acceleration);
  const std::optional<ShortStretch> late = shortest_of(three_keys(", frame = 155") + moves);
  ASSERT_TRUE(late.has_value());
  EXPECT_EQ(late->begin_key, 1);
  EXPECT_EQ(late->end_key, 2);
}

TEST(ShortestStretch, AHoldIsARestAndTakesItsFramesFromThePathBehindIt) {
  EXPECT_FALSE(is_short(three_keys(", frame = 61, hold = 79") + moves));
  const std::optional<ShortStretch> before = shortest_of(three_keys(", frame = 59, hold = 79") + moves);
  ASSERT_TRUE(before.has_value());
  EXPECT_NEAR(before->needed, 60, 1e-6) << "5 s, and 1 s because of the ramp down to the hold";
  EXPECT_TRUE(before->by_acceleration);
  const std::optional<ShortStretch> behind = shortest_of(three_keys(", frame = 61, hold = 80") + moves);
  ASSERT_TRUE(behind.has_value());
  EXPECT_EQ(behind->begin_frame, 141);
  EXPECT_EQ(behind->end_frame, 200);
  EXPECT_FALSE(is_short(three_keys(", frame = 71, hold = 58") + rests));
  EXPECT_TRUE(is_short(three_keys(", frame = 69, hold = 58") + rests)) << "a ramp up as well";
}

TEST(ShortestStretch, OnlyAFrameOfItsOwnIsInTheWay) {
  EXPECT_FALSE(is_short(three_keys("") + moves));
  EXPECT_FALSE(is_short(three_keys(", ease = true") + "speed = [1, 1, 1, 1, 50, 50]\n"))
      << "a key that eases may be met on another frame";
  EXPECT_TRUE(is_short(three_keys(", ease = true, frame = 50") + moves));
}

}  // namespace fewest_frames_test
}  // namespace inbetween
