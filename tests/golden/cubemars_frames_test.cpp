// The frames of CubeMars' servo mode that are known byte for byte, written and read.
#include <gtest/gtest.h>

#include "inbetween/can/cubemars.hpp"
#include "tests/support/golden_frames.hpp"

namespace inbetween::can {
namespace cubemars_frames_test {

const CubemarsMotor motor = *CubemarsMotor::make(0x68);

TEST(CubemarsFrames, APositionWithItsLimitsIsByteForByteAsItShallBe) {
  const Frame golden = golden_frames("cubemars_frames.json").at("set_pos_spd_90deg");
  const CubemarsPosition position{.position = 900'000, .max_velocity = 500, .max_acceleration = 2000};
  EXPECT_EQ(cubemars_position_frame(motor, position), golden);
  EXPECT_EQ(read_cubemars_position(golden, motor), position);
  // The same by the scales of today's firmware, for a motor of 21 pole pairs with a gear of 9.
  const CubemarsScale scale{.electric_turns_per_turn = 189};
  Cubemars told = *Cubemars::make(
      {.motor = motor, .scale = scale, .max_velocity = 500, .hold_velocity = 25, .max_acceleration = 2000});
  EXPECT_EQ(told.command({.turns = 0.25}), golden);
  EXPECT_NEAR(scale.counts_of(5000.0 / 189 / 60), 500, 1e-9) << "5000 electrical turns a minute";
}

TEST(CubemarsFrames, ASpeedIsPacketThreeWithElectricalTurnsAMinute) {
  const Frame frame = cubemars_speed_frame(motor, -5000);
  EXPECT_TRUE(frame.id.is_extended());
  EXPECT_EQ(frame.id.number(), 0x300U | motor.value());
  ASSERT_EQ(frame.length, 4);
  EXPECT_EQ(frame.data[0], 0xFF);
  EXPECT_EQ(frame.data[1], 0xFF);
  EXPECT_EQ(frame.data[2], 0xEC);
  EXPECT_EQ(frame.data[3], 0x78);
  EXPECT_EQ(read_cubemars_speed(frame, motor), -5000);
  EXPECT_FALSE(read_cubemars_position(frame, motor));
}

TEST(CubemarsFrames, FeedbackIsReadAndWrittenAgain) {
  const Frame golden = golden_frames("cubemars_frames.json").at("feedback_90deg");
  const CubemarsFeedback told{.decidegrees = 900, .dekaerpm = 500, .centiamperes = 150, .celsius = 40};
  EXPECT_EQ(read_cubemars_feedback(golden, motor), told);
  EXPECT_EQ(cubemars_feedback_frame(motor, told), golden);
}

}  // namespace cubemars_frames_test
}  // namespace inbetween::can
