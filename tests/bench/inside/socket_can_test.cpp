#include "drivers/can/socket_can.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "tests/bench/inside/raw_bus.hpp"

namespace inbetween::can {
namespace socket_can_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::vector<CanFilter> answers = {{.id = 0x181}, {.id = 0x182}};

Frame frame_of(FrameId id, const std::vector<std::uint8_t>& bytes = {}) {
  Frame frame;
  frame.id = id;
  frame.length = static_cast<std::uint8_t>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), frame.data.begin());
  return frame;
}

void open_can0(SocketCan& bus, const std::vector<CanFilter>& filters = answers) {
  const std::optional<Refusal> refusal = bus.open("can0", filters);
  ASSERT_FALSE(refusal) << refusal->what;
}

/// Asks again until a condition holds, at most five seconds.
template <class Condition>
bool comes_true(Condition condition) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(5);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::yield();
  }
  return true;
}

/// What comes in until a frame with this first byte does, that one included; at most five seconds.
std::vector<Frame> received_until(SocketCan& bus, std::uint8_t last) {
  std::vector<Frame> all;
  std::array<Frame, SocketCan::max_frames> some;
  const bool has_come = comes_true([&] {
    const std::size_t count = bus.receive(some);
    all.insert(all.end(), some.begin(), some.begin() + static_cast<std::ptrdiff_t>(count));
    return !all.empty() && all.back().length > 0 && all.back().data[0] == last;
  });
  EXPECT_TRUE(has_come) << "the frame " << int{last} << " did not come";
  return all;
}

TEST(SocketCan, WhatIsSentIsOnTheBusAsItIs) {
  SocketCan bus;
  open_can0(bus);
  RawBus other("can0");
  Frame extended = frame_of(FrameId::extended(0x1ABCDEF0), {1, 2, 3, 4, 5, 6, 7, 8});
  Frame remote = frame_of(0x705);
  remote.is_remote = true;
  remote.length = 1;
  const std::array<Frame, 4> frames = {frame_of(0x80), frame_of(0x201, {0x0F, 0, 0xFE}), extended, remote};
  EXPECT_EQ(bus.send(frames), 4U);

  const auto sees = [&](std::uint32_t id, const std::vector<std::uint8_t>& bytes, std::uint8_t length) {
    const auto seen = other.next();
    ASSERT_TRUE(seen);
    EXPECT_EQ(seen->can_id, id);
    EXPECT_EQ(seen->len, length);
    EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), std::begin(seen->data)));
  };
  sees(0x80, {}, 0);
  sees(0x201, {0x0F, 0, 0xFE}, 3);
  sees(0x1ABCDEF0 | CAN_EFF_FLAG, {1, 2, 3, 4, 5, 6, 7, 8}, 8);
  sees(0x705 | CAN_RTR_FLAG, {}, 1);
  EXPECT_FALSE(other.waiting());
  EXPECT_EQ(bus.counters().sent, 4U);
  EXPECT_EQ(bus.counters().unsent, 0U);
}

TEST(SocketCan, OnlyFramesThatAFilterNamesComeIn) {
  SocketCan bus;
  const std::vector<CanFilter> filters = {{.id = 0x181}, {.id = FrameId::extended(0x12345)}};
  open_can0(bus, filters);
  RawBus other("can0");
  RawBus elsewhere("can1");
  elsewhere.send(0x181, {1});               // another bus
  other.send(0x180, {2});                   // another identifier
  other.send(0x181 | CAN_EFF_FLAG, {3});    // the same number, but extended
  other.send(0x181 | CAN_RTR_FLAG, {});     // a remote frame
  other.send(0x12345 & CAN_SFF_MASK, {4});  // the low bits of an extended one
  other.send(0x12345 | CAN_EFF_FLAG, {5, 6});
  other.send(0x181, {0xFF, 0xEE});
  Frame extended = frame_of(FrameId::extended(0x12345), {5, 6});
  EXPECT_THAT(received_until(bus, 0xFF), ElementsAre(extended, frame_of(0x181, {0xFF, 0xEE})));
  EXPECT_EQ(bus.counters().received, 2U);
}

