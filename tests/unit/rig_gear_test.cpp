// Axes with several motors, a calibration, backlash and an offset: read, proven, played and stopped.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/motions/run.hpp"
#include "host_tools/rig/fault_script.hpp"
#include "host_tools/rig/rig_drives.hpp"
#include "host_tools/rig/simulated_hardware.hpp"
#include "host_tools/rig_model/rig_motors.hpp"
#include "tests/support/places.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace rig_gear_test {

using testing::HasSubstr;

const std::string second_motor =
    "ganged = [{ drive = { " + cia402_text(2, -1000) + " }, offset = 3.5 }]\nmax_skew = 0.5\n";
const std::string lens = R"(max_jerk = 1000
calibration = { unit = "deg", marks = [[0.5, 0], [1, 100], [2, 160], [5, 210]], max_velocity = 200, max_acceleration = 900, max_jerk = 20000 }
)";
const std::string play = R"(backlash = { play = 0.2, take_up_s = 0.4, approach = "positive" }
)";

std::string gantry_text(const std::string& more) {
  return rig_text({{.name = "gantry", .more = more, .drive = cia402_text(1)}},
                  {.rate_hz = 250, .more = bus_can0});
}
std::string lens_text(const std::string& more = lens) {
  return rig_text(
      {axis_text("focus", "m", {0.5, 5}, {.velocity = 10, .acceleration = 100}, more, cia402_text(1, 100))},
      {.rate_hz = 250, .more = bus_can0});
}

std::string move_of(const std::string& axis, const std::string& keys, int frames = 96) {
  return fmt::format(
      "name = \"m\"\nfps = 24\nframes = {}\n[[track]]\naxes = [\"{}\"]\nkeys = [{}]\nspeed = [0, 0, 10, 10, "
      "0, 0]\ncorners = \"ease\"\n",
      frames, axis, keys);
}
Plan plan_of(const std::string& move, const std::string& rig) {
  return {parse_move(move, "move.toml"), parse_rig(rig, "rig.toml"), {}};
}
const std::string there_and_back = "{ at = [10] }, { at = [60] }, { at = [10] }";

std::string refused(const std::string& rig) {
  try {
    parse_rig(rig, "rig.toml");
  } catch (const InputError& error) {
    return to_string(error.place()) + ": " + error.message();
  }
  return "accepted";
}

// --- the file

TEST(RigGear, ARigWithoutGearsIsItsOwnMotors) {
  const RigFile rig = read_rig_file(in_checkout("examples/camera_rig.toml"));
  const RigMotors motors = motors_of(rig);
  EXPECT_TRUE(motors.gears.empty());
  ASSERT_EQ(motors.rig.axes.size(), rig.axes.size());
  for (std::size_t a = 0; a < rig.axes.size(); ++a) EXPECT_EQ(motors.rig.axes[a].max, rig.axes[a].max);
}

TEST(RigGear, TheMotorsOfAnAxisHaveNamesRangesAndLimitsOfTheirOwn) {
  const RigFile rig = parse_rig(gantry_text(second_motor + "offset = -1\n"), "rig.toml");
  const RigMotors motors = motors_of(rig);
  ASSERT_EQ(motors.rig.axes.size(), 2U);
  EXPECT_EQ(motors.rig.axes[1].name, "gantry.2");
  EXPECT_EQ(motors.rig.axes[0].min, -101);
  EXPECT_EQ(motors.rig.axes[1].max, 203.5);
  EXPECT_EQ(std::get<Cia402Drive>(motors.rig.axes[1].drive).node, 2);
  const RigFile calibrated = parse_rig(lens_text(lens + play), "rig.toml");
  const RigAxis motor = motors_of(calibrated).rig.axes.front();
  EXPECT_EQ(motor.unit, AxisUnit::deg);
  EXPECT_DOUBLE_EQ(motor.min, -0.2) << "the play is below the first mark, against the approach";
  EXPECT_DOUBLE_EQ(motor.max, 210);
  EXPECT_EQ(motor.max_velocity, 200);
  EXPECT_EQ(motor.stop_acceleration, 1350);
}

TEST(RigGear, TheTakeUpIsTakenOffTheLimitsOfTheAxis) {
  const RigFile rig = parse_rig(gantry_text(play + "max_jerk = 4000\n"), "rig.toml");
  const RigAxis& axis = rig.axes.front();
  EXPECT_DOUBLE_EQ(axis.max_velocity, 150 - 1.875 * 0.2 / 0.4);
  EXPECT_DOUBLE_EQ(axis.max_acceleration, 400 - 10 / std::sqrt(3.0) * 0.2 / 0.16);
  EXPECT_DOUBLE_EQ(*axis.max_jerk, 4000 - 60 * 0.2 / 0.064);
  EXPECT_DOUBLE_EQ(*axis.stop_acceleration, 600 - 10 / std::sqrt(3.0) * 0.2 / 0.16);
  EXPECT_EQ(motors_of(rig).rig.axes.front().max_velocity, 150) << "the motor has all of it";
}

