// The host's side of a bus with several drives: what is sent when, and what is heard from whom.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "inbetween/can/cia402.hpp"
#include "inbetween/can/cia402_bus.hpp"
#include "inbetween/can/nmt.hpp"
#include "inbetween/can/sdo.hpp"
#include "tests/support/drive_frames.hpp"
#include "tests/support/drive_objects.hpp"

namespace inbetween::can {
namespace can_bus_test {

constexpr std::int64_t ms = 1'000'000;

NodeId node(int number) {
  return NodeId::make(number).value();
}
Cia402Settings settings_of(int number) {
  return {.setup = {.node = node(number), .host = node(127)}, .max_step_counts = 1000};
}
std::vector<Cia402Drive> drives_of(const std::vector<int>& nodes) {
  std::vector<Cia402Drive> drives;
  drives.reserve(nodes.size());
  for (const int number : nodes) drives.push_back(Cia402Drive::make(settings_of(number)).value());
  return drives;
}

TEST(Cia402BusSettings, HostAndDrivesGoTogetherOrAreRefused) {
  std::vector<Cia402Drive> drives = drives_of({1, 2});
  EXPECT_TRUE(Cia402Bus::make(drives, {.host = node(127)}));
  EXPECT_EQ(Cia402Bus::make({}, {.host = node(127)}).error().code, ErrorCode::wrong_count);
  EXPECT_EQ(Cia402Bus::make(drives, {.host = node(126)}).error().axis, 0);
  EXPECT_FALSE(Cia402Bus::make(drives, {.host = node(127), .sync_overflow = 10}));
  EXPECT_FALSE(Cia402Bus::make(drives, {.host = node(127), .heartbeat_period_ns = 34 * ms}));
  EXPECT_FALSE(Cia402Bus::make(drives, {.host = node(127), .heartbeat_period_ns = 0}));
  std::vector<Cia402Drive> twins = drives_of({1, 2, 1});
  const auto refused = Cia402Bus::make(twins, {.host = node(127)});
  EXPECT_EQ(refused.error().code, ErrorCode::no_solution);
  EXPECT_EQ(refused.error().axis, 2);
}

/// Two drives that do whatever they are told at once, node 5 (axis 0) and node 3 (axis 1).
class BusOfTwo : public testing::Test {
 protected:
  std::vector<Cia402Drive> drives = drives_of({5, 3});
  Cia402Bus bus = Cia402Bus::make(drives, {.host = node(127)}).value();
  std::array<DriveObjects, 2> objects;
  std::array<std::uint16_t, 2> statusword{0x0250, 0x0250};
  std::array<NmtState, 2> nmt{NmtState::pre_operational, NmtState::pre_operational};
  std::int64_t now = 0;
  std::vector<Frame> sent;

  void SetUp() override {
    objects[1].set(0x1400, 1, 4, 0x203);
    objects[1].set(0x1800, 1, 4, 0x183);
  }
  static NodeId node_of(std::size_t axis) { return node(axis == 0 ? 5 : 3); }

