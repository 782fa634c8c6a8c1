// Trees of joints against Orocos KDL, an independent library.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "inbetween/joints/joint_tree.hpp"
#include "tests/support/oracle_kinematics.hpp"
#include "tests/support/property.hpp"

namespace inbetween {
namespace joint_tree_property_test {

constexpr std::size_t max_links = 20;

double between(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

int index_below(std::mt19937_64& random, int count) {
  return std::uniform_int_distribution<int>(0, count - 1)(random);
}

/// A tree whose joints are of every kind, some of them following the coordinate of another.
std::vector<OracleJoint> random_tree(std::mt19937_64& random, int& coordinate_count) {
  std::vector<OracleJoint> joints(1 + static_cast<std::size_t>(index_below(random, max_links)));
  coordinate_count = 0;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    OracleJoint& joint = joints[i];
    // Long branches are as frequent as bushes.
    const int links = static_cast<int>(i);
    joint.parent = index_below(random, 2) == 0 ? links - 1 : index_below(random, links + 1) - 1;
    joint.kind = static_cast<OracleJointKind>(index_below(random, 3));
    for (double& x : joint.xyz) x = between(random, -2, 2);
    for (double& angle : joint.rpy) angle = between(random, -std::numbers::pi, std::numbers::pi);
    if (joint.kind == OracleJointKind::fixed) continue;
    do {
      for (double& x : joint.axis) x = between(random, -1, 1);
    } while (std::hypot(joint.axis[0], joint.axis[1], joint.axis[2]) < 0.1);
    const bool mimics = coordinate_count > 0 && index_below(random, 5) == 0;
    joint.coordinate = mimics ? index_below(random, coordinate_count) : coordinate_count++;
    joint.factor = between(random, -2, 2);
    joint.offset = between(random, -1, 1);
  }
  return joints;
}

Vector3 vector_of(const std::array<double, 3>& v) {
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

Joint joint_of(const OracleJoint& from) {
  const auto turned = [&](const Vector3& axis, double angle) {
    return turned_about(axis, sine_cosine(static_cast<double>(angle)));
  };
  const Rotation3 rotation =
      turned({0, 0, 1}, from.rpy[2]) * turned({0, 1, 0}, from.rpy[1]) * turned({1, 0, 0}, from.rpy[0]);
  return {.kind = static_cast<JointKind>(from.kind),
          .parent = from.parent,
          .coordinate = from.coordinate,
          .factor = static_cast<double>(from.factor),
          .offset = static_cast<double>(from.offset),
          .origin = {rotation, vector_of(from.xyz)},
          .axis = vector_of(from.axis)};
}

double error(const Vector3& found, const double* expected) {
  return std::max({std::fabs(static_cast<double>(found.x) - expected[0]),
                   std::fabs(static_cast<double>(found.y) - expected[1]),
                   std::fabs(static_cast<double>(found.z) - expected[2])});
}

struct Errors {
  double position = 0, rotation = 0, jacobian = 0, velocity = 0, acceleration = 0;
};

/// The largest difference of any link of one random tree in one random state.
class Comparison {
 public:
  explicit Comparison(std::uint64_t seed) : random_(seed) {
    int count = 0;
    oracle_joints_ = random_tree(random_, count);
    for (const OracleJoint& joint : oracle_joints_) joints_.push_back(joint_of(joint));
    for (int i = 0; i < count; ++i) {
      q_.push_back(between(random_, -4, 4));
      first_.push_back(between(random_, -3, 3));
      second_.push_back(between(random_, -3, 3));
      state_.push_back({static_cast<double>(q_.back()), static_cast<double>(first_.back()),
                        static_cast<double>(second_.back())});
      coordinates_.push_back(static_cast<double>(q_.back()));
    }
  }

  Errors run() {
    JointStorage<max_links> memory{};
    const auto tree = JointTree::make(joints_, static_cast<std::int32_t>(q_.size()), memory);
    RC_ASSERT(tree.has_value());
    std::vector<Pose> poses(joints_.size());
    std::vector<LinkMotion> motion(joints_.size());
    RC_ASSERT(tree->poses(coordinates_, poses).has_value());
    RC_ASSERT(tree->motion(state_, motion).has_value());
    const OracleTree oracle(oracle_joints_);
    Errors errors;
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      compare(*tree, oracle, static_cast<int>(i), poses, errors);
      compare(oracle, static_cast<int>(i), motion[i], poses[i], errors);
    }
    return errors;
  }

 private:
  static void raise(double& largest, double error) { largest = std::max(largest, error); }

  void compare(const JointTree& tree, const OracleTree& oracle, int link, const std::vector<Pose>& poses,
               Errors& errors) const {
    const OraclePose expected = oracle.pose(link, q_);
    const Pose& pose = poses[static_cast<std::size_t>(link)];
    raise(errors.position, error(pose.position, expected.position.data()));
    raise(errors.rotation, error(pose.rotation.x, expected.columns[0].data()));
    raise(errors.rotation, error(pose.rotation.y, expected.columns[1].data()));
    raise(errors.rotation, error(pose.rotation.z, expected.columns[2].data()));
    std::vector<JacobianColumn> columns(q_.size());
    tree.jacobian(link, poses, columns);
    const std::vector<OracleTwist> expected_columns = oracle.jacobian(link, q_);
    for (std::size_t c = 0; c < columns.size(); ++c) {
      raise(errors.jacobian, error(columns[c].linear, expected_columns[c].data()));
      raise(errors.jacobian, error(columns[c].angular, expected_columns[c].data() + 3));
    }
  }

  void compare(const OracleTree& oracle, int link, const LinkMotion& motion, const Pose& pose,
               Errors& errors) const {
    const OracleLinkMotion expected = oracle.motion(link, q_, first_, second_);
    RC_ASSERT(motion.pose == pose);
    raise(errors.velocity, error(motion.velocity, expected.velocity.data()));
    raise(errors.velocity, error(motion.angular_velocity, expected.velocity.data() + 3));
    raise(errors.acceleration, error(motion.acceleration, expected.acceleration.data()));
    raise(errors.acceleration, error(motion.angular_acceleration, expected.acceleration.data() + 3));
  }

  std::mt19937_64 random_;
  std::vector<OracleJoint> oracle_joints_;
  std::vector<Joint> joints_;
  std::vector<double> q_, first_, second_;
  std::vector<double> coordinates_;
  std::vector<CoordinateMotion> state_;
};

/// Positions and Jacobians reach some 60 m here, velocities 1e3 m/s and accelerations 1e4 m/s^2.
TEST(JointTreeProperty, PosesJacobiansAndMotionAreThoseOfKdl) {
  Errors worst;
  check_property(10'000, [&](std::uint64_t seed) {
    const Errors errors = Comparison(seed).run();
    RC_ASSERT(errors.position <= 1e-9);
    RC_ASSERT(errors.rotation <= 1e-12);
    RC_ASSERT(errors.jacobian <= 1e-9);
    RC_ASSERT(errors.velocity <= 1e-9);
    RC_ASSERT(errors.acceleration <= 1e-7);
    worst.position = std::max(worst.position, errors.position);
    worst.jacobian = std::max(worst.jacobian, errors.jacobian);
    worst.velocity = std::max(worst.velocity, errors.velocity);
    worst.acceleration = std::max(worst.acceleration, errors.acceleration);
  });
  std::cout << "largest differences: position " << worst.position << " m, Jacobian " << worst.jacobian
            << ", velocity " << worst.velocity << ", acceleration " << worst.acceleration << "\n";
}

}  // namespace joint_tree_property_test
}  // namespace inbetween
