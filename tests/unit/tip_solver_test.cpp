// Which solution of several the solver takes, and what it does not take for one.
#include "host_tools/joints/tip_solver.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "tests/support/jointed_rig.hpp"
#include "tests/support/oracle_kinematics.hpp"

namespace inbetween {
namespace tip_solver_test {

using Kind = OracleJointKind;
constexpr double pi = std::numbers::pi;

/// Two links of 1 m that turn about z, on a lift: two solutions, with elbows at + and -.
const std::vector<OracleJoint> arm_on_a_lift = {
    {.kind = Kind::prismatic, .parent = -1, .coordinate = 0},
    {.kind = Kind::revolute, .parent = 0, .coordinate = 1},
    {.kind = Kind::revolute, .parent = 1, .coordinate = 2, .xyz = {1, 0, 0}},
    {.kind = Kind::fixed, .parent = 2, .xyz = {1, 0, 0}}};

std::vector<TipAxis> axes_of_lift(double near_of_elbow) {
  return {{0, -2, 2, 0}, {1, -3, 3, 0}, {2, -3, 3, near_of_elbow}};
}

const TipTarget somewhere{.position = Vector3{1.2, 0, 0.5}, .aim = {}, .roll = {}};

TEST(TipSolver, TheFirstSolutionIsTheOneNearestToNear) {
  const Kinematics kinematics = kinematics_of(arm_on_a_lift);
  for (const double near : {-1.0, 1.0}) {
    const TipSolver solver(kinematics, 4, axes_of_lift(near));
    ASSERT_FALSE(solver.is_two_joint_arm());
    const TipSolution found = solver.solve_from_ranges(somewhere);
    ASSERT_TRUE(found.is_exact());
    EXPECT_GT(found.positions[2] * near, 0.5);
  }
}

TEST(TipSolver, ASolutionInsideTheRangesComesBeforeANearerOneOutside) {
  const Kinematics kinematics = kinematics_of(arm_on_a_lift);
  std::vector<TipAxis> axes = axes_of_lift(0.4);
  axes[2].max = 0.5;  // the elbow of this side is at 1.85
  const TipSolution found = TipSolver(kinematics, 4, axes).solve_from_ranges(somewhere);
  ASSERT_TRUE(found.is_exact());
  EXPECT_LT(found.positions[2], -0.5);
}

TEST(TipSolver, AxesThatAreLeftFreeShareTheMotionAndStayAsNearAsTheyCan) {
  std::vector<OracleJoint> joints;
  for (int i = 0; i < 4; ++i) {
    joints.push_back({.kind = Kind::prismatic, .parent = i - 1, .coordinate = i});
    joints.back().axis = i < 2 ? std::array<double, 3>{1, 0, 0}
                               : std::array<double, 3>{0, i == 2 ? 1.0 : 0.0, i == 3 ? 1.0 : 0.0};
  }
  const Kinematics kinematics = kinematics_of(joints);
  const TipSolver solver(kinematics, 4, {{0, -5, 5, 1}, {1, -5, 5, -2}, {2, -5, 5, 0}, {3, -5, 5, 0}});
  // From a place far from near, too: where a solution begins does not count.
  const TipSolution found =
      solver.solve({.position = Vector3{3, 0, 0}, .aim = {}, .roll = {}}, {4, -4, 0, 0});
  ASSERT_TRUE(found.is_exact());
  EXPECT_NEAR(found.positions[0], 1 + 2, 1e-9);
  EXPECT_NEAR(found.positions[1], -2 + 2, 1e-9);
}

TEST(TipSolver, ALensThatLooksAwayFromThePointIsNoSolution) {
  const Kinematics kinematics =
      kinematics_of({{.kind = Kind::prismatic, .parent = -1, .coordinate = 0, .axis = {1, 0, 0}}});
  const TipSolver solver(kinematics, 1, {{0, -1, 1, 0}});
  EXPECT_TRUE(solver.solve({.position = {}, .aim = Vector3{9, 0, 0}, .roll = {}}, {0}).is_exact());
  EXPECT_FALSE(solver.solve({.position = {}, .aim = Vector3{-9, 0, 0}, .roll = {}}, {0}).is_exact());
}

TEST(TipSolver, APictureUpsideDownIsNoSolution) {
  const Kinematics kinematics =
      kinematics_of({{.kind = Kind::revolute, .parent = -1, .coordinate = 0, .axis = {1, 0, 0}}});
  const TipSolver solver(kinematics, 1, {{0, -4, 4, 0}});
  const TipTarget level{.position = {}, .aim = Vector3{9, 0, 0}, .roll = 0.0};
  EXPECT_TRUE(solver.solve(level, {0.1}).is_exact());
  EXPECT_FALSE(solver.solve(level, {pi}).is_exact());
}

/// Pan about z, then tilt up, both in one point.
const std::vector<OracleJoint> head = {
    {.kind = Kind::revolute, .parent = -1, .coordinate = 0},
    {.kind = Kind::revolute, .parent = 0, .coordinate = 1, .axis = {0, -1, 0}}};

TEST(TipSolver, AHeadTurnsOnceMoreWhereItsRangeAsksForIt) {
  const Kinematics kinematics = kinematics_of(head);
  const TipSolver solver(kinematics, 2, {{0, 5, 9.9, 5}, {1, -1, 1, 0}});
  // The pan of 3.5 rad is nearer to 5.
  const TipTarget target{.position = {}, .aim = Vector3{std::cos(3.5), std::sin(3.5), 0.1}, .roll = {}};
  const TipSolution found = solver.solve_from_ranges(target);
  ASSERT_TRUE(found.is_exact());
  EXPECT_NEAR(found.positions[0], 2 * pi + 3.5, 1e-12);
}

TEST(TipSolver, AHeadGoesOverTheTopOnlyWhereItsRangeLetsIt) {
  const Kinematics kinematics = kinematics_of(head);
  const TipTarget target{
      .position = {},
      .aim = Vector3{std::cos(0.3) * std::cos(1.2), std::sin(0.3) * std::cos(1.2), std::sin(1.2)},
      .roll = {}};
  for (const double max : {1.4, 2.5}) {
    const TipSolver solver(kinematics, 2, {{0, -1, 4, 3.4}, {1, -1, max, 1.4}});
    const TipSolution found = solver.solve_from_ranges(target);
    ASSERT_TRUE(found.is_exact());
    EXPECT_NEAR(found.positions[0], max < 2 ? 0.3 : 0.3 + pi, 1e-12);
    EXPECT_NEAR(found.positions[1], max < 2 ? 1.2 : pi - 1.2, 1e-12);
  }
}

TEST(TipSolver, WhatIsAlmostACraneHasNoClosedForm) {
  const std::vector<OracleJoint> crane = {
      {.kind = Kind::prismatic, .parent = -1, .coordinate = 0, .axis = {1, 0, 0}},
      {.kind = Kind::revolute, .parent = 0, .coordinate = 1, .xyz = {0, 0, 1}},
      {.kind = Kind::revolute, .parent = 1, .coordinate = 2, .axis = {0, -1, 0}},
      {.kind = Kind::revolute,
       .parent = 2,
       .coordinate = 2,
       .factor = -1,
       .xyz = {2, 0, 0},
       .axis = {0, -1, 0}},
      {.kind = Kind::revolute, .parent = 3, .coordinate = 3},
      {.kind = Kind::revolute, .parent = 4, .coordinate = 4, .axis = {0, -1, 0}},
      {.kind = Kind::revolute, .parent = 5, .coordinate = 5, .axis = {1, 0, 0}}};
  const auto is_found = [](const std::vector<OracleJoint>& joints) {
    std::vector<TipAxis> axes;
    for (std::size_t i = 0; i < 6; ++i) axes.push_back({i, -1, 1, 0});
    return CraneSolutions::find(kinematics_of(joints), static_cast<std::int32_t>(joints.size()), axes)
        .has_value();
  };
  EXPECT_TRUE(is_found(crane));
  const auto with_joint = [&](std::size_t index, const auto& change) {
    std::vector<OracleJoint> joints = crane;
    change(joints[index]);
    return is_found(joints);
  };
  EXPECT_FALSE(with_joint(1, [](OracleJoint& swing) { swing.axis = {0.01, 0, 1}; }));
  EXPECT_FALSE(with_joint(2, [](OracleJoint& boom) { boom.axis = {0, -1, 0.01}; }));
  EXPECT_FALSE(with_joint(3, [](OracleJoint& level) { level.factor = -0.9; }));
  EXPECT_FALSE(with_joint(3, [](OracleJoint& level) { level.axis = {0, 1, 0}; }));
  EXPECT_FALSE(with_joint(5, [](OracleJoint& tilt) { tilt.axis = {0, -1, 0.01}; }));
  EXPECT_FALSE(with_joint(5, [](OracleJoint& tilt) {
    tilt.xyz = {0.01, 0, 0};
  })) << "the pan passes beside it";
  EXPECT_FALSE(with_joint(6, [](OracleJoint& roll) { roll.xyz = {0, 0, 0.01}; }));
  EXPECT_FALSE(with_joint(6, [](OracleJoint& roll) { roll.axis = {1, 0.01, 0}; }));
  EXPECT_FALSE(with_joint(6, [](OracleJoint& roll) { roll.kind = Kind::prismatic; }));
  EXPECT_TRUE(with_joint(6, [](OracleJoint& roll) { roll.xyz = {0.3, 0, 0}; })) << "along its own axis";
}

TEST(TipSolver, AHeadWhosePanFollowsAnotherJointWithAnOffsetIsSolvedToo) {
  // Joint 0 is elsewhere; the head's pan is 2 * it + 0.4.
  const std::vector<OracleJoint> joints = {
      {.kind = Kind::revolute, .parent = -1, .coordinate = 0},
      {.kind = Kind::revolute, .parent = -1, .coordinate = 0, .factor = 2, .offset = 0.4},
      {.kind = Kind::revolute, .parent = 1, .coordinate = 1, .axis = {0, -1, 0}}};
  const Kinematics kinematics = kinematics_of(joints);
  const std::vector<TipAxis> axes = {{0, -2, 2, 0}, {1, -1, 1, 0}};
  EXPECT_FALSE(CraneSolutions::find(kinematics, 3, axes).has_value());
  const TipSolution found =
      TipSolver(kinematics, 3, axes).solve_from_ranges({.position = {}, .aim = Vector3{3, 3, 0}, .roll = {}});
  ASSERT_TRUE(found.is_exact());
  EXPECT_NEAR(2 * found.positions[0] + 0.4, pi / 4, 1e-9);
}

}  // namespace tip_solver_test
}  // namespace inbetween
