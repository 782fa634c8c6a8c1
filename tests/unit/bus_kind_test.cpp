// What every protocol on a CAN bus must do, whatever its frames are (docs/new-drive.md).
#include "host_tools/rig/bus_kind.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "host_tools/text/diagnostics.hpp"
#include "tests/support/bus_axis.hpp"

namespace inbetween {
namespace bus_kind_test {

using can::DriveFinding;
using Trouble = DriveTrouble::Kind;

template <class Kind>
struct EveryProtocol : testing::Test {
  using Axis = BusAxis<Kind>;
  static void add(Axis& axis, Trouble kind, std::int32_t value = 0) {
    axis.drive->add_trouble({.kind = kind, .at_ns = axis.now_ns, .value = value});
  }
  /// On its way, a quarter of the swing behind it.
  static void begin(Axis& axis) {
    ASSERT_TRUE(axis.switch_on()) << words(axis);
    axis.from = axis.state.actual;
    for (int tick = 0; tick <= 125; ++tick) axis.tick(axis.swing(tick * 0.004));
    ASSERT_EQ(axis.worst, DriveCondition::fine) << words(axis);
    ASSERT_GT(std::fabs(axis.drive->velocity() / Kind::scale_of(axis.axis())), 10);
  }
  static std::string words(const Axis& axis) {
    const auto finding = axis.host().first_finding();
    return finding ? can::words_of(*finding).what : "";
  }
  /// It goes on along its path until something is wrong.
  static bool goes_on_until_it_is_found(Axis& axis, int most = 125) {
    for (int tick = 126; tick < 126 + most && axis.worst == DriveCondition::fine; ++tick) {
      axis.tick(axis.swing(tick * 0.004));
    }
    return axis.worst != DriveCondition::fine;
  }
};
using Kinds = testing::Types<Cia402Kind, InterpolatedKind, OdriveKind, MoteusKind, RmdKind, CubemarsKind>;
TYPED_TEST_SUITE(EveryProtocol, Kinds);

TYPED_TEST(EveryProtocol, SwitchesOnWithoutAnyMotionAndTellsWhereTheAxisIs) {
  BusAxis<TypeParam> axis;
  ASSERT_TRUE(axis.switch_on()) << this->words(axis);
  EXPECT_TRUE(axis.has_power());
  EXPECT_NEAR(axis.state.actual, 20, 0.001);
  EXPECT_NEAR(axis.truly(), 20, 0.001);
  EXPECT_FALSE(axis.drive->has_been_moved());
  for (const DriveRecord::Applied& applied : axis.drive->take_record().applied) {
    EXPECT_NEAR(applied.target / TypeParam::scale_of(axis.axis()), 20, 0.001);
  }
}

// docs/faults.md 49
TYPED_TEST(EveryProtocol, AnAxisOutsideItsLimitsStandsStillWhenItIsSwitchedOnAndComesIn) {
  for (const double stands : {-140.0, -90.7, 90.7, 140.0}) {
    SCOPED_TRACE(stands);
    BusAxis<TypeParam> axis(DriveInRig<TypeParam>::text(), "reference = \"drive\"", stands);
    ASSERT_TRUE(axis.switch_on()) << this->words(axis);
    const double from = axis.state.actual;
    axis.ticks(250, Setpoint{.position = from});
    EXPECT_NEAR(axis.truly(), stands, 0.001) << "it is held where it stands";
    EXPECT_FALSE(axis.drive->has_been_moved());
    // Inwards at 4 degrees a second.
    const double direction = stands < 0 ? 1 : -1;
    double before = axis.truly();
    for (int tick = 0; tick < 500 && axis.worst == DriveCondition::fine; ++tick) {
      const double speed = std::min(tick * 0.05, 4.0);
      axis.from += direction * speed * 0.004;
      axis.tick(Setpoint{.position = from + axis.from - BusAxis<TypeParam>::stands_at,
                         .velocity = direction * speed});
      EXPECT_GE(direction * (axis.truly() - before), -0.001);
      before = axis.truly();
    }
    EXPECT_EQ(axis.worst, DriveCondition::fine) << this->words(axis);
    EXPECT_NEAR(std::fabs(axis.truly() - stands), 7.4, 0.3);
  }
}

TYPED_TEST(EveryProtocol, HasPowerNeitherBeforeItIsRequestedNorWithoutAHost) {
  BusAxis<TypeParam> axis;
  axis.ticks(1000);
  EXPECT_FALSE(axis.has_power());
  EXPECT_FALSE(axis.state.is_on);
}

TYPED_TEST(EveryProtocol, TheDrivesOwnRecordIsThePlanWithinItsResolution) {
  BusAxis<TypeParam> axis;
  ASSERT_TRUE(axis.switch_on());
  axis.from = axis.state.actual;
  axis.drive->take_record();
  const int ticks = 500;
  for (int tick = 0; tick <= ticks; ++tick) axis.tick(axis.swing(tick * 0.004));
  axis.ticks(10, axis.swing(axis.swing_s));
  EXPECT_EQ(axis.worst, DriveCondition::fine) << this->words(axis);
  const std::vector<DriveRecord::Applied> applied = axis.drive->take_record().applied;
  ASSERT_GT(applied.size(), 500U);
  // It holds its place first: aligned by where both have gone a tenth of a degree.
  constexpr double far = 0.1;
  const double scale = TypeParam::scale_of(axis.axis());
  std::size_t first = 0;
  while (std::fabs(applied[first].target - applied.front().target) < far * std::fabs(scale)) ++first;
  std::size_t first_planned = 0;
  while (axis.swing(static_cast<double>(first_planned) * 0.004).position - axis.from < far) ++first_planned;
  ASSERT_GE(first, first_planned);
  for (std::size_t k = 0; k < 500; ++k) {
    ASSERT_NEAR(applied.at(first - first_planned + k).target / scale,
                axis.swing(static_cast<double>(k) * 0.004).position, DriveInRig<TypeParam>::resolution + 1e-9)
        << "tick " << k;
  }
  EXPECT_NEAR(axis.truly(), axis.from, 0.05);
}

// docs/faults.md 16, 29
TYPED_TEST(EveryProtocol, WhenSetpointsCeaseTheDriveStopsByItself) {
  BusAxis<TypeParam> axis;
  this->begin(axis);
  axis.ticks(250);
  EXPECT_NEAR(axis.drive->velocity(), 0, 0.01);
  EXPECT_EQ(axis.has_power(), !DriveInRig<TypeParam>::stops_alone);
  const double rest = axis.truly();
  axis.ticks(500);
  EXPECT_EQ(axis.has_power(), !DriveInRig<TypeParam>::stops_alone) << "and nothing resumes";
  EXPECT_NEAR(axis.truly(), rest, 0.01);
}

TYPED_TEST(EveryProtocol, AHostThatDiesIsNoticed) {
  BusAxis<TypeParam> axis;
  this->begin(axis);
  for (int i = 0; i < 1000; ++i) static_cast<void>(axis.wire.run(axis.now_ns += 1'000'000));
  EXPECT_NEAR(axis.drive->velocity(), 0, 0.01);
  EXPECT_EQ(axis.has_power(), !DriveInRig<TypeParam>::stops_alone);
}

// docs/faults.md 29
TYPED_TEST(EveryProtocol, ADriveThatWouldRunOnAloneIsNotSwitchedOn) {
  if (!DriveInRig<TypeParam>::stops_alone) return;  // its rig has accepted that, or is refused by the reader
  BusAxis<TypeParam> axis;
  this->add(axis, Trouble::no_watchdog);
  EXPECT_FALSE(axis.switch_on());
  EXPECT_NE(axis.worst, DriveCondition::fine);
  EXPECT_FALSE(axis.has_power());
}

// docs/faults.md 22
TYPED_TEST(EveryProtocol, ADriveThatIsNotHeardIsNotSwitchedOn) {
  BusAxis<TypeParam> axis;
  this->add(axis, Trouble::lose_sent);
  EXPECT_FALSE(axis.switch_on());
  EXPECT_NE(axis.worst, DriveCondition::fine);
  EXPECT_FALSE(axis.has_power());
}

// docs/faults.md 17, 20, 21, 23, 24, 25
TYPED_TEST(EveryProtocol, WhatIsWrongInMotionIsFoundWhileTheDriveIsStillTold) {
  for (const Trouble kind : {Trouble::foreign_sender, Trouble::lose_sent, Trouble::lose_feedback,
                             Trouble::lose_heartbeat, Trouble::emergency, Trouble::reboot, Trouble::stick}) {
    SCOPED_TRACE(static_cast<int>(kind));
    BusAxis<TypeParam> axis;
    this->begin(axis);
    this->add(axis, kind, 0x2310);
    ASSERT_TRUE(this->goes_on_until_it_is_found(axis));
    EXPECT_EQ(axis.worst, DriveCondition::cannot_follow) << this->words(axis);
    if (kind == Trouble::lose_feedback) {
      EXPECT_EQ(axis.host().first_finding(), DriveFinding::feedback_missing) << this->words(axis);
    }
    axis.ticks(100, axis.swing(1));
    EXPECT_EQ(can::loses_reference(axis.host().findings()), kind == Trouble::reboot);
  }
}

// docs/faults.md 19
TYPED_TEST(EveryProtocol, AFewShortFramesAreCountedAndManyAreAFinding) {
  BusAxis<TypeParam> axis;
  this->begin(axis);
  axis.drive->add_trouble({.kind = Trouble::shorten, .at_ns = axis.now_ns, .frames = 2});
  EXPECT_FALSE(this->goes_on_until_it_is_found(axis, 50));
  EXPECT_EQ(axis.host().counters().bad_frames, 2U);
  BusAxis<TypeParam> other;
  this->begin(other);
  this->add(other, Trouble::shorten);
  EXPECT_TRUE(this->goes_on_until_it_is_found(other));
}

// docs/faults.md 18
TYPED_TEST(EveryProtocol, AFloodIsBoundedAndCounted) {
  BusAxis<TypeParam> axis;
  this->begin(axis);
  this->add(axis, Trouble::flood, 20'000);
  EXPECT_FALSE(this->goes_on_until_it_is_found(axis, 2)) << "a few ticks of it are survived";
  EXPECT_GT(axis.port->counters(0).floods, 0U);
}

TYPED_TEST(EveryProtocol, ASetpointThatJumpsIsNotSent) {
  BusAxis<TypeParam> axis;
  this->begin(axis);
  axis.drive->take_record();
  Setpoint far = axis.swing(0.504);
  far.position += 5;
  axis.ticks(3, far);
  EXPECT_TRUE(axis.host().findings().has(DriveFinding::setpoint_jump));
  for (const DriveRecord::Applied& applied : axis.drive->take_record().applied) {
    EXPECT_LT(applied.target / TypeParam::scale_of(axis.axis()), far.position - 4);
  }
}

TYPED_TEST(EveryProtocol, AFirstSetpointThatIsNotWhereTheAxisIsIsNotSent) {
  BusAxis<TypeParam> axis;
  ASSERT_TRUE(axis.switch_on());
  axis.ticks(20, Setpoint{.position = axis.state.actual + 0.1});
  EXPECT_TRUE(axis.host().findings().has(DriveFinding::moved_while_enabling));
  EXPECT_NEAR(axis.truly(), 20, 0.001);
}

TYPED_TEST(EveryProtocol, AQuickStopBringsItToRestAndNothingResumes) {
  BusAxis<TypeParam> axis;
  this->begin(axis);
  axis.port->quick_stop();
  axis.ticks(250, axis.swing(0.504));
  EXPECT_NEAR(axis.drive->velocity(), 0, 0.01);
  const double rest = axis.truly();
  for (int tick = 126; tick < 250; ++tick) axis.tick(axis.swing(tick * 0.004));
  EXPECT_NEAR(axis.truly(), rest, 0.01);
}

TYPED_TEST(EveryProtocol, IsSwitchedOffAndLetGo) {
  BusAxis<TypeParam> axis;
  this->begin(axis);
  for (int tick = 126; tick <= 500; ++tick) axis.tick(axis.swing(tick * 0.004));
  axis.ticks(20, axis.swing(axis.swing_s));
  axis.port->disable();
  axis.tick();
  axis.tick();
  ASSERT_TRUE(axis.tick_until([&] { return !axis.state.is_leaving; }));
  EXPECT_EQ(axis.host().phase(), can::DrivePhase::off);
  EXPECT_FALSE(axis.has_power());
  EXPECT_FALSE(axis.drive->misses_something());
  axis.ticks(500);
  EXPECT_TRUE(axis.drive->take_record().reported.empty()) << "nobody is missed";
}

TYPED_TEST(EveryProtocol, ADriveThatDoesNotSwitchOffIsSaid) {
  BusAxis<TypeParam> axis;
  ASSERT_TRUE(axis.switch_on());
  this->add(axis, Trouble::stay_on);
  axis.port->disable();
  axis.tick();
  axis.tick();
  ASSERT_TRUE(axis.tick_until([&] { return !axis.state.is_leaving; }));
  EXPECT_TRUE(axis.host().findings().has(DriveFinding::not_switched_off));
  axis.ticks(500);
  // It is told nothing any more, and its watchdog switches it off, if it has one.
  EXPECT_EQ(axis.has_power(), !DriveInRig<TypeParam>::stops_alone);
}

// docs/faults.md 24, 48. A drive that tells nothing of its restart tells another place.
TYPED_TEST(EveryProtocol, ARestartWhileItIsIdleMovesNothingAndIsSeen) {
  BusAxis<TypeParam> axis;
  axis.port->let_switch_on(false);
  axis.port->enable();
  ASSERT_TRUE(axis.tick_until([&] { return axis.host().phase() == can::DrivePhase::idle; }))
      << this->words(axis);
  const double told = axis.state.actual;
  this->add(axis, Trouble::reboot);
  axis.ticks(1500);
  axis.port->let_switch_on(true);
  axis.ticks(1500);
  EXPECT_NEAR(axis.truly(), 20, 0.001);
  EXPECT_FALSE(axis.drive->has_been_moved());
  const bool tells_another = std::fabs(axis.state.actual - told) > 1;
  EXPECT_TRUE(axis.port->has_forgotten(0) || tells_another || !axis.state.is_on) << this->words(axis);
}

// docs/faults.md 23
TYPED_TEST(EveryProtocol, AFaultFromBeforeItWasSetUpIsToldByItsCode) {
  BusAxis<TypeParam> axis;
  this->add(axis, Trouble::emergency, DriveInRig<TypeParam>::fault);
  axis.ticks(250);
  EXPECT_FALSE(axis.switch_on());
  ASSERT_TRUE(axis.host().first_finding());
  EXPECT_THAT(TypeParam::detail_of(axis.host(), *axis.host().first_finding()),
              testing::HasSubstr(DriveInRig<TypeParam>::fault_words))
      << this->words(axis);
  EXPECT_FALSE(axis.has_power());
  EXPECT_FALSE(axis.drive->has_been_moved());
}

// docs/faults.md 50
TEST(Cia402OnABus, TwoDevicesWithOneNumberAreFoundBeforeEitherHasPower) {
  BusAxis<Cia402Kind> axis;
  const auto second = Cia402Kind::simulate(axis.axis(), {.position = -40, .keeps_record = true});
  axis.wire.attach(*second);
  EXPECT_FALSE(axis.switch_on());
  EXPECT_EQ(axis.host().first_finding(), DriveFinding::two_devices);
  axis.ticks(500);
  EXPECT_FALSE(axis.has_power());
  EXPECT_NE(second->state_name(), std::string("operation enabled"));
  EXPECT_FALSE(axis.drive->has_been_moved() || second->has_been_moved());
}

// docs/faults.md 28
TYPED_TEST(EveryProtocol, AfterAStopItIsSwitchedOnWhereItIsThen) {
  BusAxis<TypeParam> axis;
  this->begin(axis);
  axis.ticks(250);
  if (axis.has_power()) {
    axis.port->disable();
    axis.ticks(250);
  }
  const double place = -30 * TypeParam::scale_of(axis.axis());
  axis.drive->add_trouble({.kind = Trouble::put_by_hand, .at_ns = axis.now_ns, .place = place});
  axis.ticks(10);
  axis.worst = DriveCondition::fine;
  ASSERT_TRUE(axis.switch_on()) << this->words(axis);
  EXPECT_NEAR(axis.state.actual, -30, 0.01);
  EXPECT_NEAR(axis.truly(), -30, 0.01);
}

TYPED_TEST(EveryProtocol, AnAxisThatIsToldWhereItStandsGoesOnFromThere) {
  BusAxis<TypeParam> axis;
  axis.axes[0].stands_at = 3;
  ASSERT_TRUE(axis.switch_on());
  EXPECT_NEAR(axis.state.actual, 3, 1e-6);
  axis.from = axis.state.actual;
  for (int tick = 0; tick <= 250; ++tick) axis.tick(axis.swing(tick * 0.004));
  EXPECT_EQ(axis.worst, DriveCondition::fine);
  axis.ticks(50, Setpoint{.position = axis.swing(1).position});
  EXPECT_NEAR(axis.state.actual, 13, 0.05);
  EXPECT_NEAR(axis.truly(), 30, 0.05);
}

// --- what a drive without SYNC does in its own way

// docs/faults.md 19
TEST(OdriveOnABus, TheNinthBadFrameAmongGoodOnesIsAFinding) {
  BusAxis<OdriveKind> axis;
  ASSERT_TRUE(axis.switch_on());
  const can::OdriveNode node = *can::OdriveNode::make(3);
  can::Frame shortened = can::odrive_estimates_frame(node, -5, 0);
  shortened.length = 7;
  // One is forgiven in every 250 ticks: not while these come.
  while (axis.now_ns / BusAxis<OdriveKind>::tick_ns % 250 != 0) axis.tick();
  for (int i = 1; i <= 9; ++i) {
    EXPECT_FALSE(axis.host().first_finding()) << "after " << i - 1;
    axis.wire.inject(shortened);
    axis.ticks(2);
  }
  EXPECT_EQ(axis.host().first_finding(), DriveFinding::bad_frames);
}

TEST(OdriveOnABus, AfterAQuickStopItIsHeldWhereItWasToldToBeLast) {
  BusAxis<OdriveKind> axis;
  EveryProtocol<OdriveKind>::begin(axis);
  axis.port->quick_stop();
  axis.tick();
  axis.drive->take_record();
  axis.ticks(250);
  EXPECT_TRUE(axis.has_power());
  const std::vector<DriveRecord::Applied> applied = axis.drive->take_record().applied;
  ASSERT_GT(applied.size(), 200U);
  for (const DriveRecord::Applied& held : applied) ASSERT_EQ(held.target, applied.front().target);
  EXPECT_NEAR(axis.truly(), applied.front().target / OdriveKind::scale_of(axis.axis()), 0.001);
}

// --- several protocols on a bus

TEST(TwoProtocols, WithAnIdentifierInCommonOnABusAreRefused) {
  const auto rig = [](int node, const std::string& bus) {
    return parse_rig(
        rig_text({{.name = "pan", .max_velocity = 10, .drive = cia402_text(3)},
                  {.name = "tilt",
                   .max_velocity = 10,
                   .drive = "type = \"odrive\", bus = \"" + bus + "\", node = " + std::to_string(node) +
                            ", turns_per_unit = 0.1, firmware = \"0.5\""}},
                 {.rate_hz = 250, .more = bus_can0 + std::string("[bus.can1]\nbitrate = 1000000\n")}),
        "rig.toml");
  };
  for (const int node : {0, 4, 12, 16, 44, 48, 56, 59}) {
    EXPECT_THAT([&] { refuse_overloaded_buses(rig(node, "can0")); },
                testing::ThrowsMessage<InputError>(
                    testing::HasSubstr("axis \"tilt\": its drive and that of axis \"pan\" would both use")))
        << node;
    EXPECT_NO_THROW(refuse_overloaded_buses(rig(node, "can1"))) << node;
  }
  for (const int node : {1, 2, 8, 11, 20, 43, 52, 55, 60, 62})
    EXPECT_NO_THROW(refuse_overloaded_buses(rig(node, "can0")));
}

}  // namespace bus_kind_test
}  // namespace inbetween
