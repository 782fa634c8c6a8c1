// The frames of the RMD protocol that are known byte for byte, written and read.
#include <gtest/gtest.h>

#include "inbetween/can/rmd.hpp"
#include "sim/rmd_drive.hpp"
#include "tests/support/golden_frames.hpp"

namespace inbetween::can {
namespace rmd_frames_test {

const RmdMotor motor = *RmdMotor::make(1);

TEST(RmdFrames, WhatTheHostSendsIsByteForByteAsItShallBe) {
  const auto golden = golden_frames("rmd_frames.json");
  EXPECT_EQ(rmd_position_frame(motor, {.steps = 36'000, .max_deg_per_s = 500}),
            golden.at("a4_plus360_500dps"));
  EXPECT_EQ(rmd_position_frame(motor, {.steps = -36'000, .max_deg_per_s = 500}),
            golden.at("a4_minus360_500dps"));
  EXPECT_EQ(rmd_host_timeout_frame(motor, 100), golden.at("b3_timeout_100ms"));
  EXPECT_EQ(rmd_command_frame(motor, RmdCommand::read_angle), golden.at("92_read_multiturn"));
  EXPECT_EQ(rmd_command_frame(motor, RmdCommand::shut_down), golden.at("80_shutdown"));
  EXPECT_EQ(rmd_command_frame(motor, RmdCommand::stop), golden.at("81_stop"));
}

TEST(RmdFrames, WhatAMotorTellsIsReadAndWrittenAgain) {
  const auto golden = golden_frames("rmd_frames.json");
  EXPECT_EQ(read_rmd_angle(golden.at("92_reply_360"), motor), 36'000);
  EXPECT_EQ(rmd_angle_frame(motor, 36'000), golden.at("92_reply_360"));
  EXPECT_EQ(rmd_motion_frame(motor, {.celsius = 50, .amperes = 1, .deg_per_s = 500, .degrees = 45}),
            golden.at("a4_reply"));
}

// The host never writes the planning acceleration: a maker's tool has done so, or the motor is refused.
TEST(RmdFrames, TheSimulatedMotorTakesThePlanningAccelerationOfATool) {
  SimulatedRmd drive({.motor_number = motor, .planning_acceleration = 5000}, 0);
  drive.advance(300'000'000);
  const auto told = [&](const Frame& frame) {
    drive.receive(frame);
    return drive.take_frames().at(0);
  };
  EXPECT_EQ(told(rmd_acceleration_question(motor)).data[5], 5000 >> 8);
  static_cast<void>(told(golden_frames("rmd_frames.json").at("43_pos_accel_zero")));
  EXPECT_EQ(told(rmd_acceleration_question(motor)).data[5], 0);
}

}  // namespace rmd_frames_test
}  // namespace inbetween::can