  void tick(std::vector<std::int32_t> targets = {}) {
    now += 4 * ms;
    std::array<Frame, Cia402Bus::frames_per_tick(2)> frames;
    sent.assign(frames.begin(), frames.begin() + bus.tick(now, targets, frames).value());
    for (const Frame& frame : std::vector<Frame>(sent)) {
      for (std::size_t axis = 0; axis < 2; ++axis) answer(axis, frame);
    }
  }
  void answer(std::size_t axis, const Frame& frame) {
    const NodeId self = node_of(axis);
    if (const auto order = read_nmt(frame); order && order->node == self.value()) {
      const bool starts = order->command == NmtCommand::start;
      nmt.at(axis) = starts ? NmtState::operational : NmtState::pre_operational;
      bus.receive(heartbeat_frame(self, starts ? nmt.at(axis) : NmtState::boot_up), now);
    } else if (frame.id == sdo_request_id(self)) {
      bus.receive(sdo_frame(sdo_answer_id(self), objects.at(axis).answer(*read_sdo_request(frame))), now);
    } else if (frame.id == sync_id && nmt.at(axis) == NmtState::operational) {
      bus.receive(feedback_frame(self, {.statusword = statusword.at(axis), .actual = 100, .mode = 8}), now);
      bus.receive(heartbeat_frame(self, nmt.at(axis)), now);
    } else if (const auto command = read_command(frame, self)) {
      const std::uint16_t word = command->controlword;
      statusword.at(axis) = word == 0x0006   ? 0x0231
                            : word == 0x0007 ? 0x0233
                            : word == 0x000F ? 0x1237
                                             : 0x0250;
    }
  }
  void connect() {
    for (Cia402Drive& drive : drives) ASSERT_TRUE(drive.connect(now));
    for (int i = 0; i < 1000 && !all_are(DrivePhase::idle); ++i) tick();
    ASSERT_TRUE(all_are(DrivePhase::idle));
  }
  void enable() {
    connect();
    for (Cia402Drive& drive : drives) ASSERT_TRUE(drive.enable(now));
    for (int i = 0; i < 10; ++i) tick();
    ASSERT_TRUE(all_are(DrivePhase::following));
  }
  [[nodiscard]] bool all_are(DrivePhase phase) const {
    return drives[0].phase() == phase && drives[1].phase() == phase;
  }
  [[nodiscard]] std::vector<std::uint32_t> ids() const {
    std::vector<std::uint32_t> ids;
    for (const Frame& frame : sent) ids.push_back(frame.id.number());
    return ids;
  }
};

TEST_F(BusOfTwo, NothingIsSentBeforeADriveIsConnected) {
  for (int i = 0; i < 100; ++i) {
    tick();
    EXPECT_TRUE(sent.empty());
  }
}

TEST_F(BusOfTwo, OneRequestATickAndTheDrivesTakeTurns) {
  for (Cia402Drive& drive : drives) drive.connect(now);
  std::array<int, 2> requests{};
  while (!all_are(DrivePhase::starting)) {
    tick();
    int services = 0;
    for (const Frame& frame : sent) {
      if (frame.id == 0x605 || frame.id == 0x603 || frame.id == 0) ++services;
      if (frame.id == 0x605) ++requests[0];
      if (frame.id == 0x603) ++requests[1];
    }
    ASSERT_LE(services, 1);
    ASSERT_LE(std::abs(requests[0] - requests[1]), 2);
    ASSERT_LT(now, 4000 * ms);
  }
}

TEST_F(BusOfTwo, SyncComesFirstThenTheTargetsInTheOrderOfTheAxes) {
  enable();
  std::vector<std::vector<std::uint32_t>> seen;
  for (int i = 0; i < 100; ++i) {
    tick({100 + i, 100 - i});
    std::vector<std::uint32_t> order = ids();
    if (order.back() == 0x77F) order.pop_back();
    ASSERT_EQ(order, (std::vector<std::uint32_t>{0x080, 0x205, 0x203}));
    EXPECT_EQ(read_command(sent[1], node(5))->target, 100 + i);
    EXPECT_EQ(read_command(sent[2], node(3))->target, 100 - i);
  }
}

TEST_F(BusOfTwo, TheHostTellsThatItLivesEvery30Milliseconds) {
  enable();
  int heartbeats = 0;
  const std::int64_t begin = now;
  while (now < begin + 3000 * ms) {
    tick({100, 100});
    for (const Frame& frame : sent) heartbeats += frame.id == 0x77F ? 1 : 0;
  }
  EXPECT_NEAR(heartbeats, 100, 1);
}

TEST_F(BusOfTwo, WhereSetpointsCeaseSoDoesTheHeartbeat) {  // docs/faults.md: SS
  enable();
  tick({100, 100});
  for (int i = 0; i < 100; ++i) {
    tick();
    EXPECT_EQ(ids(), (std::vector<std::uint32_t>{0x080}));
  }
}

TEST_F(BusOfTwo, WhatOnlyTheHostMaySendIsFoundOnTheDrivesThatItConcerns) {  // docs/faults.md 17
  enable();
  bus.receive({.id = 0x205, .length = 6}, now);
  EXPECT_TRUE(drives[0].findings().has(DriveFinding::foreign_sender));
  EXPECT_TRUE(drives[1].findings().empty());
  drives[0].acknowledge();
  bus.receive({.id = 0x603, .length = 8}, now);
  EXPECT_TRUE(drives[0].findings().empty());
  EXPECT_TRUE(drives[1].findings().has(DriveFinding::foreign_sender));
  for (const Frame& frame : {Frame{.id = 0x000, .length = 2, .data = {0x80}}, Frame{.id = 0x080},
                             Frame{.id = 0x77F, .length = 1, .data = {0x05}}}) {
    for (Cia402Drive& drive : drives) drive.acknowledge();
    bus.receive(frame, now);
    for (const Cia402Drive& drive : drives) EXPECT_TRUE(drive.findings().has(DriveFinding::foreign_sender));
  }
}

TEST_F(BusOfTwo, AForeignSenderAtBootKeepsTheDriveOff) {  // docs/faults.md 17
  connect();
  bus.receive({.id = 0x080}, now);
  EXPECT_FALSE(drives[0].enable(now));
  EXPECT_FALSE(drives[1].enable(now));
}

TEST_F(BusOfTwo, FramesOfOthersAreCountedAndLeftAlone) {
  enable();
  bus.receive({.id = 0x709, .length = 1, .data = {0x05}}, now);
  bus.receive({.id = FrameId::extended(0x205), .length = 6}, now);
  bus.receive({.id = 0x705, .is_remote = true}, now);
  bus.receive({.id = 0x7FF, .length = 77}, now);
  for (const Cia402Drive& drive : drives) EXPECT_TRUE(drive.findings().empty());
}

TEST_F(BusOfTwo, TooLittleRoomOrTooFewTargetsAreRefusedBeforeAnythingChanges) {
  enable();
  std::array<Frame, 4> few;
  EXPECT_EQ(bus.tick(now, {}, few).error().needed, 7);
  std::array<Frame, 5> enough;
  const std::array<std::int32_t, 1> target{0};
  EXPECT_EQ(bus.tick(now, target, enough).error().code, ErrorCode::wrong_count);
  tick({100, 100});
  EXPECT_TRUE(drives[0].findings().empty());
}

TEST_F(BusOfTwo, ADriveThatIsGoneDoesNotKeepTheOtherFromItsTargets) {
  enable();
  bus.receive(heartbeat_frame(node(5), NmtState::boot_up), now);
  statusword[0] = 0x0250;
  nmt[0] = NmtState::pre_operational;
  tick({100, 101});
  std::vector<std::uint32_t> order = ids();
  if (order.back() == 0x77F) order.pop_back();
  EXPECT_EQ(order, (std::vector<std::uint32_t>{0x080, 0x203}));
  EXPECT_EQ(drives[1].target(), 101);
}

}  // namespace can_bus_test
}  // namespace inbetween::can