TEST(SocketCan, WithoutAFilterNoFrameComesIn) {
  SocketCan bus;
  open_can0(bus, {});
  RawBus other("can0");
  other.send(0x181, {1});
  other.send(CAN_ERR_FLAG | CAN_ERR_RESTARTED, std::vector<std::uint8_t>(8));
  std::array<Frame, 8> frames;
  EXPECT_TRUE(comes_true([&] { return bus.receive(frames) != 0 || bus.counters().restarts == 1; }));
  EXPECT_EQ(bus.counters().received, 0U);
}

TEST(SocketCan, WhatItSendsItselfDoesNotComeBackButWhatAnotherProgramSendsDoes) {
  SocketCan bus;
  SocketCan foreign;
  open_can0(bus);
  open_can0(foreign);
  bus.send(std::array{frame_of(0x181, {1})});
  foreign.send(std::array{frame_of(0x181, {2})});
  EXPECT_THAT(received_until(bus, 2), ElementsAre(frame_of(0x181, {2})));
}

TEST(SocketCan, OneCallTakesNoMoreThanItIsMadeFor) {
  SocketCan bus;
  open_can0(bus);
  RawBus other("can0");
  for (std::uint8_t i = 0; i < 100; ++i) other.send(0x181, {i});
  std::array<Frame, 200> frames;
  ASSERT_TRUE(comes_true([&] { return bus.receive(std::span(frames).first(1)) == 1; }));
  EXPECT_EQ(bus.receive(std::span(frames).first(3)), 3U);
  EXPECT_EQ(frames[2], frame_of(0x181, {3}));
  EXPECT_EQ(bus.receive(frames), SocketCan::max_frames);
  EXPECT_EQ(bus.receive(frames), 100 - 4 - SocketCan::max_frames);
  EXPECT_EQ(bus.receive(frames), 0U);
  EXPECT_EQ(bus.receive({}), 0U);
}

TEST(SocketCan, FramesThatAreNotClassicCanAreNotSentNorTheirNeighbours) {
  SocketCan bus;
  open_can0(bus);
  RawBus other("can0");
  const std::vector<Frame> too_many(SocketCan::max_frames + 1, frame_of(0x201));
  Frame long_one = frame_of(0x201);
  long_one.length = 9;
  EXPECT_EQ(bus.send(too_many), 0U);
  EXPECT_EQ(bus.send(std::array{frame_of(0x201), long_one}), 0U);
  EXPECT_EQ(bus.send(std::array{long_one}), 0U);
  EXPECT_EQ(bus.counters().failed_sends, 3U);
  EXPECT_EQ(bus.counters().unsent, too_many.size() + 3);
  EXPECT_EQ(bus.send(std::array{frame_of(0x7FF)}), 1U);
  EXPECT_EQ(other.next()->can_id, 0x7FFU);
}

TEST(SocketCan, WhatFindsTheQueueFullIsCountedAndNeverSentLater) {
  SocketCan bus;
  open_can0(bus);
  RawBus other("can0");
  shell("tc qdisc add dev can0 root netem delay 2s limit 2");
  EXPECT_EQ(bus.send(std::array{frame_of(1), frame_of(2), frame_of(3), frame_of(4), frame_of(5)}), 2U);
  EXPECT_EQ(bus.counters().full_queue, 1U);
  EXPECT_EQ(bus.send(std::array{frame_of(6)}), 0U);
  EXPECT_EQ(bus.counters().full_queue, 2U);
  EXPECT_EQ(bus.counters().sent, 2U);
  EXPECT_EQ(bus.counters().unsent, 4U);
  EXPECT_EQ(bus.link(), LinkState::up);
  EXPECT_FALSE(other.waiting());

  EXPECT_EQ(other.next()->can_id, 1U);
  EXPECT_EQ(other.next()->can_id, 2U);
  shell("tc qdisc del dev can0 root");
  EXPECT_EQ(bus.send(std::array{frame_of(7)}), 1U);
  EXPECT_EQ(other.next()->can_id, 7U);
  EXPECT_FALSE(other.waiting());
  EXPECT_EQ(bus.counters().failed_sends, 0U);
}

