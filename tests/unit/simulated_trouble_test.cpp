// What goes wrong with a simulated drive, frame by frame.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "inbetween/can/pdo.hpp"
#include "tests/support/simulated_can_rig.hpp"

namespace inbetween {
namespace simulated_trouble_test {

using Kind = DriveTrouble::Kind;

constexpr std::int64_t ms = 1'000'000;

class Trouble : public testing::Test {
 protected:
  SimulatedCanRig rig{2};
  const can::NodeId node = *can::NodeId::make(1);

  void SetUp() override { ASSERT_TRUE(rig.bring_to_following()); }
  void add(DriveTrouble trouble) {
    trouble.at_ns = rig.now_ns;
    rig.drive(0).add_trouble(trouble);
  }
  /// What drive 0 sends in some ticks that only it hears.
  std::vector<can::Frame> sent_in(int ticks) {
    std::vector<can::Frame> frames;
    SimulatedCia402Drive& drive = rig.drive(0);
    for (int i = 0; i < ticks; ++i) {
      rig.now_ns += SimulatedCanRig::tick_ns;
      drive.advance(rig.now_ns);
      drive.receive({.id = can::sync_id});
      for (const can::Frame& frame : drive.take_frames()) frames.push_back(frame);
    }
    return frames;
  }
  [[nodiscard]] std::vector<can::Frame> feedback_in(int ticks) {
    std::vector<can::Frame> frames = sent_in(ticks);
    std::erase_if(frames, [&](const can::Frame& frame) { return frame.id != can::tpdo1_id(node); });
    return frames;
  }
};

TEST_F(Trouble, LosesAsManyFramesAsItIsToldOfWhatItSends) {
  add({.kind = Kind::lose_heartbeat});
  add({.kind = Kind::lose_sent, .frames = 2});
  EXPECT_EQ(feedback_in(5).size(), 3U);
}

TEST_F(Trouble, LosesEverythingThatItSendsWhileItLasts) {
  add({.kind = Kind::lose_sent, .for_ns = 50 * ms});
  EXPECT_TRUE(sent_in(12).empty());
  EXPECT_FALSE(sent_in(2).empty());
}

TEST_F(Trouble, DoesNotHearAsManyFramesOfItsOwnAsItIsTold) {
  add({.kind = Kind::lose_heard, .frames = 2});
  const auto ask = [&](can::NodeId whom) {
    rig.drive(0).receive(can::sdo_frame(can::sdo_request_id(whom),
                                        {.kind = can::SdoKind::upload, .object = {.index = 0x1000}}));
  };
  ask(*can::NodeId::make(2));
  for (int i = 0; i < 5; ++i) ask(node);
  EXPECT_EQ(rig.drive(0).take_frames().size(), 3U);
}

TEST_F(Trouble, ShortensItsFeedbackOnly) {
  add({.kind = Kind::shorten, .frames = 1});
  const std::vector<can::Frame> frames = feedback_in(2);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].length + 1, frames[1].length);
}

TEST_F(Trouble, SendsItsFeedbackTwice) {
  add({.kind = Kind::duplicate, .frames = 1});
  const std::vector<can::Frame> frames = feedback_in(2);
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[0].data, frames[1].data);
}

TEST_F(Trouble, FloodsAtItsRate) {
  add({.kind = Kind::flood, .for_ns = 100 * ms, .value = 3000});
  const std::vector<can::Frame> frames = sent_in(50);
  const auto answers = std::ranges::count(frames, can::sdo_answer_id(node), &can::Frame::id);
  EXPECT_NEAR(static_cast<double>(answers), 300, 1);
}

TEST_F(Trouble, AForeignSenderIsHeardByTheHostAndByTheDrive) {
  add({.kind = Kind::foreign_sender});
  const std::vector<can::Frame> frames = sent_in(1);
  EXPECT_EQ(std::ranges::count(frames, can::rpdo1_id(node), &can::Frame::id), 1);
  EXPECT_EQ(rig.drive(0).record().applied.back().target, static_cast<std::int32_t>(rig.drive(0).position()));
}

TEST_F(Trouble, IsPutSomewhereByHand) {
  add({.kind = Kind::put_by_hand, .place = -7000});
  sent_in(1);
  EXPECT_NEAR(rig.drive(0).position(), -7000, 200) << "the drive is on and pulls";
}

TEST_F(Trouble, ADriveWithoutItsWatchdogsHasNoSuchObjectsAfterAResetEither) {
  add({.kind = Kind::no_watchdog});
  add({.kind = Kind::no_window});
  add({.kind = Kind::reboot});
  sent_in(2);
  const ObjectDictionary& objects = rig.drive(0).objects();
  EXPECT_EQ(objects.find({.index = 0x1016, .sub = 1}), nullptr);
  EXPECT_EQ(objects.find({.index = 0x1400, .sub = 5}), nullptr);
  EXPECT_EQ(objects.value(0x6065), std::numeric_limits<std::uint32_t>::max());
}

TEST_F(Trouble, ADriveWithOtherObjectsHasThemAfterAResetToo) {
  add({.kind = Kind::no_object, .object = {.index = 0x6007}});
  add({.kind = Kind::fixed_object, .value = -1, .object = {.index = 0x1016, .sub = 1}});
  add({.kind = Kind::silent_object, .object = {.index = 0x605A}});
  add({.kind = Kind::reboot});
  sent_in(2);
  const ObjectDictionary& objects = rig.drive(0).objects();
  EXPECT_EQ(objects.find({.index = 0x6007}), nullptr);
  EXPECT_EQ(objects.value(0x1016, 1), 0xFFFFFFFF);
  EXPECT_EQ(objects.refuses_length({.index = 0x1016, .sub = 1}, 4), can::abort_read_only);
  EXPECT_EQ(objects.find({.index = 0x605A})->access, ObjectDictionary::Access::silent);
}

TEST_F(Trouble, ATargetThatIsIgnoredLetsTheDriveComeToRestByItsRamp) {
  std::vector<std::int32_t> targets{rig.host_of(0).target(), rig.host_of(1).target()};
  const auto move = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) {
      for (std::int32_t& target : targets) target += 100;
      rig.tick(targets);
    }
  };
  move(100);
  const double speed = rig.drive(0).velocity();
  EXPECT_NEAR(speed, 25'000, 500);
  add({.kind = Kind::ignore_target});
  move(1);
  EXPECT_GT(rig.drive(0).velocity(), speed / 2) << "not at once";
  move(50);
  EXPECT_NEAR(rig.drive(0).velocity(), 0, 50);
  EXPECT_EQ(rig.drive(0).state(), can::Cia402State::operation_enabled);
}

}  // namespace simulated_trouble_test
}  // namespace inbetween
