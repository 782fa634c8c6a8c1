// The frames of the DMC protocol that are known byte for byte: found, read, and written again.
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/dragonframe/dmc_device.hpp"
#include "tests/support/golden_bytes.hpp"
#include "tests/support/oracle_dmc_host.hpp"

namespace inbetween {
namespace dmc_frames_test {

using namespace dragonframe;
using Bytes = std::vector<std::uint8_t>;

Bytes golden(const std::string& name) {
  return golden_bytes("dmc_frames.json").at(name);
}

template <class Message>
Message read(const std::string& name) {
  const Bytes bytes = golden(name);
  std::span<const std::uint8_t> left(bytes);
  DmcDecoder decoder;
  const auto frame = decoder.next(left);
  if (!frame) throw std::runtime_error(name + " is no frame");
  return std::get<Message>(read_dmc_request(*dmc_type_row(frame->type), frame->payload).value());
}

Bytes written(std::uint32_t id, unsigned type, const Bytes& payload) {
  Bytes bytes;
  append_dmc_frame({.id = id, .type = static_cast<std::uint16_t>(type), .payload = payload}, bytes);
  return bytes;
}

TEST(DmcFrames, EveryOneIsFoundAndWrittenAgainByteForByte) {
  for (const auto& [name, bytes] : golden_bytes("dmc_frames.json")) {
    std::span<const std::uint8_t> left(bytes);
    DmcDecoder decoder;
    const auto frame = decoder.next(left);
    ASSERT_TRUE(frame) << name;
    EXPECT_EQ(frame->is_intact, name != "bad_checksum_go") << name;
    if (!frame->is_intact) continue;
    Bytes again;
    append_dmc_frame(*frame, again);
    EXPECT_EQ(again, bytes) << name;
    EXPECT_FALSE(decoder.next(left)) << name;
    EXPECT_EQ(decoder.counters().skipped_bytes, 0U) << name;
  }
}

TEST(DmcFrames, WhatADeviceSendsIsByteForByteAsItShallBe) {
  const DmcHi hi{.name = "dmc-lite",
                 .major = 1,
                 .motors = 8,
                 .outputs = 2,
                 .inputs = 1,
                 .frame_capacity = 10'000,
                 .capabilities = 0x0783};
  EXPECT_EQ(written(1, 0x0001, write_dmc_hi(hi)), golden("hi_reply_v2"));
  EXPECT_EQ(written(2, 0x8031, write_dmc_code(DmcCode::ok)), golden("ack_ok_dword"));
  EXPECT_EQ(written(7, 0x8111, write_dmc_code(DmcCode::not_in_position)), golden("ack_err_not_in_position"));
  EXPECT_EQ(written(3, 0x0030, write_dmc_status(0x5)), golden("motor_status_reply"));
  EXPECT_EQ(written(0, 0x0034, write_dmc_positions(24'500, std::vector{0, -1000, 250, INT32_MAX})),
            golden("positions_push"));
  EXPECT_EQ(written(0, 0x0114, {}), golden("rt_end_push"));
  EXPECT_EQ(written(0, 0x003A, write_dmc_hard_stop(0, 0)), golden("hard_stop_estop"));
  EXPECT_EQ(written(0, 0x003A, write_dmc_hard_stop(1, 3)), golden("hard_stop_upper"));
}

TEST(DmcFrames, WhatAHostAsksOfMotorsIsRead) {
  EXPECT_EQ(read<DmcMove>("motor_move").target, -1000);
  const auto jog = read<DmcJog>("motor_jog");
  EXPECT_EQ(std::tuple(jog.motor, jog.speed, jog.destination), std::tuple(2, 10'000, INT32_MAX));
  const auto configure = read<DmcConfigure>("motor_configure");
  EXPECT_TRUE(configure.is_enabled && configure.has_blur && !configure.is_live && !configure.couples);
  const auto speed = read<DmcSetSpeed>("motor_set_speed");
  EXPECT_EQ(std::pair(speed.max_velocity, speed.max_acceleration), std::pair(20'000U, 40'000U));
  const auto limits = read<DmcSetLimits>("motor_set_limits");
  EXPECT_EQ(limits.lower, -5000);
  EXPECT_EQ(limits.upper, 5000);
  EXPECT_EQ(limits.hardware_set, 0);
  EXPECT_TRUE(read<DmcStopAll>("stop_all_silent").is_silent);
}

TEST(DmcFrames, WhatAHostAsksOfTheMoveIsRead) {
  EXPECT_EQ(read<DmcUploadBegin>("upload_begin").end, 5);
  const auto axis = read<DmcUploadAxis>("upload_axis_final");
  EXPECT_TRUE(axis.is_last);
  EXPECT_EQ(axis.positions, (std::vector{0, 100, 200}));
  const auto triggers = read<DmcUploadTriggers>("upload_triggers");
  EXPECT_EQ(triggers.mask, 3U);
  ASSERT_EQ(triggers.triggers.size(), 1U);
  EXPECT_EQ(triggers.triggers[0].index, 2U);
  EXPECT_EQ(read<DmcPositionFrame>("position_frame").frame, 1);
  for (const std::string name : {"run_move_29", "run_move_31", "run_move_35_stills"}) {
    const auto run = read<DmcRunMove>(name);
    EXPECT_EQ(std::tuple(run.frames_per_1000_s, run.start, run.end, run.preroll_ms),
              std::tuple(24'000U, 1, 48, 1000U));
    EXPECT_EQ(run.has_stills_camera, name == "run_move_35_stills");
  }
  const auto stills = read<DmcRunMove>("run_move_35_stills");
  EXPECT_EQ(std::tuple(stills.is_synced, stills.bloop_bits, stills.bloop_ms), std::tuple(true, 1U, 100));
  EXPECT_EQ(std::pair(stills.open_deg, stills.close_deg), std::pair(std::uint16_t{90}, std::uint16_t{270}));
  const auto shot = read<DmcShootFrame>("shoot_frame");
  EXPECT_EQ(std::tuple(shot.frame, shot.exposure_ms, shot.blur_permille), std::tuple(10, 500U, 500));
  ASSERT_EQ(shot.overrides.size(), 1U);
  EXPECT_EQ(shot.overrides[0].to, 1200);
  const auto second = read<DmcShootFrame2>("shoot_frame2");
  EXPECT_EQ(std::pair(second.open_deg, second.close_deg), std::pair(std::int16_t{90}, std::int16_t{270}));
  EXPECT_EQ(read<DmcJogAll>("jog_all").frame, 20);
  EXPECT_EQ(read<DmcPlain>("rt_go").type, DmcType::go);
}

// The device of the golden frames, asked by them.
TEST(DmcFrames, ADeviceAnswersAGoldenRequestWithAGoldenAnswer) {
  DmcDevice device({.name = "dmc-lite", .motors = 8, .outputs = 2, .inputs = 1, .capabilities = 0x0783},
                   [](const RigOrder&) { return RigAnswer::ok; });
  ASSERT_TRUE(device.connect(0));
  ASSERT_TRUE(device.arm());
  const auto answer_to = [&](const std::string& name) {
    static_cast<void>(device.take_bytes());
    device.hear(golden(name), 0);
    return device.take_bytes();
  };
  EXPECT_EQ(answer_to("hi_request"), golden("hi_reply_v2"));
  EXPECT_EQ(answer_to("motor_move"), golden("ack_ok_dword"));
  device.observe({.moving = 0x5}, 1);
  EXPECT_EQ(answer_to("motor_status_request"), golden("motor_status_reply"));
  device.observe({}, 2);
  EXPECT_EQ(answer_to("bad_checksum_go"), oracle::dmc_message(0x8113, 16, {0x11, 0, 0, 0}));
  for (const std::string name : {"upload_begin", "upload_axis_final", "upload_end"}) {
    EXPECT_EQ(answer_to(name).at(10), 0x10) << name;
  }
  EXPECT_EQ(answer_to("run_move_29"), golden("ack_err_not_in_position"));
}

// A host written from the description writes the golden requests too.
TEST(DmcFrames, TheScriptedHostWritesThemAsWell) {
  oracle::DmcHost host;
  const auto as = [&](std::uint32_t id) -> oracle::DmcHost& {
    host.next_id(id);
    return host;
  };
  EXPECT_EQ(as(1).hi(), golden("hi_request"));
  EXPECT_EQ(as(2).move(1, -1000), golden("motor_move"));
  EXPECT_EQ(as(3).status(), golden("motor_status_request"));
  EXPECT_EQ(as(4).jog(2, 10'000, INT32_MAX), golden("motor_jog"));
  EXPECT_EQ(as(5).configure(1, 3), golden("motor_configure"));
  EXPECT_EQ(as(6).speed(1, 20'000, 40'000), golden("motor_set_speed"));
  EXPECT_EQ(as(8).limits(1, -5000, 5000), golden("motor_set_limits"));
  EXPECT_EQ(as(9).upload_begin(1, 5), golden("upload_begin"));
  EXPECT_EQ(as(10).upload_axis(1, 0, true, {0, 100, 200}), golden("upload_axis_final"));
  EXPECT_EQ(as(11).upload_triggers(3, {{2, 1}}), golden("upload_triggers"));
  EXPECT_EQ(as(12).upload_end(), golden("upload_end"));
  EXPECT_EQ(as(13).position_frame(1), golden("position_frame"));
  EXPECT_EQ(as(19).run({.end = 48}), golden("run_move_31"));
  EXPECT_EQ(as(14).run({.end = 48,
                        .is_synced = true,
                        .bloop_bits = 1,
                        .bloop_ms = 100,
                        .shutter_deg = std::pair(90U, 270U)}),
            golden("run_move_35_stills"));
  EXPECT_EQ(as(20).shoot(10, true, 500, 500, {{.motor = 1, .from = 1000, .to = 1200}}),
            golden("shoot_frame"));
  EXPECT_EQ(as(15).shoot2(10, 500, {90, 270}, {{.motor = 1, .from = 1000, .to = 1200}}),
            golden("shoot_frame2"));
  EXPECT_EQ(as(16).go(), golden("rt_go"));
  EXPECT_EQ(as(17).jog_all(12'000, 20), golden("jog_all"));
  EXPECT_EQ(as(18).stop_all(1), golden("stop_all_silent"));
}

}  // namespace dmc_frames_test
}  // namespace inbetween