TEST(SocketCan, ALinkThatWentDownStaysDownUntilItIsOpenedAgain) {
  SocketCan bus;
  open_can0(bus);
  std::array<Frame, 4> frames;
  shell("ip link set can0 down");
  EXPECT_EQ(bus.receive(frames), 0U);
  EXPECT_EQ(bus.link(), LinkState::down);

  shell("ip link set can0 up");
  EXPECT_EQ(bus.send(std::array{frame_of(1)}), 0U) << "the cable is back, and nobody has asked";
  EXPECT_EQ(bus.counters().unsent, 1U);
  open_can0(bus);
  EXPECT_EQ(bus.link(), LinkState::up);
  RawBus other("can0");
  EXPECT_EQ(bus.send(std::array{frame_of(2)}), 1U);
  EXPECT_EQ(other.next()->can_id, 2U);
  other.send(0x181, {9});
  EXPECT_THAT(received_until(bus, 9), ElementsAre(frame_of(0x181, {9})));
}

TEST(SocketCan, AShortInterruptionIsSeenToo) {
  SocketCan bus;
  open_can0(bus);
  shell("ip link set can0 down");
  shell("ip link set can0 up");
  EXPECT_EQ(bus.send(std::array{frame_of(1)}), 0U);
  EXPECT_EQ(bus.link(), LinkState::down);
}

TEST(SocketCan, ADeletedInterfaceIsGoneThoughAnotherTakesItsName) {
  for (const bool by_sending : {false, true}) {
    SocketCan bus;
    open_can0(bus);
    std::array<Frame, 4> frames;
    shell("ip link del can0");
    // The first call may tell only that it went down.
    for (int call = 0; call < 2; ++call) {
      EXPECT_EQ(by_sending ? bus.send(std::array{frame_of(1)}) : bus.receive(frames), 0U);
    }
    EXPECT_NE(bus.link(), LinkState::up);
    shell("ip link add can0 type vcan && ip link set can0 up");
    EXPECT_EQ(bus.send(std::array{frame_of(1)}), 0U);
    open_can0(bus);
    EXPECT_EQ(bus.send(std::array{frame_of(1)}), 1U);
  }
}

TEST(SocketCan, StaleFramesAreThrownAwayAndCounted) {
  SocketCan bus;
  open_can0(bus);
  RawBus other("can0");
  for (int i = 0; i < 150; ++i) other.send(0x181, {1});
  std::uint64_t stale = 0;
  ASSERT_TRUE(comes_true([&] {
    const SocketCan::Drained drained = bus.drain();
    stale += drained.stale;
    EXPECT_TRUE(drained.is_empty);
    return stale >= 150;
  }));
  EXPECT_EQ(stale, 150U);
  EXPECT_EQ(bus.counters().stale, 150U);
  EXPECT_EQ(bus.counters().received, 0U);
  other.send(0x182, {2});
  EXPECT_THAT(received_until(bus, 2), ElementsAre(frame_of(0x182, {2})));
}

TEST(SocketCan, FramesThatFoundTheQueueOfTheSocketFullAreCounted) {
  SocketCan bus;
  open_can0(bus);
  RawBus other("can0");
  constexpr std::uint64_t flood = 5000;
  for (std::uint64_t i = 0; i < flood; ++i) other.send(0x181, {1});
  // The kernel tells of what it dropped with the next frame that it keeps.
  const std::uint64_t stale = bus.drain().stale;
  EXPECT_LT(stale, flood);
  other.send(0x181, {2});
  EXPECT_EQ(received_until(bus, 2).size(), 1U);
  EXPECT_EQ(bus.counters().receive_drops, flood - stale);
}

