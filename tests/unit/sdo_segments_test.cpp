// SDO in segments, against a server of the tests' own and that of the simulated drive: every size, both
// directions, and frames that are lost, doubled or late, in either direction.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/rig/cia402_kind.hpp"
#include "inbetween/can/sdo_client.hpp"
#include "sim/cia402_drive.hpp"
#include "tests/support/quirky_drive.hpp"

namespace inbetween {
namespace sdo_segments_test {

using can::SdoKind;
using can::SdoMessage;
using can::SdoState;

std::vector<std::uint8_t> pattern(std::size_t size) {
  std::vector<std::uint8_t> bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(13 * i + 5);
  return bytes;
}

/// Drives with an object 2F00 of `size` bytes.
struct OwnServer : QuirkyDrive {
  explicit OwnServer(std::size_t size) : QuirkyDrive("sizes = { \"2F00\" = " + std::to_string(size) + " }") {}
  [[nodiscard]] std::vector<std::uint8_t> bytes_of_object() const { return bytes(0x2F00); }
};
struct SimulatedServer : SimulatedCia402Drive {
  explicit SimulatedServer(std::size_t size) : SimulatedCia402Drive({.node = *can::NodeId::make(5)}, 0) {
    std::vector<std::uint8_t> bytes = pattern(size);
    std::ranges::reverse(bytes);
    add_object({.index = 0x2F00}, {.bytes = bytes});
    advance(60'000'000);
    static_cast<void>(take_frames());
  }
  [[nodiscard]] std::vector<std::uint8_t> bytes_of_object() const {
    return objects().read({.index = 0x2F00});
  }
};

/// A client and a drive, a millisecond between a request and its answer.
template <class Server>
struct Transfer {
  explicit Transfer(std::size_t size) : drive(size) {
    for (; now_ns < 70'000'000; now_ns += 10'000'000) drive.advance(now_ns);
    static_cast<void>(drive.take_frames());
  }
  /// An abort in the place of the frame of this number.
  struct Injected {
    int number = 0;
    std::uint32_t code = 0;
    [[nodiscard]] can::Frame frame(can::FrameId id) const {
      return can::sdo_frame(id, {.kind = SdoKind::abort, .object = {.index = 0x2F00}, .value = code});
    }
  };
  /// Of the frames of a transfer, by their number.
  struct Trouble {
    int lost_answer = -1;
    int doubled_answer = -1;
    int late_answer = -1;
    int lost_request = -1;
    int doubled_request = -1;
    std::optional<Injected> answered = {};
    std::optional<Injected> requested = {};
  };
  /// Until it has ended. A late answer comes after the timeout.
  void work(const Trouble& trouble = {}) {
    std::vector<can::Frame> held;
    for (int tick = 0; tick < 5000; ++tick) {
      now_ns += 1'000'000;
      if (const auto frame = client.poll(now_ns)) send(*frame, trouble);
      for (const can::Frame& frame : drive.take_frames()) {
        const int number = answers++;
        if (number == trouble.late_answer) held.push_back(frame);
        const bool is_abort = trouble.answered && number == trouble.answered->number;
        if (is_abort) client.receive(trouble.answered->frame(0x585));
        const bool is_gone = is_abort || number == trouble.lost_answer || number == trouble.late_answer;
        if (!is_gone) client.receive(frame);
        // The copy comes when the next request is on its way.
        if (number == trouble.doubled_answer) copy.push_back(frame);
      }
      if (!copy.empty()) take_copy(trouble);
      const bool was_reset = client.state() == SdoState::idle;
      if (was_reset || client.state() == SdoState::done || client.state() == SdoState::failed) break;
    }
    for (const can::Frame& frame : held) EXPECT_FALSE(client.receive(frame)) << "it is too late";
  }
  void send(const can::Frame& frame, const Trouble& trouble) {
    const int number = requests++;
    if (trouble.requested && number == trouble.requested->number) {
      drive.receive(trouble.requested->frame(0x605));
      return client.reset();
    }
    if (number != trouble.lost_request) drive.receive(frame);
    if (number == trouble.doubled_request) drive.receive(frame);
  }
  void take_copy(const Trouble& trouble) {
    now_ns += 1'000'000;
    if (const auto frame = client.poll(now_ns)) send(*frame, trouble);
    EXPECT_FALSE(client.receive(copy.front())) << "it has come before";
    copy.clear();
    for (const can::Frame& frame : drive.take_frames()) {
      ++answers;
      client.receive(frame);
    }
  }
  void read_whole() {
    std::vector<std::uint8_t> read(drive.bytes_of_object().size());
    ASSERT_TRUE(client.begin_upload({.index = 0x2F00}, read));
    work();
    ASSERT_EQ(client.state(), SdoState::done);
    EXPECT_EQ(read, drive.bytes_of_object());
  }

