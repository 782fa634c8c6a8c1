// The frames of CiA 301 and CiA 402 that are known byte for byte, written and read.
#include <gtest/gtest.h>

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "inbetween/can/canopen_id.hpp"
#include "inbetween/can/cia402.hpp"
#include "inbetween/can/emergency.hpp"
#include "inbetween/can/nmt.hpp"
#include "inbetween/can/sdo.hpp"
#include "inbetween/can/sync.hpp"
#include "tests/support/drive_frames.hpp"
#include "tests/support/golden_frames.hpp"

namespace inbetween::can {
namespace canopen_frames_test {

NodeId node(int number) {
  return NodeId::make(number).value();
}

struct Heard {
  int node;
  NmtState state;
};
struct Request {
  SdoMessage message;
};
struct Answer {
  SdoMessage message;
};
using Meaning =
    std::variant<NmtOrder, Heard, SyncMark, Emergency, Request, Answer, DriveCommand, DriveFeedback>;

constexpr std::array<std::uint8_t, 7> text(const char (&letters)[8]) {
  std::array<std::uint8_t, 7> bytes{};
  for (std::size_t i = 0; i < 7; ++i) bytes[i] = static_cast<std::uint8_t>(letters[i]);
  return bytes;
}

Request write(std::uint16_t index, std::uint8_t sub, std::uint8_t size, std::uint32_t value) {
  return {{.kind = SdoKind::download, .object = {.index = index, .sub = sub}, .size = size, .value = value}};
}
DriveFeedback feedback(std::uint16_t statusword, std::int32_t actual) {
  return {.statusword = statusword, .actual = actual, .mode = 8};
}

/// What each frame says, told a second time from the standards.
std::map<std::string, Meaning> meanings() {
  using enum SdoKind;
  const std::int32_t ahead = 0x000186A3;
  return {
      {"nmt_start_node5", NmtOrder{NmtCommand::start, 5}},
      {"nmt_stop_node5", NmtOrder{NmtCommand::stop, 5}},
      {"nmt_preop_all", NmtOrder{NmtCommand::enter_pre_operational, 0}},
      {"nmt_reset_node5", NmtOrder{NmtCommand::reset_node, 5}},
      {"nmt_reset_comm_node5", NmtOrder{NmtCommand::reset_communication, 5}},
      {"bootup_node5", Heard{5, NmtState::boot_up}},
      {"heartbeat_node5_operational", Heard{5, NmtState::operational}},
      {"heartbeat_node5_preop", Heard{5, NmtState::pre_operational}},
      {"heartbeat_master127_operational", Heard{127, NmtState::operational}},
      {"sync_no_counter", SyncMark{}},
      {"sync_counter_1", SyncMark{.counter = std::uint8_t{1}}},
      {"emcy_following_error", Emergency{.code = 0x8611, .error_register = 0x21}},
      {"emcy_reset", Emergency{}},
      {"sdo_write_1017_100ms", write(0x1017, 0, 2, 100)},
      {"sdo_write_ok_1017", Answer{{.kind = download_done, .object = {.index = 0x1017}}}},
      {"sdo_write_1016_1_master127_50ms", write(0x1016, 1, 4, (127U << 16) | 50)},
      {"sdo_1400_1_disable", write(0x1400, 1, 4, 0x80000205)},
      {"sdo_1600_0_clear", write(0x1600, 0, 1, 0)},
      {"sdo_1600_1_controlword",
       write(0x1600, 1, 4, mapping_value(command_mapping(Cia402Mode::cyclic_position).entries()[0]))},
      {"sdo_1600_2_target",
       write(0x1600, 2, 4, mapping_value(command_mapping(Cia402Mode::cyclic_position).entries()[1]))},
      {"sdo_1600_0_count2", write(0x1600, 0, 1, 2)},
      {"sdo_1400_2_type1", write(0x1400, 2, 1, 1)},
      {"sdo_1400_1_enable", write(0x1400, 1, 4, 0x205)},
      {"sdo_write_6060_csp", write(0x6060, 0, 1, 8)},
      {"sdo_60c2_1_value1", write(0x60C2, 1, 1, 1)},
      {"sdo_60c2_2_index_m3", write(0x60C2, 2, 1, 0xFD)},
      {"sdo_read_6064", Request{{.kind = upload, .object = {.index = 0x6064}}}},
      {"sdo_read_6064_reply_100000",
       Answer{{.kind = upload_value, .object = {.index = 0x6064}, .size = 4, .value = 100000}}},
      {"sdo_abort_readonly_6041",
       Answer{{.kind = abort, .object = {.index = 0x6041}, .value = abort_read_only}}},
      {"sdo_seg_upload_init_reply",
       Answer{{.kind = announce_upload, .object = {.index = 0x1008}, .value = 12}}},
      {"sdo_seg_upload_req_t0", Request{{.kind = ask_segment}}},
      {"sdo_seg_upload_rsp_t0", Answer{{.kind = upload_segment, .size = 7, .segment = text("SimDriv")}}},
      {"sdo_seg_upload_req_t1", Request{{.kind = ask_segment, .toggle = true}}},
      {"sdo_seg_upload_rsp_t1_last", Answer{{.kind = upload_segment,
                                             .size = 5,
                                             .toggle = true,
                                             .is_last = true,
                                             .segment = text("e 402\0\0")}}},
      {"sdo_seg_download_init",
       Request{{.kind = announce_download, .object = {.index = 0x2000, .sub = 1}, .value = 9}}},
      {"sdo_seg_download_seg_t0", Request{{.kind = download_segment, .size = 7, .segment = text("ABCDEFG")}}},
      {"sdo_seg_download_ack_t0", Answer{{.kind = download_segment_done}}},
      {"sdo_seg_download_seg_t1_last", Request{{.kind = download_segment,
                                                .size = 2,
                                                .toggle = true,
                                                .is_last = true,
                                                .segment = text("HI\0\0\0\0\0")}}},
      {"sdo_seg_download_ack_t1", Answer{{.kind = download_segment_done, .toggle = true}}},
      {"rpdo1_shutdown", DriveCommand{.controlword = 0x0006, .target = 100000}},
      {"rpdo1_switch_on", DriveCommand{.controlword = 0x0007, .target = 100000}},
      {"rpdo1_enable_csp", DriveCommand{.controlword = 0x000F, .target = 100000}},
      {"rpdo1_csp_negative", DriveCommand{.controlword = 0x000F, .target = -2500}},
      {"rpdo1_quick_stop", DriveCommand{.controlword = 0x0002, .target = 100000}},
      {"rpdo1_fault_reset", DriveCommand{.controlword = 0x0080, .target = 100000}},
      {"rpdo1_ip_active", DriveCommand{.controlword = 0x001F, .target = 100000}},
      {"tpdo1_switch_on_disabled", feedback(0x0250, 100000)},
      {"tpdo1_ready", feedback(0x0231, 100000)},
      {"tpdo1_switched_on", feedback(0x0233, 100000)},
      {"tpdo1_op_enabled_following", feedback(0x1237, ahead)},
      {"tpdo1_quick_stop_active", feedback(0x0217, ahead)},
      {"tpdo1_fault", feedback(0x0218, ahead)},
  };
}

template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

Frame write_frame(const Meaning& meaning) {
  return std::visit(
      Overloaded{[](const NmtOrder& order) { return nmt_frame(order); },
                 [](const Heard& heard) { return heartbeat_frame(node(heard.node), heard.state); },
                 [](const SyncMark& mark) {
                   SyncProducer producer = SyncProducer::make(mark.counter ? 240 : 0).value();
                   return producer.next();
                 },
                 [](const Emergency& emergency) { return emergency_frame(node(5), emergency); },
                 [](const Request& request) { return sdo_frame(sdo_request_id(node(5)), request.message); },
                 [](const Answer& answer) { return sdo_frame(sdo_answer_id(node(5)), answer.message); },
                 [](const DriveCommand& command) { return command_frame(node(5), command); },
                 [](const DriveFeedback& told) { return feedback_frame(node(5), told); }},
      meaning);
}

void expect_read(const Frame& frame, const Meaning& meaning) {
  std::visit(
      Overloaded{[&](const NmtOrder& order) { EXPECT_EQ(read_nmt(frame), order); },
                 [&](const Heard& heard) { EXPECT_EQ(read_heartbeat(frame, node(heard.node)), heard.state); },
                 [&](const SyncMark& mark) { EXPECT_EQ(read_sync(frame), mark); },
                 [&](const Emergency& emergency) { EXPECT_EQ(read_emergency(frame, node(5)), emergency); },
                 [&](const Request& request) { EXPECT_EQ(read_sdo_request(frame), request.message); },
                 [&](const Answer& answer) { EXPECT_EQ(read_sdo_answer(frame), answer.message); },
                 [&](const DriveCommand& command) { EXPECT_EQ(read_command(frame, node(5)), command); },
                 [&](const DriveFeedback& told) { EXPECT_EQ(read_feedback(frame, node(5)), told); }},
      meaning);
}

TEST(CanopenFrames, EachIsWrittenByteForByte) {
  const std::map<std::string, Meaning> known = meanings();
  for (const auto& [name, frame] : golden_frames("canopen_frames.json")) {
    SCOPED_TRACE(name);
    ASSERT_TRUE(known.contains(name));
    EXPECT_TRUE(write_frame(known.at(name)) == frame);
  }
}

TEST(CanopenFrames, EachIsUnderstood) {
  const std::map<std::string, Frame> frames = golden_frames("canopen_frames.json");
  const std::map<std::string, Meaning> known = meanings();
  EXPECT_EQ(frames.size(), known.size());
  for (const auto& [name, meaning] : known) {
    SCOPED_TRACE(name);
    ASSERT_TRUE(frames.contains(name));
    expect_read(frames.at(name), meaning);
  }
}

TEST(CanopenFrames, NoneIsUnderstoodWithAByteLessOrMoreOrAsAnotherKindOfFrame) {
  const std::map<std::string, Meaning> known = meanings();
  const auto is_read = [](const Frame& frame, const Meaning& meaning) {
    return std::visit(
        Overloaded{[&](const NmtOrder&) { return read_nmt(frame).has_value(); },
                   [&](const Heard& heard) { return read_heartbeat(frame, node(heard.node)).has_value(); },
                   [&](const SyncMark&) { return read_sync(frame).has_value(); },
                   [&](const Emergency&) { return read_emergency(frame, node(5)).has_value(); },
                   [&](const Request&) { return read_sdo_request(frame).has_value(); },
                   [&](const Answer&) { return read_sdo_answer(frame).has_value(); },
                   [&](const DriveCommand&) { return read_command(frame, node(5)).has_value(); },
                   [&](const DriveFeedback&) { return read_feedback(frame, node(5)).has_value(); }},
        meaning);
  };
  for (const auto& [name, frame] : golden_frames("canopen_frames.json")) {
    SCOPED_TRACE(name);
    const Meaning& meaning = known.at(name);
    EXPECT_TRUE(is_read(frame, meaning));
    Frame wrong = frame;
    wrong.is_remote = true;
    EXPECT_FALSE(is_read(wrong, meaning));
    wrong = frame;
    wrong.id = FrameId::extended(frame.id.number());
    EXPECT_FALSE(is_read(wrong, meaning));
    for (const int length : {frame.length - 1, frame.length + 1, 9, 255}) {
      const bool is_other_sync = std::holds_alternative<SyncMark>(meaning) && length <= 1;
      if (length < 0 || is_other_sync) continue;
      wrong = frame;
      wrong.length = static_cast<std::uint8_t>(length);
      EXPECT_FALSE(is_read(wrong, meaning)) << length;
    }
  }
}

}  // namespace canopen_frames_test
}  // namespace inbetween::can