TEST(SocketCan, TheControllerIsAsItsErrorFramesTell) {
  SocketCan bus;
  open_can0(bus);
  RawBus other("can0");
  std::array<Frame, 8> frames;
  const auto after = [&](std::uint32_t error_class, std::uint8_t controller) {
    const std::uint64_t before = bus.counters().error_frames;
    other.send(CAN_ERR_FLAG | error_class, {0, controller, 0, 0, 0, 0, 0, 0});
    EXPECT_TRUE(comes_true([&] {
      EXPECT_EQ(bus.receive(frames), 0U) << "an error frame is not a frame of the bus";
      return bus.counters().error_frames == before + 1;
    }));
    return bus.controller();
  };
  EXPECT_EQ(bus.controller(), ControllerState::active);
  EXPECT_EQ(after(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_WARNING), ControllerState::warning);
  EXPECT_EQ(after(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_PASSIVE), ControllerState::passive);
  EXPECT_EQ(after(CAN_ERR_ACK, 0), ControllerState::passive);
  EXPECT_EQ(after(CAN_ERR_CRTL, CAN_ERR_CRTL_ACTIVE), ControllerState::active);
  EXPECT_EQ(after(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_OVERFLOW), ControllerState::active);
  EXPECT_EQ(after(CAN_ERR_BUSOFF | CAN_ERR_CRTL, CAN_ERR_CRTL_TX_PASSIVE), ControllerState::bus_off);
  EXPECT_EQ(after(CAN_ERR_CRTL, CAN_ERR_CRTL_ACTIVE), ControllerState::bus_off) << "only a restart ends it";
  EXPECT_EQ(after(CAN_ERR_RESTARTED, 0), ControllerState::active);
  EXPECT_EQ(bus.counters().unacknowledged, 1U);
  EXPECT_EQ(bus.counters().controller_overflows, 1U);
  EXPECT_EQ(bus.counters().passives, 2U);
  EXPECT_EQ(bus.counters().bus_offs, 1U);
  EXPECT_EQ(bus.counters().restarts, 1U);
}

TEST(SocketCan, AnInterfaceThatCannotBeUsedIsNamedWithTheRemedy) {
  SocketCan bus;
  const auto refused = [&](const std::string& interface) {
    const std::optional<Refusal> refusal = bus.open(interface, answers);
    EXPECT_TRUE(refusal) << interface;
    EXPECT_FALSE(bus.is_open());
    EXPECT_EQ(bus.link(), LinkState::gone);
    return refusal.value_or(Refusal{});
  };
  EXPECT_EQ(refused("can7").what, "there is no interface can7");
  EXPECT_EQ(refused("a-name-that-is-too-long").what, "there is no interface a-name-that-is-too-long");
  EXPECT_EQ(refused("").what, "there is no interface ");
  EXPECT_EQ(refused("lo").what, "lo is not a CAN interface");
  shell("ip link set can1 down");
  const Refusal down = refused("can1");
  EXPECT_EQ(down.what, "can1 is down");
  EXPECT_THAT(down.remedy, HasSubstr("ip link set can1 up"));
}

