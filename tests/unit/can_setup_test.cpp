// How a drive is told to brake, and what is refused because it would not.
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <vector>

#include "inbetween/can/cia402_setup.hpp"
#include "tests/support/drive_objects.hpp"

namespace inbetween::can {
namespace can_setup_test {

class BrakesOfNode5 : public testing::Test {
 protected:
  Cia402Setup setup{.node = NodeId::make(5).value(), .host = NodeId::make(127).value()};
  DriveObjects objects;
  SetupRunner runner{NodeId::make(5).value(), 500'000'000};

  void work() { objects.work_off(runner, script_of(setup)); }
  void expect_done() {
    work();
    EXPECT_EQ(runner.state(), SetupState::done) << words_of(runner.refusal().finding).what << ", object "
                                                << std::hex << runner.refusal().object.index;
  }
  void expect_refused(DriveFinding finding, int index, std::optional<std::uint32_t> found) {
    work();
    ASSERT_EQ(runner.state(), SetupState::refused);
    EXPECT_EQ(runner.refusal().finding, finding) << words_of(runner.refusal().finding).what;
    EXPECT_EQ(runner.refusal().object.index, index) << std::hex << runner.refusal().object.index;
    EXPECT_EQ(runner.refusal().found, found);
    EXPECT_EQ(words_of(finding).reaction, DriveReaction::refuse);
  }
  /// A drive that has `value` in `index` and cannot be told another.
  void fix(int index, int size, std::uint32_t value) {
    objects = DriveObjects();
    objects.set(index, 0, size, value);
    objects.refuse(index, 0, abort_read_only);
  }
};

const std::vector<int> option_codes{0x605A, 0x605B, 0x605C, 0x605D, 0x605E};

TEST_F(BrakesOfNode5, EveryWayOutOfOperationIsARamp) {
  for (const int index : option_codes) objects.set(index, 0, 2, 0);
  expect_done();
  EXPECT_EQ(objects.value(0x605A, 0), 2U);
  EXPECT_EQ(objects.value(0x605B, 0), 1U);
  EXPECT_EQ(objects.value(0x605C, 0), 1U);
  EXPECT_EQ(objects.value(0x605D, 0), 2U);
  EXPECT_EQ(objects.value(0x605E, 0), 2U);
}

TEST_F(BrakesOfNode5, ADriveThatWouldCoastIsRefusedUnlessItsAxisMay) {
  for (const int index : option_codes) {
    fix(index, 2, 0);
    setup.coasts = false;
    expect_refused(DriveFinding::would_coast, index, 0);
    EXPECT_STREQ(
        words_of(DriveFinding::would_coast).what,
        "the drive would switch its motor off at once where it must brake, and the axis would coast");
    EXPECT_EQ(runner.refusal().abort_code, abort_read_only);
    objects = DriveObjects();
    objects.set(index, 0, 2, 0);
    objects.freeze(index, 0);
    expect_refused(DriveFinding::would_coast, index, 0);
    EXPECT_EQ(runner.refusal().abort_code, 0U) << "it has said yes, and kept what it has";
    setup.coasts = true;
    expect_done();
  }
}

TEST_F(BrakesOfNode5, ADriveThatHasAnotherRampIsTaken) {
  const std::vector<std::pair<int, std::uint32_t>> ramps{{0x605A, 1}, {0x605A, 8}, {0x605D, 1},
                                                         {0x605D, 4}, {0x605E, 1}, {0x605E, 4}};
  for (const auto& [index, code] : ramps) {
    fix(index, 2, code);
    expect_done();
  }
}

TEST_F(BrakesOfNode5, ACodeThatTheProfileDoesNotKnowIsNoRamp) {
  for (const int index : option_codes) {
    for (const std::uint32_t code : {9U, 40U, 0xFFFFU}) {
      fix(index, 2, code);
      expect_refused(DriveFinding::would_coast, index, code);
    }
  }
}

TEST_F(BrakesOfNode5, ADriveNeedNotHaveTheseObjects) {
  for (const int index : option_codes) objects.remove(index, 0);
  objects.remove(0x6085, 0);
  setup.quick_stop_deceleration = 1200;
  expect_done();
}

TEST_F(BrakesOfNode5, TheDriveBrakesByItsQuickStopWhenTheHostIsLost) {
  objects.set(0x6007, 0, 2, 0);
  expect_done();
  EXPECT_EQ(objects.value(0x6007, 0), 3U);
}

TEST_F(BrakesOfNode5, AFaultWhenTheHostIsLostIsEnoughIfItIsKnownToBrake) {
  fix(0x6007, 2, 1);
  expect_done();
  objects.remove(0x605E, 0);
  expect_refused(DriveFinding::host_loss_unbraked, 0x6007, 1);
  setup.coasts = true;
  expect_done();
}

TEST_F(BrakesOfNode5, ADriveThatGoesOnWithoutItsHostIsAlwaysRefused) {
  for (const bool coasts : {false, true}) {
    setup.coasts = coasts;
    setup.stops_without_host = coasts;
    fix(0x6007, 2, 0);
    expect_refused(DriveFinding::host_loss_unbraked, 0x6007, 0);
    EXPECT_STREQ(words_of(DriveFinding::host_loss_unbraked).what,
                 "the drive would not brake if this program died");
    fix(0x6007, 2, 0xFFFF);
    expect_refused(DriveFinding::host_loss_unbraked, 0x6007, 0xFFFF);
  }
}

TEST_F(BrakesOfNode5, ADriveThatTakesItsPowerAwayWithoutItsHostMustBeAllowedTo) {
  fix(0x6007, 2, 2);
  expect_refused(DriveFinding::host_loss_unbraked, 0x6007, 2);
  setup.coasts = true;
  expect_done();
}

TEST_F(BrakesOfNode5, OfADriveThatDoesNotSayWhatItDoesWithoutItsHostSomebodyElseMust) {
  objects.remove(0x6007, 0);
  expect_refused(DriveFinding::host_loss_unsaid, 0x6007, std::nullopt);
  setup.stops_without_host = true;
  expect_done();
}

TEST_F(BrakesOfNode5, TheDecelerationOfAQuickStopIsWrittenOrCompared) {
  setup.quick_stop_deceleration = 1'200'000;
  expect_done();
  EXPECT_EQ(objects.value(0x6085, 0), 1'200'000U);
  for (const std::uint32_t rounded : {1'176'000U, 1'224'000U}) {
    fix(0x6085, 4, rounded);
    expect_done();
  }
  for (const std::uint32_t other : {0U, 1'175'999U, 1'224'001U, 0xFFFFFFFFU}) {
    fix(0x6085, 4, other);
    expect_refused(DriveFinding::stop_differs, 0x6085, other);
    EXPECT_STREQ(words_of(DriveFinding::stop_differs).what,
                 "the drive brakes by another deceleration than the axis has in the rig");
    EXPECT_EQ(runner.refusal().expected, 1'200'000U);
  }
  setup.quick_stop_deceleration = 0xFFFFFFFF;
  fix(0x6085, 4, 0);
  expect_refused(DriveFinding::stop_differs, 0x6085, 0);
}

TEST_F(BrakesOfNode5, ATimeoutOfSetpointsIsNoHeartbeatConsumerWhereThereIsOne) {
  objects.freeze(0x1016, 1);
  expect_refused(DriveFinding::watchdog_unset, 0x1016, 0);
  objects = DriveObjects();
  objects.refuse(0x1016, 1, abort_device_state);
  expect_refused(DriveFinding::watchdog_unset, 0x1016, 0);
  EXPECT_EQ(runner.refusal().abort_code, abort_device_state);
  objects = DriveObjects();
  objects.remove(0x1016, 1);
  expect_done();
  objects.remove(0x1400, 5);
  expect_refused(DriveFinding::watchdog_unset, 0x1016, std::nullopt);
}

TEST_F(BrakesOfNode5, ThePeriodOfSyncIsTheTickOrNotWatched) {
  fix(0x1006, 4, 0);
  expect_done();
  fix(0x1006, 4, 4000);
  expect_done();
  fix(0x1006, 4, 4001);
  expect_refused(DriveFinding::sdo_failed, 0x1006, 4001);
  EXPECT_EQ(runner.refusal().expected, 0U) << "it watches the host's heartbeat";
  objects.remove(0x1016, 1);
  expect_refused(DriveFinding::sdo_failed, 0x1006, 4001);
  EXPECT_EQ(runner.refusal().expected, 4000U);
}

TEST_F(BrakesOfNode5, WhatADriveHasAlreadyNeedNotBeWritable) {
  objects.set(0x1029, 1, 1, 0);
  objects.refuse(0x1029, 1, abort_read_only);
  objects.set(0x60C2, 1, 1, 4);
  objects.refuse(0x60C2, 1, abort_unsupported_access);
  expect_done();
}

TEST_F(BrakesOfNode5, ARefusalHasItsReasonAndWhatTheDriveHas) {
  objects.refuse(0x1029, 1, abort_device_state);
  expect_refused(DriveFinding::sdo_failed, 0x1029, 1);
  EXPECT_EQ(runner.refusal().expected, 0U);
  EXPECT_EQ(runner.refusal().abort_code, abort_device_state);
}

TEST_F(BrakesOfNode5, WhatWasFoundIsNeverTheValueOfAnEarlierAnswer) {
  objects.remove(0x6060, 0);
  expect_refused(DriveFinding::sdo_failed, 0x6060, std::nullopt);
  EXPECT_EQ(runner.refusal().abort_code, abort_no_object);
  objects = DriveObjects();
  objects.remove(0x1000, 0);
  expect_refused(DriveFinding::sdo_failed, 0x1000, std::nullopt);
}

TEST_F(BrakesOfNode5, SilenceIsATimeoutAndNoRefusal) {
  objects.silence(0x605C, 0);
  expect_refused(DriveFinding::sdo_silent, 0x605C, std::nullopt);
  EXPECT_EQ(runner.refusal().abort_code, abort_timeout);
}

}  // namespace can_setup_test
}  // namespace inbetween::can
