// Axes over their motors: several on one axis, through a calibration, with offsets and backlash.
#include "inbetween/loop/motor_port.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <vector>

namespace inbetween {
namespace motor_port_test {

/// Motors that are where they were told to be.
struct ToldMotors {
  void read(std::span<DriveState> out, std::int64_t /*now_ns*/) {
    std::copy(states.begin(), states.end(), out.begin());
  }
  void write(std::span<const Setpoint> setpoints, std::int64_t /*now_ns*/) {
    has_setpoints = !setpoints.empty();
    for (std::size_t i = 0; i < setpoints.size(); ++i) {
      told[i] = setpoints[i];
      states[i].actual = setpoints[i].position;
    }
  }
  void enable() {}
  void disable() {}
  void quick_stop() {}
  void stop_one(std::size_t motor, OwnStop how) { states[motor].own_stop = how; }

  std::vector<DriveState> states;
  std::vector<Setpoint> told = std::vector<Setpoint>(states.size());
  bool has_setpoints = false;
};

/// A gantry with two motors, and a lift with one.
struct Gantry {
  std::array<AxisGear, 2> gears{{{.max_skew = 0.5}, {}}};
  std::array<AxisMotor, 3> of{{{.axis = 0, .offset = 2}, {.axis = 1}, {.axis = 0, .offset = -3}}};
  ToldMotors motors{.states = {{.actual = 12, .is_on = true},
                               {.actual = 40, .is_on = true},
                               {.actual = 7.1, .is_on = true}}};
  std::array<DriveState, 3> states;
  std::array<Setpoint, 3> setpoints;
  MotorPort<ToldMotors> port{motors, {gears, of, states, setpoints}};
  std::array<DriveState, 2> axes;

