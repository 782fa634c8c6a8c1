// SDO in segments against a server of the tests' own: every size, both ways, and frames that are lost,
// doubled or late.
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "inbetween/can/sdo_client.hpp"
#include "tests/support/quirky_drive.hpp"

namespace inbetween {
namespace sdo_segments_test {

using can::SdoState;

/// A client and a drive with an object 2F00 of `size` bytes, a millisecond between a request and its answer.
struct Transfer {
  explicit Transfer(std::size_t size) : drive("sizes = { \"2F00\" = " + std::to_string(size) + " }") {
    for (; now_ns < 20'000'000; now_ns += 1'000'000) drive.advance(now_ns);
    static_cast<void>(drive.take_frames());
  }
  /// Until it has ended. The answer with number `lost` does not come, `doubled` comes twice, and `late` after
  /// the timeout.
  void work(int lost = -1, int doubled = -1, int late = -1) {
    std::vector<can::Frame> held;
    for (int tick = 0; tick < 5000; ++tick) {
      now_ns += 1'000'000;
      if (const auto frame = client.poll(now_ns)) drive.receive(*frame);
      for (const can::Frame& frame : drive.take_frames()) {
        const int number = answers++;
        if (number == late) held.push_back(frame);
        if (number != lost && number != late) client.receive(frame);
        // The copy comes when the next request is on its way.
        if (number == doubled) copy.push_back(frame);
      }
      if (!copy.empty()) {
        now_ns += 1'000'000;
        if (const auto frame = client.poll(now_ns)) drive.receive(*frame);
        EXPECT_FALSE(client.receive(copy.front())) << "it has come before";
        copy.clear();
        for (const can::Frame& frame : drive.take_frames()) {
          ++answers;
          client.receive(frame);
        }
      }
      if (client.state() == SdoState::done || client.state() == SdoState::failed) break;
    }
    for (const can::Frame& frame : held) EXPECT_FALSE(client.receive(frame)) << "it is too late";
  }

  std::int64_t now_ns = 0;
  int answers = 0;
  std::vector<can::Frame> copy;
  QuirkyDrive drive;
  can::SdoClient client{*can::NodeId::make(5), 50'000'000};
};

constexpr can::ObjectAddress object{.index = 0x2F00};

std::vector<std::uint8_t> pattern(std::size_t size) {
  std::vector<std::uint8_t> bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(13 * i + 5);
  return bytes;
}

TEST(SdoSegments, EverySizeUpTo2000BytesIsReadAndWritten) {
  for (std::size_t size = 1; size <= 2000; size += size < 64 ? 1 : 121) {
    Transfer transfer(size);
    std::vector<std::uint8_t> read(2000);
    ASSERT_TRUE(transfer.client.begin_upload(object, read));
    transfer.work();
    ASSERT_EQ(transfer.client.state(), SdoState::done) << size;
    ASSERT_EQ(transfer.client.length(), size);
    read.resize(size);
    EXPECT_EQ(read, transfer.drive.bytes(0x2F00));
    const std::vector<std::uint8_t> written = pattern(size);
    ASSERT_TRUE(transfer.client.begin_download(object, written));
    transfer.work();
    ASSERT_EQ(transfer.client.state(), SdoState::done) << size;
    EXPECT_EQ(transfer.drive.bytes(0x2F00), written);
  }
}

TEST(SdoSegments, WhatHasNoRoomIsRefusedAndTheDeviceIsTold) {
  Transfer transfer(21);
  std::vector<std::uint8_t> read(20);
  ASSERT_TRUE(transfer.client.begin_upload(object, read));
  transfer.work();
  EXPECT_EQ(transfer.client.state(), SdoState::failed);
  EXPECT_EQ(transfer.client.abort_code(), 0x05040005U);
}

TEST(SdoSegments, AnAbortOfTheDeviceEndsATransferAtItsLastSegment) {
  Transfer transfer(21);
  const std::vector<std::uint8_t> another = pattern(22);
  ASSERT_TRUE(transfer.client.begin_download(object, another));
  transfer.work();
  EXPECT_EQ(transfer.client.state(), SdoState::failed);
  EXPECT_EQ(transfer.client.abort_code(), 0x06070010U);
  EXPECT_FALSE(transfer.client.has_given_up());
  EXPECT_NE(transfer.drive.bytes(0x2F00), another);
}

TEST(SdoSegments, ALostOrLateSegmentIsATimeoutAndTheNextTransferIsWhole) {
  for (int answer = 0; answer < 4; ++answer) {
    for (const bool is_late : {false, true}) {
      Transfer transfer(21);
      std::vector<std::uint8_t> read(21);
      ASSERT_TRUE(transfer.client.begin_upload(object, read));
      is_late ? transfer.work(-1, -1, answer) : transfer.work(answer);
      EXPECT_EQ(transfer.client.state(), SdoState::failed);
      EXPECT_EQ(transfer.client.abort_code(), 0x05040000U);
      ASSERT_TRUE(transfer.client.begin_upload(object, read));
      transfer.work();
      EXPECT_EQ(transfer.client.state(), SdoState::done);
      EXPECT_EQ(read, transfer.drive.bytes(0x2F00));
    }
  }
}

TEST(SdoSegments, ASegmentThatComesTwiceDoesNoHarm) {
  for (int answer = 0; answer < 3; ++answer) {
    Transfer transfer(21);
    std::vector<std::uint8_t> read(21);
    ASSERT_TRUE(transfer.client.begin_upload(object, read));
    transfer.work(-1, answer);
    EXPECT_EQ(transfer.client.state(), SdoState::done) << answer;
    EXPECT_EQ(read, transfer.drive.bytes(0x2F00));
    const std::vector<std::uint8_t> written = pattern(21);
    Transfer other(21);
    ASSERT_TRUE(other.client.begin_download(object, written));
    other.work(-1, answer);
    EXPECT_EQ(other.client.state(), SdoState::done) << answer;
    EXPECT_EQ(other.drive.bytes(0x2F00), written);
  }
}

}  // namespace sdo_segments_test
}  // namespace inbetween
