// CANopen without a drive profile: who may send what, heartbeats, SYNC, emergencies, objects, bus load.
#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "inbetween/can/bus_load.hpp"
#include "inbetween/can/canopen_id.hpp"
#include "inbetween/can/emergency.hpp"
#include "inbetween/can/heartbeat.hpp"
#include "inbetween/can/little_endian.hpp"
#include "inbetween/can/pdo.hpp"
#include "inbetween/can/sdo.hpp"
#include "inbetween/can/sdo_client.hpp"
#include "inbetween/can/sync.hpp"
#include "tests/support/drive_frames.hpp"

namespace inbetween::can {
namespace can_canopen_test {

constexpr std::int64_t ms = 1'000'000;

NodeId node(int number) {
  return NodeId::make(number).value();
}

TEST(NodeId, IsOneTo127) {
  EXPECT_FALSE(NodeId::make(0));
  EXPECT_FALSE(NodeId::make(128));
  EXPECT_FALSE(NodeId::make(257));
  EXPECT_EQ(NodeId::make(1)->value(), 1);
  EXPECT_EQ(NodeId::make(127)->value(), 127);
}

TEST(CanopenId, ProcessDataNeverUseARestrictedIdentifier) {
  for (int n = 1; n <= 127; ++n) {
    EXPECT_FALSE(is_restricted(tpdo1_id(node(n)).number())) << n;
    EXPECT_FALSE(is_restricted(rpdo1_id(node(n)).number())) << n;
    EXPECT_TRUE(is_restricted(sdo_answer_id(node(n)).number())) << n;
    EXPECT_TRUE(is_restricted(sdo_request_id(node(n)).number())) << n;
    EXPECT_TRUE(is_restricted(heartbeat_id(node(n)).number())) << n;
  }
  EXPECT_TRUE(is_restricted(nmt_id.number()));
}

TEST(LittleEndian, TheLowestByteComesFirst) {
  std::array<std::uint8_t, 8> data{};
  store(data, 2, std::uint32_t{0x11223344});
  EXPECT_EQ(data, (std::array<std::uint8_t, 8>{0, 0, 0x44, 0x33, 0x22, 0x11, 0, 0}));
  EXPECT_EQ(load<std::uint32_t>(data, 2), 0x11223344U);
  EXPECT_EQ(load<std::uint16_t>(data, 4), 0x1122U);
  EXPECT_DEATH(store(data, 5, std::uint32_t{1}), "");
}

TEST(Sync, TheCounterGoesFromOneToTheOverflowAndBeginsAgain) {
  SyncProducer producer = SyncProducer::make(3).value();
  std::vector<int> counted;
  counted.reserve(7);
  for (int i = 0; i < 7; ++i) counted.push_back(*read_sync(producer.next())->counter);
  EXPECT_EQ(counted, (std::vector<int>{1, 2, 3, 1, 2, 3, 1}));
  for (const int overflow : {1, 241, 255}) {
    EXPECT_FALSE(SyncProducer::make(static_cast<std::uint8_t>(overflow))) << overflow;
  }
}

TEST(HeartbeatProducer, SendsOneAPeriodAndNeverABurst) {
  HeartbeatProducer producer = HeartbeatProducer::make(node(127), 30 * ms).value();
  EXPECT_TRUE(producer.poll(5 * ms, NmtState::operational));
  EXPECT_EQ(producer.deadline_ns(), 35 * ms);
  EXPECT_FALSE(producer.poll(34 * ms, NmtState::operational));
  EXPECT_TRUE(producer.poll(36 * ms, NmtState::operational));
  EXPECT_EQ(producer.deadline_ns(), 65 * ms) << "being late once does not make all later ones late";
  EXPECT_TRUE(producer.poll(500 * ms, NmtState::operational));
  EXPECT_FALSE(producer.poll(501 * ms, NmtState::operational));
  EXPECT_EQ(producer.deadline_ns(), 530 * ms);
  EXPECT_FALSE(HeartbeatProducer::make(node(1), 0));
}

TEST(HeartbeatConsumer, EveryStateTimesEveryEvent) {
  using enum HeartbeatState;
  const std::array<std::array<HeartbeatState, heartbeat_events>, heartbeat_states> expected{{
      // start, boot_up, heartbeat, deadline
      {waiting, off, off, off},
      {waiting, waiting, alive, never_came},
      {waiting, rebooted, alive, lost},
      {waiting, rebooted, alive, lost},
      {waiting, never_came, never_came, never_came},
      {waiting, rebooted, rebooted, rebooted},
  }};
  for (std::size_t s = 0; s < heartbeat_states; ++s) {
    const auto state = static_cast<HeartbeatState>(s);
    for (std::size_t e = 0; e < heartbeat_events; ++e) {
      EXPECT_EQ(next_state(state, static_cast<HeartbeatEvent>(e)), expected.at(s).at(e))
          << "state " << s << ", event " << e;
    }
  }
}

TEST(HeartbeatConsumer, IsNotArmedByABootUpMessageButByTheFirstHeartbeat) {
  HeartbeatConsumer consumer({.timeout_ns = 150 * ms, .boot_timeout_ns = 1000 * ms});
  consumer.start(0);
  consumer.receive(NmtState::boot_up, 10 * ms);
  EXPECT_EQ(consumer.poll(999 * ms), HeartbeatState::waiting);
  consumer.receive(NmtState::pre_operational, 999 * ms);
  EXPECT_EQ(consumer.poll(1148 * ms), HeartbeatState::alive);
  EXPECT_EQ(consumer.poll(1149 * ms), HeartbeatState::lost);
  consumer.receive(NmtState::operational, 1200 * ms);
  EXPECT_EQ(consumer.state(), HeartbeatState::alive);
  consumer.receive(NmtState::boot_up, 1210 * ms);
  EXPECT_EQ(consumer.state(), HeartbeatState::rebooted);
}

TEST(HeartbeatConsumer, TheFirstThatComesAfterTheBootTimerIsTooLate) {
  HeartbeatConsumer consumer({.timeout_ns = 150 * ms, .boot_timeout_ns = 1000 * ms});
  consumer.start(0);
  EXPECT_EQ(consumer.deadline_ns(), 1000 * ms);
  consumer.receive(NmtState::operational, 1000 * ms);
  EXPECT_EQ(consumer.state(), HeartbeatState::never_came);
}

TEST(Emergency, TellsItsCodeInWords) {
  EXPECT_STREQ(words_of_emergency(0x8611), "following error");
  EXPECT_STREQ(words_of_emergency(0x8130), "the heartbeat of the host is missing");
  EXPECT_STREQ(words_of_emergency(0x4123), "the temperature");
  EXPECT_STREQ(words_of_emergency(0xFF55), "an error of this manufacturer's own");
  for (unsigned code = 0; code <= 0xFFFF; ++code) {
    ASSERT_STRNE(words_of_emergency(static_cast<std::uint16_t>(code)), "") << code;
  }
}

/// Such a fault only says that the host was silent or its SYNC late, and is reset on the way off.
TEST(Emergency, OfCommunicationAreTheBusTheProtocolAndTheSync) {
  for (const unsigned code : {0x8100U, 0x8130U, 0x8210U, 0x8250U, 0x8700U}) {
    EXPECT_TRUE(is_of_communication(static_cast<std::uint16_t>(code))) << std::hex << code;
  }
  for (const unsigned code : {0x8000U, 0x8311U, 0x8400U, 0x8611U, 0x8612U, 0x8800U, 0x7300U, 0x2310U}) {
    EXPECT_FALSE(is_of_communication(static_cast<std::uint16_t>(code))) << std::hex << code;
  }
}

TEST(PdoMapping, CarriesOneToEightObjectsOfWholeBytes) {
  const PdoEntry word{.object = {.index = 0x6040}, .bits = 16};
  const PdoEntry bit{.object = {.index = 0x6040}, .bits = 1};
  const PdoEntry number{.object = {.index = 0x607A}, .bits = 32};
  EXPECT_EQ(PdoMapping::make(std::array{word, number})->bytes(), 6);
  EXPECT_EQ(PdoMapping::make(std::array{number, number})->bytes(), 8);
  EXPECT_FALSE(PdoMapping::make(std::array{number, number, word}));
  EXPECT_FALSE(PdoMapping::make(std::array{bit}));
  EXPECT_FALSE(PdoMapping::make({}));
  EXPECT_EQ(mapping_value(number), 0x607A0020U);
  EXPECT_EQ(read_mapping_value(0x607A0020), number);
}

TEST(SdoClient, EveryStateTimesEveryEvent) {
  using enum SdoState;
  const std::array<std::array<SdoState, sdo_events>, sdo_states> expected{{
      // begin, poll, deadline, answer, more, refusal, nonsense, other
      {queued, idle, idle, idle, idle, idle, idle, idle},
      {queued, waiting, queued, queued, queued, queued, queued, queued},
      {waiting, waiting, aborting, done, queued, failed, aborting, waiting},
      {aborting, failed, aborting, aborting, aborting, aborting, aborting, aborting},
      {queued, done, done, done, done, done, done, done},
      {queued, failed, failed, failed, failed, failed, failed, failed},
  }};
  for (std::size_t s = 0; s < sdo_states; ++s) {
    for (std::size_t e = 0; e < sdo_events; ++e) {
      EXPECT_EQ(next_state(static_cast<SdoState>(s), static_cast<SdoEvent>(e)), expected.at(s).at(e))
          << "state " << s << ", event " << e;
    }
  }
}

class SdoClientOfNode5 : public testing::Test {
 protected:
  SdoClient client{node(5), 500 * ms};
  static constexpr ObjectAddress mode{.index = 0x6060};

