// Which solution of several the solver takes, and what it does not take for one.
#include "host_tools/joints/tip_solver.hpp"

#include <gtest/gtest.h>

#include <cstddef>
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

const TipTarget somewhere{.position = Vector3<double>{1.2, 0, 0.5}, .aim = {}, .roll = {}};

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

TEST(TipSolver, AxesThatAreLeftFreeShareTheWayAndStayAsNearAsTheyCan) {
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
      solver.solve({.position = Vector3<double>{3, 0, 0}, .aim = {}, .roll = {}}, {4, -4, 0, 0});
  ASSERT_TRUE(found.is_exact());
  EXPECT_NEAR(found.positions[0], 1 + 2, 1e-9);
  EXPECT_NEAR(found.positions[1], -2 + 2, 1e-9);
}

TEST(TipSolver, ALensThatLooksAwayFromThePointIsNoSolution) {
  const Kinematics kinematics =
      kinematics_of({{.kind = Kind::prismatic, .parent = -1, .coordinate = 0, .axis = {1, 0, 0}}});
  const TipSolver solver(kinematics, 1, {{0, -1, 1, 0}});
  EXPECT_TRUE(solver.solve({.position = {}, .aim = Vector3<double>{9, 0, 0}, .roll = {}}, {0}).is_exact());
  EXPECT_FALSE(solver.solve({.position = {}, .aim = Vector3<double>{-9, 0, 0}, .roll = {}}, {0}).is_exact());
}

TEST(TipSolver, APictureUpsideDownIsNoSolution) {
  const Kinematics kinematics =
      kinematics_of({{.kind = Kind::revolute, .parent = -1, .coordinate = 0, .axis = {1, 0, 0}}});
  const TipSolver solver(kinematics, 1, {{0, -4, 4, 0}});
  const TipTarget level{.position = {}, .aim = Vector3<double>{9, 0, 0}, .roll = 0.0};
  EXPECT_TRUE(solver.solve(level, {0.1}).is_exact());
  EXPECT_FALSE(solver.solve(level, {pi}).is_exact());
}

TEST(TipSolver, AHeadInTheRangesTurnsAsFarAsItMust) {
  // Pan and tilt, whose pan may only be where it has gone round once.
  const Kinematics kinematics =
      kinematics_of({{.kind = Kind::revolute, .parent = -1, .coordinate = 0},
                     {.kind = Kind::revolute, .parent = 0, .coordinate = 1, .axis = {0, -1, 0}}});
  const TipSolver solver(kinematics, 2, {{0, 5, 9, 5}, {1, -1, 1, 0}});
  const TipSolution found =
      solver.solve_from_ranges({.position = {}, .aim = Vector3<double>{2, 2, 0.1}, .roll = {}});
  ASSERT_TRUE(found.is_exact());
  EXPECT_NEAR(found.positions[0], 2 * pi + pi / 4, 1e-12);
  EXPECT_GT(found.positions[1], 0);
}

}  // namespace tip_solver_test
}  // namespace inbetween