/// A program on can0 that speaks CAN FD and knows nothing of the product.
class RawFdBus {
 public:
  RawFdBus() : socket_(::socket(PF_CAN, SOCK_RAW, CAN_RAW)) {
    const int on = 1;
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(::if_nametoindex("can0"));
    EXPECT_EQ(::setsockopt(socket_, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on), 0);
    EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  ~RawFdBus() { ::close(socket_); }
  RawFdBus(const RawFdBus&) = delete;
  RawFdBus& operator=(const RawFdBus&) = delete;
  void send(const canfd_frame& frame, std::size_t size) const {
    EXPECT_EQ(::write(socket_, &frame, size), static_cast<ssize_t>(size));
  }
  /// How many bytes the next frame has in the kernel.
  ssize_t next(canfd_frame& frame) const {
    frame = {};
    return ::read(socket_, &frame, sizeof frame);
  }

 private:
  int socket_;
};

TEST(SocketCan, FdFramesAndClassicOnesAmongThemAreOnTheBusAsTheyAre) {
  SocketCanFd bus;
  const std::vector<CanFilter> filters = {{.id = 0x100}, {.id = FrameId::extended(0x8001)}};
  ASSERT_FALSE(bus.open("can0", filters));
  const RawFdBus other;
  FdFrame command{.id = FrameId::extended(0x8001), .length = 32};
  for (std::size_t i = 0; i < 32; ++i) command.data.at(i) = static_cast<std::uint8_t>(i + 1);
  FdFrame classic{.id = 0x100, .is_classic = true, .has_fast_data = false, .length = 3};
  classic.data = {7, 8, 9};
  FdFrame slow{.id = 0x100, .has_fast_data = false, .length = 64};
  EXPECT_EQ(bus.send(std::array{command, classic, slow}), 3U);
  canfd_frame seen{};
  EXPECT_EQ(other.next(seen), ssize_t{CANFD_MTU});
  EXPECT_EQ(seen.can_id, 0x8001 | CAN_EFF_FLAG);
  EXPECT_EQ(seen.len, 32);
  EXPECT_EQ(seen.flags & CANFD_BRS, CANFD_BRS);
  EXPECT_EQ(seen.data[31], 32);
  EXPECT_EQ(other.next(seen), ssize_t{CAN_MTU});
  EXPECT_EQ(seen.data[2], 9);
  EXPECT_EQ(other.next(seen), ssize_t{CANFD_MTU});
  EXPECT_EQ(seen.flags & CANFD_BRS, 0);

  canfd_frame raw{};
  raw.can_id = 0x100;
  raw.len = 24;
  raw.flags = CANFD_BRS;
  raw.data[23] = 0x50;
  other.send(raw, CANFD_MTU);
  raw.len = 3;
  other.send(raw, CAN_MTU);
  std::vector<FdFrame> heard;
  EXPECT_TRUE(comes_true([&] {
    std::array<FdFrame, 4> some;
    const std::size_t count = bus.receive(some);
    heard.insert(heard.end(), some.begin(), some.begin() + static_cast<std::ptrdiff_t>(count));
    return heard.size() == 2;
  }));
  EXPECT_EQ(heard.at(0).length, 24);
  EXPECT_TRUE(heard.at(0).has_fast_data && !heard.at(0).is_classic);
  EXPECT_EQ(heard.at(0).data[23], 0x50);
  EXPECT_TRUE(heard.at(1).is_classic);
}

TEST(SocketCan, AnFdFrameOfALengthThatNoneHasIsNotSent) {
  SocketCanFd bus;
  ASSERT_FALSE(bus.open("can0", answers));
  EXPECT_EQ(bus.send(std::array{FdFrame{.id = 1, .length = 23}}), 0U);
  EXPECT_EQ(bus.send(std::array{FdFrame{.id = 1, .is_classic = true, .length = 12}}), 0U);
  EXPECT_EQ(bus.counters().failed_sends, 2U);
  EXPECT_EQ(bus.send(std::array{FdFrame{.id = 1, .length = 24}}), 1U);
}

TEST(SocketCan, AnInterfaceWithoutCanFdIsNamedWithTheRemedy) {
  shell("ip link set can1 down; ip link set can1 mtu 16; ip link set can1 up");
  SocketCanFd bus;
  const std::optional<Refusal> refusal = bus.open("can1", answers);
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->what, "can1 does not carry CAN FD frames");
  EXPECT_THAT(refusal->remedy, HasSubstr("dbitrate DATA_BITRATE fd on"));
  SocketCan classic;
  EXPECT_FALSE(classic.open("can1", answers));
  shell("ip link set can1 down; ip link set can1 mtu 72; ip link set can1 up");
  EXPECT_FALSE(bus.open("can1", answers));
}

TEST(SocketCan, AClosedOneSendsAndReceivesNothing) {
  SocketCan bus;
  std::array<Frame, 4> frames;
  EXPECT_EQ(bus.send(std::array{frame_of(1)}), 0U);
  EXPECT_EQ(bus.receive(frames), 0U);
  EXPECT_TRUE(bus.drain().is_empty);
}

}  // namespace socket_can_test
}  // namespace inbetween::can
