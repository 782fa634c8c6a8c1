// The frames of moteus that are known byte for byte, written and read.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "inbetween/can/moteus.hpp"
#include "inbetween/can/moteus_register.hpp"
#include "tests/support/golden_frames.hpp"

namespace inbetween::can {
namespace moteus_frames_test {

const MoteusNode node = *MoteusNode::make(1);

TEST(MoteusFrames, WhatTheHostSendsIsByteForByteAsItShallBe) {
  const auto golden = golden_frames<FdFrame>("moteus_frames.json");
  EXPECT_EQ(moteus_stop_frame(node), golden.at("stop_noreply"));
  EXPECT_EQ(moteus_question(node), golden.at("query_default"));
  EXPECT_EQ(moteus_command_frame(node, {.turns = 1, .turns_per_s = 2}), golden.at("position_1rev_2hz_query"));
  EXPECT_EQ(moteus_command_frame(node, {}), golden.at("position_hold_nan_query"));
  EXPECT_EQ(moteus_command_frame(node, {.turns = 0.25, .watchdog_s = 0.05}), golden.at("position_wd_query"));
}

TEST(MoteusFrames, WhatTheProtocolClassSendsInMotionIsThePublishedFrame) {
  const Moteus moteus({.node = node, .watchdog_s = 0.05});
  EXPECT_EQ(moteus.command({.turns = 0.25}),
            golden_frames<FdFrame>("moteus_frames.json").at("position_wd_query"));
  EXPECT_EQ(moteus.question(), golden_frames<FdFrame>("moteus_frames.json").at("query_default"));
  EXPECT_EQ(moteus.order(ServoOrder::switch_off),
            golden_frames<FdFrame>("moteus_frames.json").at("stop_noreply"));
}

TEST(MoteusFrames, IntegersCountInTheStepsOfTheirRegister) {
  FdFrame frame{.id = 1};
  MoteusWriter writer(frame);
  writer.write(MoteusRegister::mode, MoteusType::int8, std::array{10.0});
  writer.write(MoteusRegister::command_position, MoteusType::int32, std::array{0.25, 0.0});
  ASSERT_TRUE(writer.finish());
  EXPECT_EQ(frame, golden_frames<FdFrame>("moteus_frames.json").at("position_int32"));
}

TEST(MoteusFrames, WhatADriveTellsIsReadAndWrittenAgain) {
  const auto golden = golden_frames<FdFrame>("moteus_frames.json");
  const ServoReport report = Moteus({.node = node}).read(golden.at("reply_default"));
  ASSERT_TRUE(report.place && report.status);
  EXPECT_EQ(report.place->turns, 0.25);
  EXPECT_EQ(report.place->turns_per_s, 0);
  EXPECT_TRUE(report.status->is_on);
  EXPECT_EQ(report.status->errors, 0U);
  FdFrame frame{.id = 0x100};
  MoteusWriter writer(frame);
  writer.reply(MoteusRegister::mode, MoteusType::int8, std::array{10.0});
  writer.reply(MoteusRegister::position, MoteusType::float32, std::array{0.25, 0.0, 0.1});
  writer.reply(MoteusRegister::voltage, MoteusType::int8, std::array{24.0, 25.0, 0.0});
  ASSERT_TRUE(writer.finish());
  EXPECT_EQ(frame, golden.at("reply_default"));

  const ServoReport expired = Moteus({.node = node}).read(golden.at("reply_timeout_mode"));
  ASSERT_TRUE(expired.status);
  EXPECT_TRUE(expired.status->has_missed_host);
  EXPECT_FALSE(expired.status->is_on);
  EXPECT_STREQ(words_of_moteus_error(expired.status->errors), "its watchdog has expired");
}

TEST(MoteusFrames, ThePublishedExampleOf16BitRegistersIsWrittenAndRead) {
  const auto golden = golden_frames<FdFrame>("moteus_frames.json");
  FdFrame frame{.id = FrameId::extended(0x8001)};
  MoteusWriter writer(frame);
  writer.write(MoteusRegister::mode, MoteusType::int8, std::array{10.0});
  // What lies between two steps is cut off towards 0. Register 022 is not one of ours: it counts in whole
  // steps.
  writer.write(MoteusRegister::command_position, MoteusType::int16, std::array{0.00965, 0.0721, -176.0});
  writer.read(MoteusRegister::mode, MoteusType::int16, 4);
  writer.read(MoteusRegister::voltage, MoteusType::int8, 3);
  ASSERT_TRUE(writer.finish());
  EXPECT_EQ(frame, golden.at("published_int16_command"));

  MoteusReader reader(golden.at("published_int16_reply"));
  std::vector<double> values;
  while (const auto item = reader.next()) values.push_back(item->value);
  EXPECT_FALSE(reader.is_bad());
  ASSERT_EQ(values.size(), 7U);
  const std::array<double, 7> means{10, 0.0080, 0.064, -1.44, 12, 20, 0};
  for (std::size_t i = 0; i < means.size(); ++i) EXPECT_NEAR(values[i], means.at(i), 1e-12) << i;
}

}  // namespace moteus_frames_test
}  // namespace inbetween::can