  void read() { port.read(axes, 0); }
  void write(double gantry, double lift) {
    const std::array<Setpoint, 2> next{{{.position = gantry, .velocity = 5}, {.position = lift}}};
    port.write(next, 0);
  }
};

TEST(MotorPort, TheFirstSetpointIsWhereEachMotorStandsAndTheirDistanceStays) {
  Gantry rig;
  rig.read();
  EXPECT_EQ(rig.axes[0].actual, 10);
  EXPECT_EQ(rig.axes[1].actual, 40);
  rig.write(rig.axes[0].actual, rig.axes[1].actual);
  EXPECT_EQ(rig.motors.told[0].position, 12);
  EXPECT_EQ(rig.motors.told[1].position, 40);
  EXPECT_DOUBLE_EQ(rig.motors.told[2].position, 7.1) << "no motor moves by being switched on";
  rig.read();
  rig.write(30, 41);
  EXPECT_EQ(rig.motors.told[0].position, 32);
  EXPECT_DOUBLE_EQ(rig.motors.told[2].position, 27.1);
  EXPECT_EQ(rig.motors.told[2].velocity, 5);
  EXPECT_EQ(rig.motors.told[1].position, 41);
}

TEST(MotorPort, AFaultOfOneMotorIsThatOfItsAxis) {
  Gantry rig;
  rig.read();
  EXPECT_TRUE(rig.axes[0].is_on);
  EXPECT_EQ(rig.axes[0].condition, DriveCondition::fine);
  rig.motors.states[2].condition = DriveCondition::cannot_follow;
  rig.read();
  EXPECT_EQ(rig.axes[0].condition, DriveCondition::cannot_follow);
  EXPECT_EQ(rig.axes[1].condition, DriveCondition::fine);
  rig.motors.states[2] = {
      .actual = 7.1, .is_on = false, .is_leaving = true, .condition = DriveCondition::unreachable};
  rig.read();
  EXPECT_FALSE(rig.axes[0].is_on);
  EXPECT_TRUE(rig.axes[0].is_leaving);
  EXPECT_EQ(rig.axes[0].condition, DriveCondition::unreachable);
}

// docs/faults.md 52
TEST(MotorPort, WhereOneMotorIsStoppedAloneTheOthersOfItsAxisAreToo) {
  for (const std::size_t first : {0U, 2U}) {
    Gantry rig;
    for (const OwnStop how : {OwnStop::stopped, OwnStop::cut}) {
      rig.motors.states[first].own_stop = how;
      rig.read();
      EXPECT_EQ(rig.axes[0].own_stop, how);
      EXPECT_EQ(rig.motors.states[0].own_stop, how);
      EXPECT_EQ(rig.motors.states[2].own_stop, how);
      EXPECT_EQ(rig.motors.states[1].own_stop, OwnStop::none) << "another axis goes on";
    }
  }
}

TEST(MotorPort, AnAxisHasArrivedWhenAllItsMotorsHave) {
  Gantry rig;
  rig.read();
  EXPECT_TRUE(rig.axes[0].is_in_position);
  rig.motors.states[2].is_in_position = false;
  rig.read();
  EXPECT_FALSE(rig.axes[0].is_in_position);
  EXPECT_TRUE(rig.axes[1].is_in_position);
}

TEST(MotorPort, MotorsThatAreTooFarApartCannotFollow) {
  Gantry rig;
  rig.motors.states[2].actual = 7.5;
  rig.read();
  EXPECT_EQ(rig.axes[0].condition, DriveCondition::fine) << "at the limit";
  rig.motors.states[2].actual = 7.51;
  rig.read();
  EXPECT_EQ(rig.axes[0].condition, DriveCondition::cannot_follow);
  EXPECT_TRUE(rig.gears[0].is_skewed);
  rig.port.enable();
  EXPECT_FALSE(rig.gears[0].is_skewed) << "somebody has squared it, or will be told again";
  rig.motors.states[0].is_on = false;
  rig.read();
  EXPECT_EQ(rig.axes[0].condition, DriveCondition::fine) << "while one is off, nobody knows where it is";
}

TEST(MotorPort, AMotorFollowsThroughItsCalibrationByTheChainRule) {
  std::array<CalibrationPiece, 4> pieces;
  const std::array<CalibrationMark, 3> marks{{{0, 0}, {1, 90}, {3, 150}}};
  const auto curve = Calibration::make(marks, pieces);
  ASSERT_TRUE(curve);
  std::array<AxisGear, 1> gears{{{.calibration = &*curve}}};
  std::array<AxisMotor, 1> of{{{.axis = 0, .offset = 10}}};
  ToldMotors motors{.states = {{.actual = 100, .is_on = true}}};
  std::array<DriveState, 1> states, axes;
  std::array<Setpoint, 1> setpoints;
  MotorPort<ToldMotors> port(motors, {gears, of, states, setpoints});
  port.read(axes, 0);
  EXPECT_NEAR(axes[0].actual, 1, 1e-12) << "at the mark of 90";
  constexpr double h = 1e-4;
  const auto told = [&](double position) {
    const std::array<Setpoint, 1> next{{{.position = position, .velocity = 2, .acceleration = -3}}};
    port.write(next, 0);
    return motors.told[0];
  };
  const Setpoint before = told(1.5 - h), here = told(1.5), after = told(1.5 + h);
  const double slope = (after.position - before.position) / (2 * h);
  const double bend = (after.position - 2 * here.position + before.position) / (h * h);
  EXPECT_NEAR(here.velocity, slope * 2, 1e-4);
  EXPECT_NEAR(here.acceleration, bend * 4 - 3 * slope, 1e-4);
}

TEST(MotorPort, WhatIsPlannedOfAMotorHoldsWhileItsAxisIsToldTheSame) {
  std::array<CalibrationPiece, 3> pieces;
  const std::array<CalibrationMark, 2> marks{{{0, 0}, {1, 90}}};
  const auto curve = Calibration::make(marks, pieces);
  ASSERT_TRUE(curve);
  std::array<AxisGear, 1> gears{{{.calibration = &*curve}}};
  std::array<AxisMotor, 1> of{{{.axis = 0, .offset = 10}}};
  ToldMotors motors{.states = {{.actual = 10, .is_on = true}}};
  std::array<DriveState, 1> states, axes;
  std::array<Setpoint, 1> setpoints;
  MotorPort<ToldMotors> port(motors, {gears, of, states, setpoints});
  port.read(axes, 0);
  const auto tell = [&](const Setpoint& axis) {
    port.write(std::span(&axis, 1), 0);
    return motors.told[0];
  };
  const Setpoint axis{0.5, 1, 2};
  port.plan_motor(0, axis, {45.001, 90.5, 181});
  for (int tick = 0; tick < 3; ++tick) {
    EXPECT_EQ(tell(axis), (Setpoint{55.001, 90.5, 181})) << "with its offset, as long as it holds";
  }
  EXPECT_EQ(tell({0.5, 0, 0}), (Setpoint{55, 0, 0})) << "another motion through the same place";
  EXPECT_EQ(tell(axis), (Setpoint{55.001, 90.5, 181}));
}

TEST(MotorPort, ThePlayIsCrossedWhenTheAxisTurnsAndNotWhenSetpointsCease) {
  std::array<AxisGear, 1> gears{{{.take_up = TakeUp({.distance = -0.5, .ticks = 10}, 0.004)}}};
  std::array<AxisMotor, 1> of{{{.axis = 0}}};
  ToldMotors motors{.states = {{.actual = 5, .is_on = true}}};
  std::array<DriveState, 1> states, axes;
  std::array<Setpoint, 1> setpoints;
  MotorPort<ToldMotors> port(motors, {gears, of, states, setpoints});
  const auto go = [&](double position) {
    port.read(axes, 0);
    const std::array<Setpoint, 1> next{{{.position = position}}};
    port.write(next, 0);
  };
  go(5);
  go(6);
  EXPECT_EQ(motors.told[0].position, 6) << "approaching";
  for (int i = 1; i <= 5; ++i) go(6 - 0.1 * i);
  EXPECT_FALSE(port.is_resting());
  EXPECT_NEAR(motors.told[0].position, 5.5 - 0.25, 1e-12) << "half of the play after half of the time";
  port.read(axes, 0);
  EXPECT_NEAR(axes[0].actual, 5.5, 1e-12) << "the axis is where it was told to be";
  port.write({}, 0);
  EXPECT_FALSE(motors.has_setpoints);
  EXPECT_TRUE(port.is_resting());
  go(5.5);
  go(5.5);
  EXPECT_NEAR(motors.told[0].position, 5.25, 1e-12) << "nothing moves by being switched on";
  for (int i = 1; i <= 10; ++i) go(5.5 - 0.1 * i);
  EXPECT_NEAR(motors.told[0].position, 4.5 - 0.5, 1e-12);
}

}  // namespace motor_port_test
}  // namespace inbetween