  static Frame answer(const SdoMessage& message) { return sdo_frame(sdo_answer_id(node(5)), message); }
};

TEST_F(SdoClientOfNode5, ReadsAnObject) {
  ASSERT_TRUE(client.begin_upload({.index = 0x6064}, 4));
  EXPECT_FALSE(client.begin_upload(mode, 1)) << "one at a time";
  const std::optional<Frame> request = client.poll(0);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->id, FrameId(0x605));
  EXPECT_FALSE(client.poll(499 * ms));
  EXPECT_TRUE(client.receive(
      answer({.kind = SdoKind::upload_value, .object = {.index = 0x6064}, .size = 4, .value = 0xFFFFF63C})));
  EXPECT_EQ(client.state(), SdoState::done);
  EXPECT_EQ(client.value(), 0xFFFFF63CU);
  EXPECT_TRUE(client.begin_upload(mode, 1));
}

TEST_F(SdoClientOfNode5, TellsWhyTheDriveRefused) {
  client.begin_download({.index = 0x6041}, 2, 1);
  client.poll(0);
  EXPECT_TRUE(client.receive(
      answer({.kind = SdoKind::abort, .object = {.index = 0x6041}, .value = abort_read_only})));
  EXPECT_EQ(client.state(), SdoState::failed);
  EXPECT_EQ(client.abort_code(), abort_read_only);
  EXPECT_STREQ(words_of_abort(client.abort_code()), "the object can only be read");
  EXPECT_STREQ(words_of_abort(0x12345678), "a reason that CiA 301 does not name");
}

TEST_F(SdoClientOfNode5, TellsTheDriveThatItsAnswerDidNotComeInTime) {
  client.begin_download(mode, 1, 8);
  client.poll(0);
  const std::optional<Frame> abort = client.poll(500 * ms);
  ASSERT_TRUE(abort);
  EXPECT_EQ(read_sdo_request(*abort),
            (SdoMessage{.kind = SdoKind::abort, .object = mode, .value = 0x05040000}));
  EXPECT_EQ(client.state(), SdoState::failed);
  EXPECT_FALSE(client.receive(answer({.kind = SdoKind::download_done, .object = mode})));
  EXPECT_EQ(client.state(), SdoState::failed) << "an answer that comes later changes nothing";
}

TEST_F(SdoClientOfNode5, LeavesAloneWhatItDidNotAskFor) {
  EXPECT_FALSE(client.receive(answer({.kind = SdoKind::download_done, .object = mode})));
  client.begin_download(mode, 1, 8);
  client.poll(0);
  EXPECT_FALSE(client.receive(answer({.kind = SdoKind::download_done, .object = {.index = 0x6065}})));
  Frame too_short = answer({.kind = SdoKind::download_done, .object = mode});
  too_short.length = 7;
  EXPECT_FALSE(client.receive(too_short));
  EXPECT_EQ(client.state(), SdoState::waiting);
  EXPECT_TRUE(client.receive(answer({.kind = SdoKind::download_done, .object = mode})));
}

TEST_F(SdoClientOfNode5, EndsATransferWhoseAnswerIsNone) {
  using Answers = std::vector<SdoMessage>;
  const SdoMessage announced{.kind = SdoKind::announce_upload, .object = mode, .value = 1};
  for (const auto& [code, answers] : {
           std::pair(0x05040005U, Answers{{.kind = SdoKind::announce_upload, .object = mode, .value = 12}}),
           std::pair(0x06070010U,
                     Answers{{.kind = SdoKind::upload_value, .object = mode, .size = 4, .value = 0x108}}),
           std::pair(0x05040001U, Answers{{.kind = SdoKind::download_done, .object = mode}}),
           std::pair(0x05030000U,
                     Answers{announced, {.kind = SdoKind::upload_segment, .size = 1, .toggle = true}}),
           std::pair(0x06070010U,
                     Answers{announced, {.kind = SdoKind::upload_segment, .size = 2, .is_last = true}}),
           std::pair(0x06070010U, Answers{announced, {.kind = SdoKind::upload_segment, .size = 0}}),
           std::pair(0x05040005U, Answers{announced, {.kind = SdoKind::upload_segment, .size = 7}}),
       }) {
    client.reset();
    client.begin_upload(mode, 1);
    for (std::size_t i = 0; i < answers.size(); ++i) {
      ASSERT_TRUE(client.poll(0));
      EXPECT_EQ(client.receive(answer(answers[i])), i + 1 < answers.size());
    }
    const std::optional<Frame> abort = client.poll(ms);
    ASSERT_TRUE(abort);
    EXPECT_EQ(read_sdo_request(*abort), (SdoMessage{.kind = SdoKind::abort, .object = mode, .value = code}));
    EXPECT_EQ(client.state(), SdoState::failed);
    EXPECT_TRUE(client.has_given_up());
  }
}

TEST_F(SdoClientOfNode5, ANumberMayHaveMoreBytesIfTheySayNothing) {
  for (const auto& [told, value] : {std::pair(0x000000FDU, 0xFDU), std::pair(0xFFFFFFFDU, 0xFDU),
                                    std::pair(0x00000008U, 8U), std::pair(0U, 0U)}) {
    client.reset();
    client.begin_upload(mode, 1);
    client.poll(0);
    EXPECT_TRUE(
        client.receive(answer({.kind = SdoKind::upload_value, .object = mode, .size = 4, .value = told})));
    EXPECT_EQ(client.value(), value);
  }
}

TEST_F(SdoClientOfNode5, TakesTheBytesOfAValueAndNotThoseBehindIt) {
  client.begin_upload(mode, 1);
  client.poll(0);
  Frame told = answer({.kind = SdoKind::upload_value, .object = mode, .size = 1, .value = 0x08});
  for (std::size_t i = 5; i < 8; ++i) told.data[i] = 0xAA;
  EXPECT_TRUE(client.receive(told));
  EXPECT_EQ(client.value(), 8U);
  EXPECT_EQ(read_sdo_answer(told)->value, 8U);
}

TEST_F(SdoClientOfNode5, TakesAValueWhoseSizeTheDriveDoesNotTell) {
  client.begin_upload(mode, 1);
  client.poll(0);
  EXPECT_TRUE(client.receive(
      answer({.kind = SdoKind::upload_value, .object = mode, .size = 0, .value = 0xABCDEF08})));
  EXPECT_EQ(client.value(), 8U);
}

TEST(BusLoad, AFrameHasAtWorstTheBitsOfTheStandard) {
  const std::array<std::int32_t, 9> bits{55, 65, 75, 85, 95, 105, 115, 125, 135};
  for (std::int32_t n = 0; n <= 8; ++n)
    EXPECT_EQ(worst_case_bits(n, false), bits.at(static_cast<std::size_t>(n)));
  EXPECT_EQ(worst_case_bits(0, true), 80);
  EXPECT_EQ(worst_case_bits(8, true), 160);
}

TEST(BusLoad, IsThatOfTheTable) {
  struct Row {
    std::int64_t bitrate, rate_hz, max;
    std::vector<int> percent;
  };
  const std::array<std::int64_t, 6> drives{1, 2, 3, 4, 6, 8};
  for (const Row& row :
       {Row{500'000, 250, 5, {15, 27, 39, 51, 75, 99}}, Row{500'000, 500, 2, {30, 54, 78, 101}},
        Row{1'000'000, 250, 11, {7, 13, 19, 25, 37, 49}}, Row{1'000'000, 500, 5, {15, 27, 39, 51, 75, 99}},
        Row{1'000'000, 1000, 2, {30, 54, 78, 101}}, Row{1'000'000, 2000, 1, {59, 107}}}) {
    BusUse use{.bitrate = row.bitrate, .rate_hz = row.rate_hz};
    for (std::size_t i = 0; i < row.percent.size(); ++i) {
      use.drives = drives.at(i);
      EXPECT_NEAR(static_cast<double>(bus_load_per_mille(use)) / 10, row.percent[i], 0.6);
    }
    EXPECT_EQ(max_drives(use), row.max) << row.bitrate << " at " << row.rate_hz;
    use.drives = row.max;
    EXPECT_LE(bus_load_per_mille(use), 700);
    use.drives = row.max + 1;
    EXPECT_GT(bus_load_per_mille(use), 700);
  }
}

TEST(BusLoad, ACounterInSyncIsMoreOfIt) {
  EXPECT_GT(cyclic_bits_per_second({.counts_sync = true}), cyclic_bits_per_second({}));
}

}  // namespace can_canopen_test
}  // namespace inbetween::can
