// Frames in a stream of bytes: cut anywhere, in noise, damaged, and never finished.
#include "host_tools/dragonframe/dmc_frame.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "host_tools/dragonframe/dmc_device.hpp"
#include "tests/support/golden_bytes.hpp"
#include "tests/support/oracle_dmc_host.hpp"
#include "tests/support/property.hpp"

namespace inbetween {
namespace dmc_frame_test {

using namespace dragonframe;
using Bytes = std::vector<std::uint8_t>;

/// The types of the intact frames, fed in one piece.
std::vector<unsigned> found(DmcDecoder& decoder, std::span<const std::uint8_t> bytes) {
  std::vector<unsigned> types;
  while (const auto frame = decoder.next(bytes)) {
    if (frame->is_intact) types.push_back(frame->type);
  }
  return types;
}

TEST(DmcFrame, EveryGoldenFrameIsFoundCutAtEveryByte) {
  for (const auto& [name, bytes] : golden_bytes("dmc_frames.json")) {
    if (name == "bad_checksum_go") continue;
    for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
      DmcDecoder decoder;
      std::vector<unsigned> types = found(decoder, std::span(bytes).first(cut));
      for (const unsigned type : found(decoder, std::span(bytes).subspan(cut))) types.push_back(type);
      EXPECT_EQ(types.size(), 1U) << name << " cut at " << cut;
    }
  }
}

TEST(DmcFrame, IsFoundBehindNoiseAndBehindALostByte) {
  const Bytes go = oracle::dmc_message(0x0113, 1, {});
  const Bytes move = oracle::dmc_message(0x0031, 2, {1, 0, 0, 0, 0});
  Bytes bytes{'D', 'D', 'F', 'D'};  // "DDF" begins a frame that never is one
  bytes.insert(bytes.end(), go.begin(), go.end());
  DmcDecoder decoder;
  EXPECT_EQ(found(decoder, bytes), (std::vector<unsigned>{0x0113}));
  EXPECT_EQ(decoder.counters().skipped_bytes, 4U);
  // The first frame loses a byte and takes one of the second.
  bytes = move;
  bytes.erase(bytes.begin() + 12);
  bytes.insert(bytes.end(), go.begin(), go.end());
  EXPECT_EQ(found(decoder, bytes), (std::vector<unsigned>{0x0113}));
  EXPECT_EQ(decoder.counters().damaged, 1U);
}

TEST(DmcFrame, AHeaderThatNobodyCanMeanIsSkipped) {
  const Bytes go = oracle::dmc_message(0x0113, 1, {});
  for (Bytes header :
       {Bytes{'D', 'F', 0, 0, 0, 0, 0x31, 0, 0xF5, 0x07}, Bytes{'D', 'F', 0, 0, 0, 0, 0, 0x04, 0, 0}}) {
    header.insert(header.end(), go.begin(), go.end());
    DmcDecoder decoder;
    EXPECT_EQ(found(decoder, header), (std::vector<unsigned>{0x0113}));
  }
  DmcDecoder decoder;
  EXPECT_EQ(found(decoder, oracle::dmc_message(0x0101, 1, Bytes(2036))).size(), 1U) << "the longest there is";
}

TEST(DmcFrame, AHalfOneIsGivenUpAndWhatStandsInItIsFound) {
  Bytes bytes = oracle::dmc_message(0x0101, 1, Bytes(500));
  bytes.resize(100);
  const Bytes hi = oracle::dmc_message(0x0001, 2, {});
  bytes.insert(bytes.end(), hi.begin(), hi.end());
  DmcDecoder decoder;
  EXPECT_TRUE(found(decoder, bytes).empty());
  ASSERT_TRUE(decoder.has_half());
  decoder.give_up();
  EXPECT_EQ(found(decoder, {}), (std::vector<unsigned>{0x0001}));
  EXPECT_FALSE(decoder.has_half());
}

TEST(DmcFrame, TheDeviceGivesUpAHalfOneAfterASilence) {
  DmcDevice device({}, [](const RigOrder&) { return RigAnswer::ok; });
  device.connect(0);
  static_cast<void>(device.take_bytes());
  Bytes bytes = oracle::dmc_message(0x0101, 1, Bytes(500));
  bytes.resize(100);
  device.hear(bytes, 0);
  device.hear(oracle::dmc_message(0x0001, 2, {}), 1);
  device.observe({}, dmc_silence_ns);
  EXPECT_TRUE(device.take_bytes().empty());
  device.observe({}, dmc_silence_ns + 1);
  EXPECT_EQ(device.take_bytes().size(), 63U) << "who asks meanwhile is answered";
  EXPECT_EQ(device.take_notices().back().kind, PortNotice::Kind::half_dropped);
}

TEST(DmcFrame, AMillionRandomBytesChangeNothing) {
  std::size_t settings = 0;
  std::size_t motions = 0;
  DmcDevice device({.motors = 8, .outputs = 2}, [&](const RigOrder& order) {
    if (std::holds_alternative<SetMotor>(order) || std::holds_alternative<SetOutputs>(order)) ++settings;
    ++motions;
    return RigAnswer::ok;
  });
  device.connect(0);
  ASSERT_TRUE(device.arm());
  std::mt19937 random(4);
  for (int block = 0; block < 1000; ++block) {
    Bytes bytes(1000);
    // As often as not two letters are those that begin a frame.
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    if (block % 2 == 0) bytes[500] = 'D', bytes[501] = 'F', bytes[507] &= 3, bytes[509] &= 7;
    device.hear(bytes, block);
  }
  EXPECT_EQ(settings + motions, 0U);
  EXPECT_TRUE(device.is_armed());
  EXPECT_FALSE(device.move().is_loaded());
  EXPECT_EQ(device.counters().frames, 0U);
  EXPECT_GT(device.counters().skipped_bytes, 900'000U);
}

TEST(DmcFrameProperty, WhatIsWrittenIsReadHoweverItIsCutAndWhateverStandsBetween) {
  check_property(2000, [] {
    Bytes stream;
    std::vector<unsigned> sent;
    const auto count = *rc::gen::inRange(1, 8);
    for (int i = 0; i < count; ++i) {
      // Noise without a D begins no frame.
      const auto noise = *rc::gen::container<Bytes>(rc::gen::inRange<std::uint8_t>(0x45, 0xFF));
      stream.insert(stream.end(), noise.begin(), noise.end());
      const auto type = *rc::gen::inRange(0U, 0x0400U);
      const auto frame =
          oracle::dmc_message(type, *rc::gen::arbitrary<std::uint32_t>(), *rc::gen::arbitrary<Bytes>());
      stream.insert(stream.end(), frame.begin(), frame.end());
      sent.push_back(type);
    }
    DmcDecoder decoder;
    std::vector<unsigned> heard;
    for (std::span<const std::uint8_t> left(stream); !left.empty();) {
      const auto piece = std::min<std::size_t>(*rc::gen::inRange<std::size_t>(1, 20), left.size());
      for (const unsigned type : found(decoder, left.first(piece))) heard.push_back(type);
      left = left.subspan(piece);
    }
    RC_ASSERT(heard == sent);
    RC_ASSERT(!decoder.has_half());
  });
}

// Every stage with every step: what the description says of the states of a device.
TEST(DmcStageTable, EveryStepFromEveryStage) {
  using enum DmcStage;
  const std::vector<std::pair<DmcStep, std::vector<std::optional<DmcStage>>>> table{
      {DmcStep::motor_order, {jog, {}, {}, {}, jog, {}}},
      {DmcStep::jog_all, {all_jog, all_jog, all_jog, {}, all_jog, {}}},
      {DmcStep::run, {approach, approach, approach, {}, approach, {}}},
      {DmcStep::shot, {preroll, {}, {}, {}, preroll, {}}},
      {DmcStep::approached, {{}, jog, preroll, {}, {}, {}}},
      {DmcStep::in_place, {{}, {}, {}, wait, {}, {}}},
      {DmcStep::go, {{}, {}, {}, {}, shoot, {}}},
      {DmcStep::at_rest, {jog, jog, jog, jog, wait, jog}},
      {DmcStep::stop, {jog, jog, jog, jog, jog, jog}}};
  ASSERT_EQ(table.size(), dmc_step_count);
  for (const auto& [step, stages] : table) {
    for (std::size_t i = 0; i < dmc_stage_count; ++i) {
      EXPECT_EQ(after(static_cast<DmcStage>(i), step), stages.at(i)) << i;
    }
  }
}

}  // namespace dmc_frame_test
}  // namespace inbetween
