// Where motors are in an upload, and in exposures in motion.
#include "host_tools/dragonframe/go_motion.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>
#include <vector>

namespace inbetween {
namespace go_motion_test {

using namespace dragonframe;

TEST(UploadedMove, IsStraightBetweenFramesAndGoesOnOneFrameBeforeItsStart) {
  UploadedMove move(2, 100);
  ASSERT_EQ(move.begin(-5, 4), RigAnswer::ok);
  const std::vector<std::int32_t> positions{10, 30, 20};
  ASSERT_EQ(move.put({.motor = 2, .index = 0, .is_last = true, .positions = positions}), RigAnswer::ok);
  ASSERT_EQ(move.finish(), RigAnswer::ok);
  EXPECT_EQ(move.motors(), 2U) << "the second";
  EXPECT_EQ(move.position(2, -5), 10);
  EXPECT_EQ(move.position(2, -4.25), 25);
  EXPECT_EQ(move.position(2, -5.5), 0);
  EXPECT_EQ(move.position(2, -6), -10);
  EXPECT_EQ(move.position(2, -60), -10) << "and no further";
  EXPECT_EQ(move.position(2, 4), 20) << "the last value holds to the end";
  EXPECT_EQ(move.position(2, 40), 20);
  EXPECT_TRUE(move.has(-5) && move.has(4) && !move.has(5) && !move.has(-6));
}

TEST(UploadedMove, OfOneFrameStandsEverywhere) {
  UploadedMove move(1, 1);
  ASSERT_EQ(move.begin(7, 7), RigAnswer::ok);
  const std::vector<std::int32_t> positions{42};
  ASSERT_EQ(move.put({.motor = 1, .positions = positions}), RigAnswer::ok);
  ASSERT_EQ(move.finish(), RigAnswer::ok);
  for (const double frame : {6.0, 6.5, 7.0, 7.5, 8.0}) EXPECT_EQ(move.position(1, frame), 42);
}

TEST(UploadedMove, IsNoneUntilItIsWholeAndNoneWhenItIsCleared) {
  UploadedMove move(1, 10);
  ASSERT_EQ(move.begin(1, 2), RigAnswer::ok);
  EXPECT_FALSE(move.is_loaded());
  EXPECT_EQ(move.finish(), RigAnswer::ok) << "no motor has to move";
  EXPECT_TRUE(move.is_loaded());
  EXPECT_EQ(move.put_trigger(0, 1), RigAnswer::general) << "it is closed";
  move.clear();
  EXPECT_FALSE(move.is_loaded());
}

// The numbers of the description's own example: bf 500 500 1 0 100 200.
TEST(GoMotion, ABlurredFrameHasTheNumbersOfItsExample) {
  const ShotWay way = two_speed_shot(50, 100, 150, 0.5);
  EXPECT_EQ(way.start, -50);
  EXPECT_EQ(end_of(way), 250);
  EXPECT_EQ(way.pieces,
            (std::vector<ShotPiece>{{1, 0, 200}, {0.25, 200, 200}, {0.25, 200, 200}, {1, 200, 0}}));
}

TEST(GoMotion, ATurnOfAShutterCoversItsWholeWay) {
  const ShotWay way =
      shutter_turn_shot({.from = 100, .to = 800}, {.turn_s = 2, .wait_s = 0.5, .hold_s = 0.25});
  EXPECT_DOUBLE_EQ(end_of(way), 800);
  const double seconds =
      std::accumulate(way.pieces.begin(), way.pieces.end(), 0.0,
                      [](double sum, const ShotPiece& piece) { return sum + piece.seconds; });
  EXPECT_DOUBLE_EQ(seconds, 2.75);
  EXPECT_DOUBLE_EQ(way.pieces.at(2).from, 400) << "8/7 of the mean";
}

}  // namespace go_motion_test
}  // namespace inbetween
