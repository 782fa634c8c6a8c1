// An axis that does not go where it is told: stuck, running away, or by another scale (docs/faults.md 25, 52,
// 53).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>

#include "host_tools/cli/measured_scale.hpp"
#include "inbetween/loop/axis_watch.hpp"
#include "tests/support/bus_axis.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace runaway_test {

using can::DriveFinding;
using Trouble = DriveTrouble::Kind;

// --- the watch alone

constexpr WatchBounds bounds{.min = -100,
                             .max = 100,
                             .max_velocity = 50,
                             .stop_acceleration = 100,
                             .max_following_error = 5,
                             .in_position = 0.5,
                             .rest = 0.1};
constexpr std::int64_t tick_ns = 4'000'000;

struct Watched {
  AxisWatch watch{bounds};
  std::int64_t now_ns = 0;
  double place = 0;
  /// At this speed for so many ticks.
  void go(double speed, int ticks) {
    for (int i = 0; i < ticks; ++i) {
      watch.look(place, now_ns);
      now_ns += tick_ns;
      place += speed * 0.004;
    }
    watch.look(place, now_ns);
  }
};

TEST(AxisWatch, HasArrivedWhereItWasToldToBeOrIsToldNothing) {
  Watched axis;
  axis.go(0, 1);
  EXPECT_TRUE(axis.watch.is_in_position());
  axis.watch.tell(0.5);
  EXPECT_TRUE(axis.watch.is_in_position());
  axis.watch.tell(-0.51);
  EXPECT_FALSE(axis.watch.is_in_position());
  axis.watch.tell_nothing();
  EXPECT_TRUE(axis.watch.is_in_position());
}

TEST(AxisWatch, WhatBrakesInTimeDoesNotGetAwayAndWhatGoesFurtherDoes) {
  for (const double direction : {-1.0, 1.0}) {
    Watched axis;
    axis.go(direction * 40, 20);
    axis.watch.tell(axis.place - direction * 6);  // it is beyond its target
    axis.watch.begin_stop();
    // 40^2 / (2 * 100) is the distance in which it may brake, and 5 its following error.
    const double from = axis.place;
    const auto at = [&](double distance) {
      axis.place = from + direction * distance;
      axis.watch.look(axis.place, axis.now_ns += tick_ns);
      return axis.watch.gets_away();
    };
    EXPECT_FALSE(at(12.9));
    EXPECT_TRUE(at(13.1));
    EXPECT_FALSE(at(-12)) << "towards its target";
  }
}

TEST(AxisWatch, AFasterRunawayIsGivenNoMoreRoomThanItsAxisNeeds) {
  Watched axis;
  axis.go(720, 20);
  axis.watch.tell(axis.place);
  axis.watch.begin_stop();
  axis.go(720, 6);
  EXPECT_FALSE(axis.watch.gets_away()) << "17.28: 50^2 / 200 + 5 are 17.5";
  axis.go(720, 1);
  EXPECT_TRUE(axis.watch.gets_away());
}

TEST(AxisWatch, WhatStandsStillWhileItsPathGoesOnDoesNotGetAway) {
  Watched axis;
  axis.go(0, 20);
  axis.watch.tell(5.1);
  axis.watch.begin_stop();
  for (int i = 0; i < 100; ++i) {
    axis.watch.tell(5.1 + i);
    axis.go(0, 1);
    EXPECT_FALSE(axis.watch.gets_away());
  }
}

TEST(AxisWatch, WhatLeavesItsRangeGetsAwayAndWhatStandsOutsideDoesNot) {
  Watched axis;
  axis.place = 99;
  axis.go(0, 20);
  axis.watch.tell(99);
  axis.watch.begin_stop();
  axis.place = 100.4;
  axis.go(0, 1);
  EXPECT_FALSE(axis.watch.gets_away());
  axis.place = 100.6;
  axis.go(0, 1);
  EXPECT_TRUE(axis.watch.gets_away());
  Watched outside;
  outside.place = -120;
  outside.go(0, 20);
  outside.watch.tell(-114);
  outside.watch.begin_stop();
  EXPECT_FALSE(outside.watch.gets_away());
  outside.place = -120.6;
  outside.go(0, 1);
  EXPECT_TRUE(outside.watch.gets_away());
}