TEST(RigGear, WhatCannotBeIsRefusedAtItsPlace) {
  EXPECT_THAT(refused(gantry_text("max_skew = 1\n")), HasSubstr("add ganged = [...]"));
  EXPECT_THAT(refused(gantry_text("ganged = [{ drive = { " + cia402_text(2) + " } }]\n")),
              HasSubstr("max_skew"));
  EXPECT_THAT(refused(gantry_text("ganged = [{ drive = { " + cia402_text(1) + " } }]\nmax_skew = 1\n")),
              HasSubstr("node 1 of bus can0"));
  EXPECT_THAT(refused(gantry_text("ganged = [{ drive = { type = \"pipe\", path = \"/dev/null\", "
                                  "counts_per_unit = 1 } }]\nmax_skew = 1\n")),
              HasSubstr("is of another type"));
  EXPECT_THAT(refused(gantry_text("backlash = { play = 0.2, take_up_s = 0.01, approach = \"positive\" }\n")),
              HasSubstr("which leaves nothing of max_acceleration = 400; give it a longer take_up_s"));
  EXPECT_THAT(refused(gantry_text(play + "max_jerk = 100\n")),
              HasSubstr("would be taken up with 187.5 mm/s^3, which leaves nothing of max_jerk = 100"));
  EXPECT_THAT(refused(lens_text(
                  with(lens, "max_acceleration = 900", "max_acceleration = 900, stop_acceleration = 800"))),
              HasSubstr("stop_acceleration is 800, below that of the motion, 900"));
  EXPECT_THAT(refused(lens_text(with(lens, "max_jerk = 20000", "max_jerk = 20000, stop_jerk = 19000"))),
              HasSubstr("stop_jerk is 19000, below that of the motion, 20000"));
  const auto with_marks = [](const std::string& marks) {
    return lens_text(
        "calibration = { unit = \"deg\", max_velocity = 9, max_acceleration = 9, marks = " + marks + " }\n");
  };
  EXPECT_THAT(refused(with_marks("[[0.5, 0], [1, 2], [1, 3]]")), HasSubstr("does not rise"));
  EXPECT_THAT(refused(with_marks("[[0.5, 0], [1, 2], [5, 1]]")), HasSubstr("turns back or stays"));
  EXPECT_THAT(refused(with_marks("[[0.5, 0], [4, 20]]")), HasSubstr("and the axis from 0.5 to 5"));
  EXPECT_THAT(refused(with_marks("[[0.5, 0], [1, 1], [1.1, 100], [5, 101]]")),
              HasSubstr("measure one more mark between the two"));
  EXPECT_THAT(refused(lens_text(lens + "max_acceleration_step = 1\n")), HasSubstr("leave one of them out"));
}

// --- the certificate

TEST(RigGear, AMoveThatItsMotorCannotFollowIsRefusedWithAxisAndFrame) {
  const CheckReport slow = check(plan_of(move_of("focus", "{ at = [5] }, { at = [0.5] }", 144), lens_text()));
  EXPECT_TRUE(slow.fits()) << slow.refusals.front().message();
  ASSERT_EQ(slow.motors.size(), 1U);
  EXPECT_EQ(slow.motors.front().unit, "deg");
  EXPECT_TRUE(slow.stops.has_value());
  const CheckReport quick = check(plan_of(move_of("focus", "{ at = [5] }, { at = [0.5] }", 36), lens_text()));
  ASSERT_FALSE(quick.fits());
  EXPECT_THAT(quick.refusals.front().message(), HasSubstr("the motor of axis \"focus\" would reach"));
  EXPECT_THAT(quick.refusals.front().message(), HasSubstr("at frame"));
  EXPECT_LT(quick.highest_rate, 1);
  EXPECT_LE(quick.axes.front().velocity.value, 10) << "the axis itself could";
}

TEST(RigGear, WhatTheTakeUpNeedsIsMissingForTheMotion) {
  const std::string move = move_of("gantry", there_and_back, 60);
  const CheckReport plain = check(plan_of(move, gantry_text("")));
  ASSERT_TRUE(plain.fits()) << plain.refusals.front().message();
  // A limit just above what the motion needs.
  const double needed = plain.axes.front().acceleration.value;
  const std::string rig =
      rig_text({{.name = "gantry", .max_acceleration = needed + 5, .more = play, .drive = cia402_text(1)}},
               {.rate_hz = 250, .more = bus_can0});
  const CheckReport tight = check(plan_of(move, rig));
  ASSERT_FALSE(tight.fits());
  EXPECT_THAT(tight.refusals.front().message(),
              HasSubstr("max_acceleration leaves beside the take-up of the backlash"));
}

// --- played

