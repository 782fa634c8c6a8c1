#include "inbetween/joints/joint_tree.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace inbetween {
namespace joint_tree_test {

constexpr double degree = std::numbers::pi / 180;

/// Shoulder and elbow in degrees, 2 m and 1 m long; the hand is a fixed link.
std::vector<Joint> two_joint_arm() {
  return {{.kind = JointKind::revolute, .parent = -1, .coordinate = 0, .factor = degree},
          {.kind = JointKind::revolute,
           .parent = 0,
           .coordinate = 1,
           .factor = degree,
           .origin = {{}, {2, 0, 0}}},
          {.kind = JointKind::fixed, .parent = 1, .origin = {{}, {1, 0, 0}}}};
}

struct Tree {
  explicit Tree(const std::vector<Joint>& joints, std::int32_t coordinates)
      : made(JointTree::make(joints, coordinates, memory)) {}
  JointStorage<8> memory{};
  Result<JointTree> made;
};

void expect_near(const Vector3& found, const Vector3& expected) {
  EXPECT_NEAR(found.x, expected.x, 1e-14);
  EXPECT_NEAR(found.y, expected.y, 1e-14);
  EXPECT_NEAR(found.z, expected.z, 1e-14);
}

TEST(JointTree, AnArmIsWhereItsAnglesPutIt) {
  const Tree arm(two_joint_arm(), 2);
  std::array<Pose, 3> poses;
  ASSERT_TRUE(arm.made->poses(std::array{90.0, -90.0}, poses));
  expect_near(poses[1].position, {0, 2, 0});
  expect_near(poses[2].position, {1, 2, 0});
  expect_near(poses[2].rotation.x, {1, 0, 0});
}

TEST(JointTree, AMimicJointFollowsTheCoordinateOfAnother) {
  std::vector<Joint> joints = two_joint_arm();
  joints[1].coordinate = 0;  // the hand keeps its direction, whatever the shoulder does
  joints[1].factor = -degree;
  joints[1].offset = 90 * degree;
  const Tree arm(joints, 1);
  std::array<Pose, 3> poses;
  for (const double shoulder : {-50.0, 0.0, 77.0}) {
    ASSERT_TRUE(arm.made->poses(std::array{shoulder}, poses));
    expect_near(poses[2].rotation.x, {0, 1, 0});
  }
  std::array<JacobianColumn, 1> jacobian;
  arm.made->jacobian(2, poses, jacobian);
  expect_near(jacobian[0].angular, {});
}

/// A carriage on a turning boom: Coriolis acceleration 2 w v, centripetal acceleration w^2 r.
TEST(JointTree, ASlideOnATurnIsAcceleratedSideways) {
  const std::vector<Joint> joints = {
      {.kind = JointKind::revolute, .coordinate = 0},
      {.kind = JointKind::prismatic, .parent = 0, .coordinate = 1, .axis = {5, 0, 0}}};
  const Tree boom(joints, 2);
  std::array<LinkMotion, 2> motion;
  ASSERT_TRUE(boom.made->motion(std::array<CoordinateMotion, 2>{{{0, 3, 0}, {2, 0.5, 0}}}, motion));
  expect_near(motion[1].pose.position, {2, 0, 0});
  expect_near(motion[1].velocity, {0.5, 6, 0});
  expect_near(motion[1].acceleration, {-18, 3, 0});
  expect_near(motion[1].angular_velocity, {0, 0, 3});
}

TEST(JointTree, ACoordinateMovesOnlyWhatHangsOnItsJoint) {
  std::vector<Joint> joints = two_joint_arm();
  joints.push_back({.kind = JointKind::prismatic, .parent = 0, .coordinate = 2});
  const Tree tree(joints, 3);
  EXPECT_TRUE(tree.made->moves(0, 3));
  EXPECT_FALSE(tree.made->moves(1, 3));
  EXPECT_TRUE(tree.made->moves(1, 2));
  EXPECT_FALSE(tree.made->moves(2, 2));
}

TEST(JointTree, WhatIsNoTreeIsRefusedWithTheJoint) {
  const auto refused = [](auto change, ErrorCode code) {
    std::vector<Joint> joints = two_joint_arm();
    change(joints[1]);
    const Tree tree(joints, 2);
    ASSERT_FALSE(tree.made);
    EXPECT_EQ(tree.made.error().code, code);
    EXPECT_EQ(tree.made.error().axis, 1);
  };
  using J = Joint;
  refused([](J& joint) { joint.parent = 1; }, ErrorCode::out_of_range);
  refused([](J& joint) { joint.parent = 2; }, ErrorCode::out_of_range);
  refused([](J& joint) { joint.parent = -2; }, ErrorCode::out_of_range);
  refused([](J& joint) { joint.coordinate = 2; }, ErrorCode::out_of_range);
  refused([](J& joint) { joint.coordinate = -1; }, ErrorCode::out_of_range);
  refused([](J& joint) { joint.kind = JointKind::fixed; }, ErrorCode::out_of_range);
  refused([](J& joint) { joint.axis = {}; }, ErrorCode::out_of_range);
  refused([](J& joint) { joint.origin.position.x = 1e7; }, ErrorCode::out_of_range);
  refused([](J& joint) { joint.origin.rotation.z = {0, 0, -1}; }, ErrorCode::out_of_range);
  refused([](J& joint) { joint.factor = std::numeric_limits<double>::infinity(); }, ErrorCode::not_finite);
  refused([](J& joint) { joint.origin.rotation.y.z = std::nan(""); }, ErrorCode::not_finite);
}

TEST(JointTree, AMemoryThatIsTooSmallSaysWhatSuffices) {
  std::array<Joint, 2> memory;
  const std::vector<Joint> joints = two_joint_arm();
  const auto tree = JointTree::make(joints, 2, memory);
  ASSERT_FALSE(tree);
  EXPECT_EQ(tree.error().code, ErrorCode::capacity);
  EXPECT_EQ(tree.error().needed, 3);
  EXPECT_EQ(JointTree::make({}, 2, memory).error().code, ErrorCode::wrong_count);
}

TEST(JointTree, AValueThatCannotBeComputedNamesItsCoordinate) {
  const Tree arm(two_joint_arm(), 2);
  std::array<Pose, 3> poses;
  for (const double far : {1e9, -1e9, std::nan("")}) {
    const Status status = arm.made->poses(std::array{0.0, far}, poses);
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::out_of_range);
    EXPECT_EQ(status.error().axis, 1);
  }
}

}  // namespace joint_tree_test
}  // namespace inbetween