TEST(AxisWatch, TheNoiseOfAnEncoderIsNoSpeed) {
  Watched axis;
  for (int i = 0; i < 100; ++i) {
    axis.place = i % 2 == 0 ? 0.2 : 0;
    axis.watch.look(axis.place, axis.now_ns += tick_ns);
    if (i < 20) continue;  // it has not seen 25 ms twice
    EXPECT_LE(axis.watch.speed(), 0.2 / 0.025) << "over 25 ms at least, and not from tick to tick";
  }
}

TEST(AxisWatch, ItsSpeedIsThatOfTheLastFiftyMillisecondsAndAStandIsSeenAtOnce) {
  Watched axis;
  axis.go(30, 40);
  EXPECT_NEAR(axis.watch.speed(), 30, 1e-6);
  EXPECT_TRUE(axis.watch.moves());
  axis.go(0, 5);
  EXPECT_FALSE(axis.watch.moves());
  axis.go(0, 20);
  EXPECT_EQ(axis.watch.speed(), 0);
  axis.go(1.9, 40);
  EXPECT_FALSE(axis.watch.moves()) << "less than it may at rest";
}

// --- with every drive

template <class Kind>
struct RunawayOnABus : testing::Test {
  using Axis = BusAxis<Kind>;
  static double scale(const Axis& axis) { return Kind::scale_of(axis.axis()); }
  static void add(Axis& axis, DriveTrouble trouble) {
    trouble.at_ns = axis.now_ns;
    axis.drive->add_trouble(trouble);
  }
  static bool lacks_power(const Axis& axis) {
    const std::string state = axis.drive->state_name();
    const bool is_stopped_moteus = std::is_same_v<Kind, MoteusKind> && state == "stopped";
    return is_stopped_moteus || state == "off" || state == "idle" || state == "fault" ||
           state == "switch-on disabled";
  }
  static void stop_watching_yourself(Axis& axis) { add(axis, {.kind = Trouble::blind}); }
  static void begin(Axis& axis) {
    ASSERT_TRUE(axis.switch_on());
    axis.from = axis.state.actual;
    for (int tick = 0; tick <= 125; ++tick) axis.tick(axis.swing(tick * 0.004));
    ASSERT_EQ(axis.worst, DriveCondition::fine);
  }
  /// Further along its path, and at rest at its end.
  static void go_on(Axis& axis, int tick) {
    axis.tick(axis.swing(std::min(tick * 0.004, BusAxis<Kind>::swing_s)));
  }
};
using Kinds = testing::Types<Cia402Kind, InterpolatedKind, OdriveKind, MoteusKind, RmdKind, CubemarsKind>;
TYPED_TEST_SUITE(RunawayOnABus, Kinds);

// docs/faults.md 52
TYPED_TEST(RunawayOnABus, LosesItsPowerWithinTheDistanceThatWasPromised) {
  for (const double speed : {60.0, 200.0, 720.0, -60.0, -200.0, -720.0}) {
    SCOPED_TRACE(speed);
    BusAxis<TypeParam> axis;
    this->begin(axis);
    this->stop_watching_yourself(axis);
    this->add(axis, {.kind = Trouble::run_away, .place = speed * this->scale(axis)});
    int tick = 126;
    while (axis.state.own_stop == OwnStop::none && axis.worst == DriveCondition::fine && tick < 1000) {
      this->go_on(axis, tick++);
    }
    const double found = axis.truly();
    const double target = axis.swing(tick * 0.004).position;
    while (!this->lacks_power(axis) && tick < 3000) this->go_on(axis, tick++);
    ASSERT_TRUE(this->lacks_power(axis));
    // 40^2 / (2 * 600), a following error of 4, and what it runs in the eight ticks until it is told.
    const double promised = 40 * 40 / 1200.0 + 4;
    const double heard =
        0.032 * std::max(std::fabs(speed), std::fabs(axis.drive->velocity() / this->scale(axis)));
    EXPECT_LE(std::fabs(axis.truly() - target) - std::fabs(found - target), promised + heard);
    EXPECT_NE(axis.worst, DriveCondition::unreachable) << "the others go on";
    std::printf("%-28s %5.0f deg/s: %.1f deg from its target when found, %.1f when its power went\n",
                testing::UnitTest::GetInstance()->current_test_info()->type_param(), speed,
                std::fabs(found - target), std::fabs(axis.truly() - target));
  }
}

