// The frames of CANSimple that are known byte for byte, written and read.
#include <gtest/gtest.h>

#include <optional>

#include "inbetween/can/odrive.hpp"
#include "tests/support/golden_frames.hpp"

namespace inbetween::can {
namespace odrive_frames_test {

const OdriveNode node = *OdriveNode::make(3);
constexpr auto v05 = OdriveFamily::firmware_05;
constexpr auto v06 = OdriveFamily::firmware_06;

TEST(OdriveFrames, WhatTheHostSendsIsByteForByteAsItShallBe) {
  const auto golden = golden_frames("odrive_frames.json");
  EXPECT_EQ(odrive_state_frame(node, odrive_closed_loop), golden.at("set_axis_state_closed_loop"));
  EXPECT_EQ(odrive_state_frame(node, odrive_idle), golden.at("set_axis_state_idle"));
  EXPECT_EQ(odrive_position_mode_frame(node), golden.at("set_controller_mode_pos_passthrough"));
  EXPECT_EQ(odrive_position_frame(node, {.turns = 1.5F, .turns_per_s = 0.25, .torque_nm = -0.1}),
            golden.at("set_input_pos_1p5"));
  EXPECT_EQ(odrive_emergency_stop_frame(node), golden.at("estop"));
  EXPECT_EQ(odrive_clear_frame(node, v06), golden.at("clear_errors_06"));
  EXPECT_EQ(odrive_question(node, OdriveMessage::estimates), golden.at("encoder_estimates_request_rtr"));
}

TEST(OdriveFrames, HeartbeatsOfBothFamiliesAreReadAndWrittenAgain) {
  struct Row {
    const char* name;
    OdriveFamily family;
    OdriveHeartbeat means;
  };
  const auto golden = golden_frames("odrive_frames.json");
  for (const Row& row : {Row{"heartbeat_06_closed_loop", v06, {.state = 8, .is_trajectory_done = true}},
                         Row{"heartbeat_06_busy", v06, {.state = 1, .result = 1}},
                         Row{"heartbeat_05_closed_loop", v05, {.state = 8, .is_trajectory_done = true}},
                         Row{"heartbeat_05_watchdog", v05, {.errors = 0x800, .state = 1}}}) {
    SCOPED_TRACE(row.name);
    EXPECT_EQ(read_odrive_heartbeat(golden.at(row.name), node, row.family), row.means);
    EXPECT_EQ(odrive_heartbeat_frame(node, row.family, row.means), golden.at(row.name));
  }
}

TEST(OdriveFrames, WhatADriveTellsIsReadAndWrittenAgain) {
  const auto golden = golden_frames("odrive_frames.json");
  const auto place = read_odrive_estimates(golden.at("encoder_estimates"), node);
  ASSERT_TRUE(place);
  EXPECT_EQ(place->turns, 1.5);
  EXPECT_EQ(place->turns_per_s, -0.25);
  EXPECT_EQ(odrive_estimates_frame(node, 1.5F, -0.25F), golden.at("encoder_estimates"));
  const OdriveError watchdog{.disarm_reason = odrive_watchdog_error(v06)};
  EXPECT_EQ(read_odrive_error(golden.at("get_error_watchdog_06"), node), watchdog);
  EXPECT_EQ(odrive_error_frame(node, watchdog), golden.at("get_error_watchdog_06"));
}

// This program has no settings to read or write; one who does so beside it is another host.
TEST(OdriveFrames, AnOrderForASettingIsOfAnotherHostAndItsAnswerSaysNothing) {
  const auto golden = golden_frames("odrive_frames.json");
  const ServoReport order = Odrive(node, v06).read(golden.at("rxsdo_read_0x0123"));
  EXPECT_TRUE(order.is_of_a_host);
  EXPECT_FALSE(order.is_bad);
  const ServoReport answer = Odrive(node, v06).read(golden.at("txsdo_reply_0x0123_float1"));
  EXPECT_FALSE(answer.is_of_a_host || answer.is_bad || answer.place || answer.status);
  EXPECT_FALSE(Odrive(node, v05).read(golden.at("rxsdo_read_0x0123")).is_of_a_host)
      << "there the number is a message of the drive";
}

}  // namespace odrive_frames_test
}  // namespace inbetween::can