  std::int64_t now_ns = 0;
  int answers = 0;
  int requests = 0;
  std::vector<can::Frame> copy;
  Server drive;
  can::SdoClient client{*can::NodeId::make(5), 50'000'000};
};

constexpr can::ObjectAddress object{.index = 0x2F00};

template <class Server>
class SdoSegments : public testing::Test {};
struct ServerNames {
  template <class Server>
  static std::string GetName(int number) {
    return number == 0 ? "OwnServer" : "SimulatedDrive";
  }
};
using Servers = testing::Types<OwnServer, SimulatedServer>;
TYPED_TEST_SUITE(SdoSegments, Servers, ServerNames);

TYPED_TEST(SdoSegments, EverySizeUpTo2000BytesIsReadAndWritten) {
  for (std::size_t size = 1; size <= 2000; ++size) {
    Transfer<TypeParam> transfer(size);
    std::vector<std::uint8_t> read(2000);
    ASSERT_TRUE(transfer.client.begin_upload(object, read));
    transfer.work();
    ASSERT_EQ(transfer.client.state(), SdoState::done) << size;
    ASSERT_EQ(transfer.client.length(), size);
    read.resize(size);
    EXPECT_EQ(read, transfer.drive.bytes_of_object());
    const std::vector<std::uint8_t> written = pattern(size);
    ASSERT_TRUE(transfer.client.begin_download(object, written));
    transfer.work();
    ASSERT_EQ(transfer.client.state(), SdoState::done) << size;
    EXPECT_EQ(transfer.drive.bytes_of_object(), written);
  }
}

TYPED_TEST(SdoSegments, WhatHasNoRoomIsRefusedAndTheDeviceIsTold) {
  Transfer<TypeParam> transfer(21);
  std::vector<std::uint8_t> read(20);
  ASSERT_TRUE(transfer.client.begin_upload(object, read));
  transfer.work();
  EXPECT_EQ(transfer.client.state(), SdoState::failed);
  EXPECT_EQ(transfer.client.abort_code(), 0x05040005U);
  transfer.read_whole();
}

TYPED_TEST(SdoSegments, AnAbortOfTheDeviceEndsATransfer) {
  Transfer<TypeParam> transfer(21);
  const std::vector<std::uint8_t> another = pattern(22);
  ASSERT_TRUE(transfer.client.begin_download(object, another));
  transfer.work();
  EXPECT_EQ(transfer.client.state(), SdoState::failed);
  EXPECT_EQ(transfer.client.abort_code(), 0x06070010U);
  EXPECT_FALSE(transfer.client.has_given_up());
  EXPECT_NE(transfer.drive.bytes_of_object(), another);
}

TYPED_TEST(SdoSegments, ALostOrLateSegmentIsATimeoutAndTheNextTransferIsWhole) {
  for (int answer = 0; answer < 4; ++answer) {
    for (const bool is_late : {false, true}) {
      Transfer<TypeParam> transfer(21);
      std::vector<std::uint8_t> read(21);
      ASSERT_TRUE(transfer.client.begin_upload(object, read));
      is_late ? transfer.work({.late_answer = answer}) : transfer.work({.lost_answer = answer});
      EXPECT_EQ(transfer.client.state(), SdoState::failed);
      EXPECT_EQ(transfer.client.abort_code(), 0x05040000U);
      ASSERT_TRUE(transfer.client.begin_upload(object, read));
      transfer.work();
      EXPECT_EQ(transfer.client.state(), SdoState::done);
      EXPECT_EQ(read, transfer.drive.bytes_of_object());
    }
  }
}

TYPED_TEST(SdoSegments, ASegmentThatComesTwiceDoesNoHarm) {
  for (int answer = 0; answer < 3; ++answer) {
    Transfer<TypeParam> transfer(21);
    std::vector<std::uint8_t> read(21);
    ASSERT_TRUE(transfer.client.begin_upload(object, read));
    transfer.work({.doubled_answer = answer});
    EXPECT_EQ(transfer.client.state(), SdoState::done) << answer;
    EXPECT_EQ(read, transfer.drive.bytes_of_object());
    const std::vector<std::uint8_t> written = pattern(21);
    Transfer<TypeParam> other(21);
    ASSERT_TRUE(other.client.begin_download(object, written));
    other.work({.doubled_answer = answer});
    EXPECT_EQ(other.client.state(), SdoState::done) << answer;
    EXPECT_EQ(other.drive.bytes_of_object(), written);
  }
}

TYPED_TEST(SdoSegments, ALostRequestAndOneThatComesTwiceEndATransferAndTheNextOneIsWhole) {
  for (int request = 0; request < 4; ++request) {
    for (const bool is_upload : {true, false}) {
      Transfer<TypeParam> lost(21), doubled(21);
      for (Transfer<TypeParam>* const transfer : {&lost, &doubled}) {
        std::vector<std::uint8_t> read(21);
        const std::vector<std::uint8_t> written = pattern(21);
        const std::vector<std::uint8_t> before = transfer->drive.bytes_of_object();
        ASSERT_TRUE(is_upload ? transfer->client.begin_upload(object, read)
                              : transfer->client.begin_download(object, written));
        const bool is_lost = transfer == &lost;
        is_lost ? transfer->work({.lost_request = request}) : transfer->work({.doubled_request = request});
        // What begins a transfer begins it anew, and nobody waits for anything after its end.
        const bool is_harmless = !is_lost && (request == 0 || request == 3);
        EXPECT_EQ(transfer->client.state(), is_harmless ? SdoState::done : SdoState::failed) << request;
        // The device has ended it, 05030000, before the next request: nothing answers that.
        EXPECT_EQ(transfer->client.abort_code(), is_harmless ? 0U : 0x05040000U);
        const bool is_written = is_harmless && !is_upload;
        EXPECT_EQ(transfer->drive.bytes_of_object(), is_written ? written : before);
        transfer->read_whole();
      }
    }
  }
}

// --- every abort of CiA 301, table 22

struct Abort {
  std::uint32_t code;
  const char* words;  ///< that a message about it has
};
constexpr std::array aborts{
    Abort{0x05030000, "toggle bit"},       Abort{0x05040000, "no answer in time"},
    Abort{0x05040001, "command"},          Abort{0x05040002, "block size"},
    Abort{0x05040003, "sequence number"},  Abort{0x05040004, "checksum"},
    Abort{0x05040005, "out of memory"},    Abort{0x06010000, "cannot be accessed"},
    Abort{0x06010001, "only be written"},  Abort{0x06010002, "only be read"},
    Abort{0x06020000, "no such object"},   Abort{0x06040041, "cannot be mapped"},
    Abort{0x06040042, "longer than"},      Abort{0x06040043, "do not go together"},
    Abort{0x06040047, "not compatible"},   Abort{0x06060000, "hardware"},
    Abort{0x06070010, "another length"},   Abort{0x06070012, "too long"},
    Abort{0x06070013, "too short"},        Abort{0x06090011, "no such sub-index"},
    Abort{0x06090030, "not allowed"},      Abort{0x06090031, "too high"},
    Abort{0x06090032, "too low"},          Abort{0x06090036, "less than the minimum"},
    Abort{0x060A0023, "resource"},         Abort{0x08000000, "does not name"},
    Abort{0x08000020, "cannot be stored"}, Abort{0x08000021, "local control"},
    Abort{0x08000022, "present state"},    Abort{0x08000023, "object dictionary"},
    Abort{0x08000024, "no data"},          Abort{0x0BADC0DE, "CiA 301 does not name"},
};

/// The announcement of 21 bytes, and their segments.
constexpr int first_segment = 1, middle_segment = 2, last_segment = 3;

/// One that goes on when the abort comes.
template <class Server>
struct AbortedTransfer : Transfer<Server> {
  explicit AbortedTransfer(bool uploads) : Transfer<Server>(21), is_upload(uploads) {
    EXPECT_TRUE(is_upload ? this->client.begin_upload(object, read)
                          : this->client.begin_download(object, written));
  }
  /// Neither side says another word, nothing was written, and the next transfers are whole.
  void expect_clean_end() {
    EXPECT_EQ(this->client.poll(this->now_ns + 1'000'000'000), std::nullopt);
    EXPECT_TRUE(this->drive.take_frames().empty());
    EXPECT_EQ(this->drive.bytes_of_object(), before);
    this->read_whole();
    ASSERT_TRUE(this->client.begin_download(object, written));
    this->work();
    EXPECT_EQ(this->client.state(), SdoState::done);
    EXPECT_EQ(this->drive.bytes_of_object(), written);
  }
  bool is_upload;
  std::vector<std::uint8_t> read = std::vector<std::uint8_t>(21);
  std::vector<std::uint8_t> written = pattern(21);
  std::vector<std::uint8_t> before = this->drive.bytes_of_object();
};

TYPED_TEST(SdoSegments, EveryAbortOfTheDeviceEndsATransferAtAnySegmentAndIsToldInWords) {
  for (const Abort& abort : aborts) {
    for (const bool is_upload : {true, false}) {
      for (const int segment : {0, first_segment, middle_segment, last_segment}) {
        SCOPED_TRACE(testing::Message() << std::hex << abort.code << ' ' << is_upload << ' ' << segment);
        AbortedTransfer<TypeParam> transfer(is_upload);
        transfer.work({.answered = {{.number = segment, .code = abort.code}}});
        EXPECT_EQ(transfer.client.state(), SdoState::failed);
        EXPECT_EQ(transfer.client.abort_code(), abort.code);
        EXPECT_FALSE(transfer.client.has_given_up());
        const std::string message =
            words_of(can::SetupRefusal{.object = object, .abort_code = transfer.client.abort_code()});
        EXPECT_THAT(message, testing::HasSubstr(abort.words));
        // The last segment of a download had been taken before its answer was lost to the abort.
        if (!is_upload && segment == last_segment) transfer.before = transfer.written;
        transfer.expect_clean_end();
      }
    }
  }
}

TYPED_TEST(SdoSegments, EveryAbortOfTheClientEndsATransferAtAnySegment) {
  for (const Abort& abort : aborts) {
    for (const bool is_upload : {true, false}) {
      for (const int segment : {first_segment, middle_segment, last_segment}) {
        SCOPED_TRACE(testing::Message() << std::hex << abort.code << ' ' << is_upload << ' ' << segment);
        AbortedTransfer<TypeParam> transfer(is_upload);
        transfer.work({.requested = {{.number = segment, .code = abort.code}}});
        EXPECT_EQ(transfer.answers, segment) << "an abort is not answered";
        transfer.expect_clean_end();
      }
    }
  }
}

/// What the simulated drive answers to requests that a client would not send.
class SdoServer : public testing::Test {
 protected:
  SimulatedServer drive{21};
  std::uint32_t reason(const SdoMessage& request) { return reason(can::sdo_frame(0x605, request)); }
  /// Of the abort; 0 where the answer is none.
  std::uint32_t reason(const can::Frame& frame) {
    drive.receive(frame);
    const std::vector<can::Frame> answers = drive.take_frames();
    EXPECT_EQ(answers.size(), 1U);
    const SdoMessage answer = can::read_sdo_answer(answers.at(0)).value();
    return answer.kind == SdoKind::abort ? answer.value : 0;
  }
  void begin_download() {
    ASSERT_EQ(reason({.kind = SdoKind::announce_download, .object = object, .value = 21}), 0U);
  }
  static SdoMessage segment(bool toggle, std::uint8_t size = 7, bool is_last = false) {
    return {.kind = SdoKind::download_segment, .size = size, .toggle = toggle, .is_last = is_last};
  }
};

TEST_F(SdoServer, AbortsATransferWhoseToggleBitDoesNotAlternate) {
  ASSERT_EQ(reason({.kind = SdoKind::upload, .object = object}), 0U);
  EXPECT_EQ(reason({.kind = SdoKind::ask_segment, .toggle = true}), 0x05030000U);
  EXPECT_EQ(reason({.kind = SdoKind::ask_segment, .toggle = false}), 0x05040001U) << "it has ended";
  begin_download();
  EXPECT_EQ(reason(segment(true)), 0x05030000U);
  begin_download();
  EXPECT_EQ(reason(segment(false)), 0U);
  EXPECT_EQ(reason(segment(false)), 0x05030000U);
}

TEST_F(SdoServer, AbortsSegmentsOfNoTransferAndOfTheOtherDirection) {
  EXPECT_EQ(reason(segment(false)), 0x05040001U);
  EXPECT_EQ(reason({.kind = SdoKind::ask_segment}), 0x05040001U);
  begin_download();
  EXPECT_EQ(reason({.kind = SdoKind::ask_segment}), 0x05040001U);
  ASSERT_EQ(reason({.kind = SdoKind::upload, .object = object}), 0U);
  EXPECT_EQ(reason(segment(false)), 0x05040001U);
}

TEST_F(SdoServer, AbortsATransferOfAnotherLengthThanWasAnnounced) {
  EXPECT_EQ(reason({.kind = SdoKind::announce_download, .object = object, .value = 22}), 0x06070010U);
  EXPECT_EQ(reason({.kind = SdoKind::announce_download, .object = object, .value = 0}), 0x06070010U);
  begin_download();
  EXPECT_EQ(reason(segment(false, 7, true)), 0x06070010U) << "too early";
  begin_download();
  EXPECT_EQ(reason(segment(false)), 0U);
  EXPECT_EQ(reason(segment(true)), 0U);
  EXPECT_EQ(reason(segment(false)), 0U);
  EXPECT_EQ(reason(segment(true, 1, true)), 0x06070010U) << "a byte too many";
}

TEST_F(SdoServer, AbortsWhatIsNotThereCannotBeWrittenOrIsNotSpoken) {
  const auto announce = [&](std::uint16_t index, std::uint8_t sub) {
    return reason({.kind = SdoKind::announce_download, .object = {.index = index, .sub = sub}, .value = 23});
  };
  EXPECT_EQ(announce(0x2FFF, 0), 0x06020000U);
  EXPECT_EQ(announce(0x2F00, 1), 0x06090011U);
  EXPECT_EQ(announce(0x1008, 0), 0x06010002U);
  for (const unsigned command : {0xA0U, 0xC2U, 0xE0U, 0x20U}) {  // block transfer; a size that is not told
    EXPECT_EQ(reason(can::Frame{.id = 0x605, .length = 8, .data = {static_cast<std::uint8_t>(command)}}),
              0x05040001U);
  }
  drive.add_object({.index = 0x2F01}, {.access = ObjectDictionary::Access::write_only});
  EXPECT_EQ(reason({.kind = SdoKind::upload, .object = {.index = 0x2F01}}), 0x06010001U);
}

TEST_F(SdoServer, TakesANumberInSegmentsAndForgetsATransferThatIsAborted) {
  const SdoMessage announcement{.kind = SdoKind::announce_download, .object = {.index = 0x6065}, .value = 4};
  ASSERT_EQ(reason(announcement), 0U);
  SdoMessage number = segment(false, 4, true);
  number.segment = {0x10, 0x27};
  EXPECT_EQ(reason(number), 0U);
  EXPECT_EQ(drive.objects().value(0x6065), 10'000U);
  begin_download();
  drive.receive(can::sdo_frame(0x605, {.kind = SdoKind::abort, .object = object, .value = 0x08000000}));
  EXPECT_TRUE(drive.take_frames().empty());
  EXPECT_EQ(reason(segment(false)), 0x05040001U);
}

/// What the client says to answers that no right device gives.
class SdoSegmentClient : public testing::Test {
 protected:
  can::SdoClient client{*can::NodeId::make(5), 50'000'000};
  std::vector<std::uint8_t> storage = std::vector<std::uint8_t>(21);
  const std::vector<std::uint8_t> bytes = pattern(21);
  void hear(const SdoMessage& answer) {
    client.poll(0);
    client.receive(can::sdo_frame(0x585, answer));
  }
  /// The reason that the device is told with the next frame; 0: it is told none.
  std::uint32_t told() {
    const auto frame = client.poll(0);
    const auto message = frame ? can::read_sdo_request(*frame) : std::nullopt;
    return message && message->kind == SdoKind::abort ? message->value : 0;
  }
  void begin_upload() {
    ASSERT_TRUE(client.begin_upload(object, storage));
    hear({.kind = SdoKind::announce_upload, .object = object, .value = 21});
  }
  void begin_download() {
    ASSERT_TRUE(client.begin_download(object, bytes));
    hear({.kind = SdoKind::download_done, .object = object});
  }
};

TEST_F(SdoSegmentClient, AbortsWhereTheToggleBitDoesNotAlternate) {
  begin_upload();
  hear({.kind = SdoKind::upload_segment, .size = 7, .toggle = true});
  EXPECT_EQ(told(), 0x05030000U);
  begin_download();
  hear({.kind = SdoKind::download_segment_done, .toggle = true});
  EXPECT_EQ(told(), 0x05030000U);
}

TEST_F(SdoSegmentClient, AbortsWhereTheLengthIsNotWhatWasAnnounced) {
  begin_upload();
  hear({.kind = SdoKind::upload_segment, .size = 7, .is_last = true});
  EXPECT_EQ(told(), 0x06070010U);
  begin_upload();
  hear({.kind = SdoKind::upload_segment, .size = 0});
  EXPECT_EQ(told(), 0x06070010U);
  begin_upload();
  for (const bool toggle : {false, true, false}) {
    hear({.kind = SdoKind::upload_segment, .size = 7, .toggle = toggle});
  }
  hear({.kind = SdoKind::upload_segment, .size = 7, .toggle = true, .is_last = true});
  EXPECT_EQ(told(), 0x05040005U);
  ASSERT_TRUE(client.begin_upload(object, storage));
  hear({.kind = SdoKind::announce_upload, .object = object, .value = 22});
  EXPECT_EQ(told(), 0x05040005U);
}

TEST_F(SdoSegmentClient, AbortsWhereTheAnswerIsToAnotherRequest) {
  begin_upload();
  hear({.kind = SdoKind::download_segment_done});
  EXPECT_EQ(told(), 0x05040001U);
  begin_download();
  hear({.kind = SdoKind::upload_segment, .size = 7});
  EXPECT_EQ(told(), 0x05040001U);
}

/// Every reason that the client has, at the first, a middle and the last segment.
TEST_F(SdoSegmentClient, TellsTheDeviceWhyItEndsATransferAtAnySegment) {
  struct Wrong {
    bool is_upload;
    std::uint32_t code;
    std::function<void(SdoMessage&)> change;
  };
  const std::array wrongs{
      Wrong{true, 0x05030000, [](SdoMessage& answer) { answer.toggle = !answer.toggle; }},
      Wrong{false, 0x05030000, [](SdoMessage& answer) { answer.toggle = !answer.toggle; }},
      Wrong{true, 0x05040001, [](SdoMessage& answer) { answer.kind = SdoKind::download_segment_done; }},
      Wrong{false, 0x05040001, [](SdoMessage& answer) { answer.kind = SdoKind::upload_segment; }},
      Wrong{true, 0x06070010, [](SdoMessage& answer) { answer.size = 0, answer.is_last = false; }},
  };
  for (const Wrong& wrong : wrongs) {
    for (int wrong_segment = first_segment; wrong_segment <= last_segment; ++wrong_segment) {
      SCOPED_TRACE(testing::Message() << std::hex << wrong.code << ' ' << wrong_segment);
      wrong.is_upload ? begin_upload() : begin_download();
      for (int segment = first_segment; segment <= wrong_segment; ++segment) {
        SdoMessage answer{.kind = wrong.is_upload ? SdoKind::upload_segment : SdoKind::download_segment_done,
                          .size = static_cast<std::uint8_t>(wrong.is_upload ? 7 : 0),
                          .toggle = segment % 2 == 0,
                          .is_last = wrong.is_upload && segment == last_segment};
        answer.segment.fill(static_cast<std::uint8_t>(segment));
        if (segment == wrong_segment) wrong.change(answer);
        hear(answer);
      }
      if (!wrong.is_upload && wrong.code == 0x05030000 && wrong_segment != first_segment) {
        // Bit by bit this is the answer before, which may come twice on CAN: it is not taken for another.
        EXPECT_EQ(client.state(), SdoState::waiting);
        static_cast<void>(client.poll(60'000'000));
        EXPECT_EQ(client.abort_code(), 0x05040000U);
        continue;
      }
      EXPECT_EQ(told(), wrong.code);
      EXPECT_EQ(told(), 0U) << "once";
      EXPECT_EQ(client.state(), SdoState::failed);
      EXPECT_TRUE(client.has_given_up());
    }
  }
}

TEST_F(SdoSegmentClient, EndsWithTheReasonOfTheDevice) {
  for (const std::uint32_t code : {0x05030000U, 0x05040005U, 0x06070012U, 0x08000022U}) {
    begin_upload();
    hear({.kind = SdoKind::abort, .object = object, .value = code});
    EXPECT_EQ(client.state(), SdoState::failed);
    EXPECT_EQ(client.abort_code(), code);
    EXPECT_EQ(told(), 0U);
    begin_download();
    hear({.kind = SdoKind::abort, .object = object, .value = code});
    EXPECT_EQ(client.abort_code(), code);
    EXPECT_EQ(told(), 0U);
  }
}

}  // namespace sdo_segments_test
}  // namespace inbetween