/// What the motors of a simulated rig do while one axis goes there and back in two seconds.
struct Played {
  RigFile rig;
  SimulatedHardware hardware;
  RigDrives drives{rig, hardware};
  std::vector<DriveState> states = std::vector<DriveState>(1);
  std::int64_t now_ns = 0;

  Played(const std::string& text, double stands, const std::string& faults = "")
      : rig(parse_rig(text, "rig.toml")),
        hardware(rig, {stands},
                 faults.empty() ? FaultScript{} : parse_fault_script(faults, "faults.toml", rig)) {}

  void tick(const std::vector<Setpoint>& setpoints) {
    drives.read(states, now_ns += 4'000'000);
    drives.write(setpoints, now_ns);
  }
  bool switch_on() {
    drives.enable();
    for (int i = 0; i < 3000 && !states.front().is_on; ++i) tick({});
    return states.front().is_on;
  }
};

TEST(RigGear, EveryMotorIsWhereItsAxisShallBe) {
  for (const std::string& more : {second_motor + "offset = -1\n", second_motor + play}) {
    Played played(gantry_text(more), 10);
    ASSERT_TRUE(played.switch_on()) << played.drives.trouble();
    EXPECT_NEAR(played.states.front().actual, 10, 1e-3);
    double position = 10;
    for (int i = 0; i < 1000; ++i) {
      position = 10 + 50 * (1 - std::cos(i * 0.004 * 3.14159265)) / 2;
      played.tick({{.position = position}});
      ASSERT_EQ(played.states.front().condition, DriveCondition::fine) << played.drives.trouble();
    }
    for (int i = 0; i < 150; ++i) played.tick({{.position = position}});
    const RigMotors motors = motors_of(played.rig);
    // It came down last: against the approach.
    const double taken = played.rig.axes.front().backlash ? -0.2 : 0;
    for (std::size_t m = 0; m < motors.of.size(); ++m) {
      EXPECT_NEAR(played.hardware.true_motor_position(m), position + motors.of[m].offset + taken, 2e-3) << m;
    }
    EXPECT_NEAR(played.states.front().actual, position, 2e-3);
  }
}

TEST(RigGear, AMotorThatIsPushedAwayFromTheOtherStopsTheRig) {
  Played played(gantry_text(second_motor), 10,
                "[[fault]]\naxis = \"gantry.2\"\nwhat = \"move-by-hand\"\nto = 14.2\nat = 0\n");
  EXPECT_TRUE(played.switch_on());
  EXPECT_EQ(played.states.front().condition, DriveCondition::cannot_follow) << "0.7 apart";
  EXPECT_THAT(played.drives.trouble(), HasSubstr("its motors are more than max_skew = 0.5 mm apart"));
}

TEST(RigGear, AFaultOfOneOfItsMotorsEndsTheRun) {
  const Plan plan = plan_of(move_of("gantry", there_and_back), gantry_text(second_motor));
  const FaultScript faults = parse_fault_script(
      "[[fault]]\naxis = \"gantry.2\"\nwhat = \"emergency\"\ncode = 0x2310\nafter_motion = 1\n",
      "faults.toml", *plan.rig());
  const RunReport report = run(plan, {.simulated = true, .fast = true, .faults = faults});
  EXPECT_EQ(report.ending, Ending::fault);
  EXPECT_THAT(report.reason, HasSubstr("axis \"gantry.2\""));
}

TEST(RigGear, AMoveIsPlayedThroughACalibrationWithPlayOnEveryKindOfDrive) {
  const std::string marks = R"(max_jerk = 1000
calibration = { unit = "deg", marks = [[0, 0], [30, 40], [100, 100]], max_velocity = 900, max_acceleration = 9000 }
backlash = { play = 0.2, take_up_s = 0.3, approach = "negative" }
)";
  for (const std::string& drive :
       {cia402_text(1, 1000),
        std::string(R"(type = "odrive", bus = "can0", node = 3, turns_per_unit = 0.02, firmware = "0.6")"),
        std::string(R"(type = "step-dir", chip = "gpio", step = 17, dir = 27, steps_per_unit = 8)"),
        std::string(R"(type = "pipe", path = "/dev/null", counts_per_unit = 10)")}) {
    const Plan plan = plan_of(move_of("x", there_and_back),
                              rig_text({{.name = "x", .min = 0, .max = 100, .more = marks, .drive = drive}},
                                       {.rate_hz = 250, .more = bus_can0}));
    const RunReport report = run(plan, {.simulated = true, .fast = true});
    EXPECT_EQ(report.ending, Ending::finished) << drive << ": " << report.reason;
    EXPECT_EQ(report.axes.front().last_commanded, 10);
    EXPECT_NEAR(report.axes.front().last_actual, 10, 0.1) << drive;
  }
}

}  // namespace rig_gear_test
}  // namespace inbetween