// docs/faults.md 25
TYPED_TEST(RunawayOnABus, AJammedAxisKeepsItsPowerWhileItsPathGoesOn) {
  BusAxis<TypeParam> axis;
  this->begin(axis);
  this->stop_watching_yourself(axis);
  this->add(axis, {.kind = Trouble::stick});
  double largest = 0;
  for (int tick = 126; tick < 500; ++tick) {
    this->go_on(axis, tick);
    largest = std::max(largest, std::fabs(axis.state.actual - axis.swing(tick * 0.004).position));
  }
  EXPECT_EQ(axis.worst, DriveCondition::cannot_follow);
  EXPECT_TRUE(axis.host().findings().has(DriveFinding::following_error));
  EXPECT_EQ(axis.state.own_stop, OwnStop::stopped);
  EXPECT_FALSE(axis.port->speed_without_power(0));
  EXPECT_GT(largest, 4.1);
}

// docs/faults.md 25, case 60
TYPED_TEST(RunawayOnABus, OneThatStandsShortOfItsTargetIsNotInPosition) {
  BusAxis<TypeParam> axis;
  this->begin(axis);
  this->stop_watching_yourself(axis);
  int tick = 126;
  // Within the following error of the end, and not there.
  while (axis.swing(tick * 0.004).position - axis.from > 1.5 || tick < 250) this->go_on(axis, tick++);
  this->add(axis, {.kind = Trouble::stick});
  for (; tick < 760; ++tick) this->go_on(axis, tick);
  EXPECT_EQ(axis.worst, DriveCondition::fine);
  EXPECT_FALSE(axis.state.is_in_position)
      << axis.truly() << " of " << axis.from << " " << axis.axes[0].watch.has_value()
      << axis.axes[0].watch->is_in_position();
  BusAxis<TypeParam> well;
  this->begin(well);
  for (int k = 126; k < 510; ++k) this->go_on(well, k);
  EXPECT_TRUE(well.state.is_in_position);
}

// docs/faults.md 54. A drive of CiA 402 brakes by a ramp of its own (605C), which the simulated one does not
// have.
TYPED_TEST(RunawayOnABus, SwitchedOffInMotionItsPowerGoesAtRestOrItsSpeedIsSaid) {
  BusAxis<TypeParam> axis;
  this->begin(axis);
  const bool is_cia402 = std::is_base_of_v<Cia402Kind, TypeParam>;
  axis.port->disable();
  double speed = 0;
  int most = 2000;
  for (; !this->lacks_power(axis) && most > 0; --most) {
    axis.tick();
    speed = std::fabs(axis.drive->velocity() / this->scale(axis));
  }
  ASSERT_GT(most, 0);
  ASSERT_TRUE(axis.tick_until([&] { return !axis.state.is_leaving; }));
  EXPECT_EQ(axis.port->speed_without_power(0).has_value(), is_cia402);
  EXPECT_LT(is_cia402 ? 0 : speed, 0.5);
}

// docs/faults.md 54
TYPED_TEST(RunawayOnABus, WhatStillMovesWhenItsPowerGoesIsSaidWithItsSpeed) {
  BusAxis<TypeParam> axis;
  this->begin(axis);
  this->stop_watching_yourself(axis);
  this->add(axis, {.kind = Trouble::run_away, .place = 60 * this->scale(axis)});
  for (int tick = 126; tick < 800; ++tick) this->go_on(axis, tick);
  ASSERT_TRUE(axis.port->speed_without_power(0));
  EXPECT_NEAR(*axis.port->speed_without_power(0), 60, 15);
}

/// The same drive with a degree of its shaft, or ten counts, for a degree of the axis.
template <class Kind>
std::string coarse() {
  std::string text = DriveInRig<Kind>::text();
  const std::string scale =
      std::is_base_of_v<Cia402Kind, Kind> ? "counts_per_unit = 1000" : "turns_per_unit = ";
  const std::size_t at = text.find(scale);
  const std::size_t end = std::min(text.find(',', at), text.size());
  return text.replace(
      at, end - at,
      std::is_base_of_v<Cia402Kind, Kind> ? "counts_per_unit = 10" : "turns_per_unit = 0.0027777778");
}

TYPED_TEST(RunawayOnABus, NoMoveWithinItsLimitsIsTakenForOne) {
  std::mt19937 random(7);
  const auto between = [&](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  // Of all kinds together 1002.
  for (int move = 0; move < 167; ++move) {
    SCOPED_TRACE(move);
    // With a fine scale, and with one in which the steps of the encoder are coarse for the axis.
    BusAxis<TypeParam> axis(move % 2 == 0 ? DriveInRig<TypeParam>::text() : coarse<TypeParam>(), "",
                            between(-5, 5));
    const std::int64_t lag_ns = 4'000'000 * std::uniform_int_distribution<std::int64_t>(0, 5)(random);
    // Of CiA 402 its targets, which SYNC applies; of others all that they hear.
    constexpr bool has_sync = std::is_base_of_v<Cia402Kind, TypeParam>;
    const auto meant = TypeParam::heard_by_drive(axis.axis());
    axis.wire.set_fate([&](const auto& frame, std::int64_t) {
      const bool is_heard = std::ranges::any_of(meant, [&](const can::CanFilter& filter) {
        return ((frame.id.number() ^ filter.id.number()) & ~filter.any_bits & 0x1FFFFFFFU) == 0;
      });
      const bool is_told = has_sync ? frame.id == can::rpdo1_id(*can::NodeId::make(3)) : is_heard;
      return FrameFate{.delay_ns = is_told ? lag_ns : 0};
    });
    ASSERT_TRUE(axis.switch_on());
    axis.from = axis.state.actual;
    const double distance = between(0.1, 40) * (between(0, 1) < 0.5 ? -1 : 1);
    const double fastest =
        std::min(0.95 * 40 / std::fabs(distance), std::sqrt(0.95 * 400 / std::fabs(distance)));
    const double omega = fastest * between(0.3, 1);
    const int ticks = static_cast<int>(2 * 3.14159265358979 / omega / 0.004);
    for (int tick = 0; tick < std::min(ticks, 1500); ++tick) {
      const double s = tick * 0.004;
      axis.tick(Setpoint{.position = axis.from + distance * (1 - std::cos(omega * s)),
                         .velocity = distance * omega * std::sin(omega * s)});
      ASSERT_EQ(axis.worst, DriveCondition::fine)
          << "tick " << tick << ", distance " << distance << ", omega " << omega << ", lag " << lag_ns << ": "
          << (axis.host().first_finding() ? can::words_of(*axis.host().first_finding()).what : "");
    }
  }
}

// --- two scales

struct ScaledAxis : BusAxis<CubemarsKind> {
  ScaledAxis(double ratio, double position)
      : BusAxis<CubemarsKind>(
            R"(type = "cubemars", bus = "can0", node = 3, turns_per_unit = 0.0027777778, pole_pairs = 21, )"
            R"(gear = 9, no_watchdog = "accepted")",
            "", position) {
    drive->add_trouble({.kind = Trouble::other_scale, .place = ratio});
  }
};

// docs/faults.md 53, case 59
TEST(CubemarsOnABus, AnotherScaleIsStoppedWithinTwoDegrees) {
  for (const double ratio : {0.01, 0.8, 1.2, 1.25, 100.0, -1.0}) {
    for (const double position : {0.03, -0.03, 20.0, -60.0}) {
      SCOPED_TRACE(testing::Message() << ratio << " at " << position);
      ScaledAxis axis(ratio, position);
      axis.switch_on();
      const double began = axis.truly();
      axis.from = axis.state.actual;
      double furthest = std::fabs(axis.truly() - position);
      for (int tick = 0; tick < 700; ++tick) {
        if (axis.state.is_on) {
          axis.tick(axis.swing(tick * 0.004));
        } else {
          axis.tick();
        }
        furthest = std::max(furthest, std::fabs(axis.truly() - position));
      }
      EXPECT_NE(axis.worst, DriveCondition::fine);
      EXPECT_LT(furthest, 2);
      EXPECT_NEAR(axis.drive->velocity(), 0, 1e-3);
      std::printf("scale %6.2f at %6.2f deg: it went %.2f deg (%.2f while it was switched on)\n", ratio,
                  position, furthest, std::fabs(began - position));
    }
  }
}

TEST(CubemarsOnABus, ItsOwnStopNeedsNoPosition) {
  ScaledAxis axis(1.25, 0);
  ASSERT_TRUE(axis.switch_on());
  axis.from = axis.state.actual;
  int tick = 0;
  while (axis.state.own_stop == OwnStop::none && tick < 500) axis.tick(axis.swing(0.004 * tick++));
  ASSERT_EQ(axis.state.own_stop, OwnStop::stopped);
  EXPECT_TRUE(axis.host().findings().has(DriveFinding::scale_differs));
  axis.ticks(50, axis.swing(0.004 * tick));
  const double rests = axis.truly();
  axis.ticks(250, axis.swing(0.004 * tick));
  EXPECT_NEAR(axis.truly(), rests, 0.01);
  EXPECT_TRUE(axis.has_power());
}

// --- with a whole rig

ProgramRun run_with(const std::string& rig, const std::string& faults, const std::string& command = "run") {
  const TemporaryFile script("faults.toml", faults);
  return run_program({command, in_checkout("examples/reveal.toml"), "--rig", in_checkout("examples/" + rig),
                      "--sim", "--fast", "--faults", script.path().string()});
}

// docs/faults.md 25, case 60
TEST(Run, AnAxisThatStandsShortOfItsTargetHasNotPlayedTheMove) {
  const std::string blind = "[[fault]]\naxis = \"slide\"\nwhat = \"blind\"\nat = 0\n";
  const auto stuck = [&](const char* after) {
    return run_with("camera_rig.toml",
                    blind + "[[fault]]\naxis = \"slide\"\nwhat = \"stick\"\nafter_motion = " + after + "\n");
  };
  const ProgramRun early = stuck("1.5");
  EXPECT_EQ(early.status, 4) << early.out;
  EXPECT_THAT(early.out, testing::HasSubstr("axis \"slide\": the axis is too far from its target"));
  const ProgramRun late = stuck("6.8");
  EXPECT_EQ(late.status, 4) << late.out;
  EXPECT_THAT(late.out, testing::HasSubstr("axis \"slide\" has not arrived: it stands at 16"));
}

// docs/faults.md 52
TEST(Runaway, LosesItsPowerAndTheOthersStopOnTheirPath) {
  for (const char* rig : {"camera_rig.toml", "odrive_rig.toml", "moteus_rig.toml", "motor_rig.toml"}) {
    SCOPED_TRACE(rig);
    const std::string blind =
        rig == std::string("camera_rig.toml") ? "[[fault]]\naxis = \"pan\"\nwhat = \"blind\"\nat = 0\n" : "";
    const ProgramRun run = run_with(
        rig, blind + "[[fault]]\naxis = \"pan\"\nwhat = \"run-away\"\nspeed = 200\nafter_motion = 2\n");
    EXPECT_EQ(run.status, 4) << run.err;
    EXPECT_THAT(run.out,
                testing::HasSubstr("axis \"pan\": the axis is too far from its target, and went on when its "
                                   "drive was to stop it: its power was cut"));
    EXPECT_THAT(run.out, testing::HasSubstr("axis \"pan\" still moved at"));
    EXPECT_THAT(run.out, testing::Not(testing::HasSubstr("axis \"slide\"")));
  }
}

// --- measured by hand

ProgramRun measure(const std::string& distance, const std::string& answer) {
  const std::string program = in_build("inbetween");
  return run_command({"/bin/bash", "-c",
                      "printf -- '" + answer + "' | " + program + " jog --rig " +
                          in_checkout("examples/camera_rig.toml") +
                          " pan --sim --from pan=20 --yes --measure " + distance});
}

TEST(JogCommand, MeasuresByWhatAScaleIsWrong) {
  const ProgramRun run = measure("1", "1.25\\n");
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.out, testing::HasSubstr(
                           "axis \"pan\" moves 1.25 times as far as it is told; write counts_per_unit = "
                           "3200 in its drive, instead of 4000"));
  const ProgramRun nobody = measure("1", "");
  EXPECT_EQ(nobody.status, 1) << nobody.out;
  EXPECT_THAT(nobody.out, testing::HasSubstr("pan                  21.0000 deg"))
      << "it says where the axis is";
  const ProgramRun far = measure("190", "1\\n");
  EXPECT_EQ(far.status, 3) << far.err;
  EXPECT_THAT(far.err, testing::HasSubstr("would go to 210, outside its limits"));
}

TEST(JogCommand, SaysWhatToWriteForEveryKindOfDrive) {
  const auto words = [](const std::string& rig, std::size_t axis, double measured) {
    return scale_in_words(read_rig_file(in_checkout("examples/" + rig)).axes[axis], 10, measured);
  };
  EXPECT_THAT(words("camera_rig.toml", 1, -10), testing::HasSubstr("write counts_per_unit = -4000"));
  EXPECT_THAT(words("odrive_rig.toml", 2, 20), testing::HasSubstr("write turns_per_unit = 0.0625"));
  EXPECT_THAT(words("slider_rig.toml", 0, 5), testing::HasSubstr("write steps_per_unit = "));
  EXPECT_THAT(words("camera_rig.toml", 1, 10.04), testing::HasSubstr("is right within what was measured"));
}

}  // namespace runaway_test
}  // namespace inbetween
