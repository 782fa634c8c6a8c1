#include "tests/support/oracle_kinematics.hpp"

#include <algorithm>
#include <cstddef>
#include <kdl/chain.hpp>
#include <kdl/chainjnttojacdotsolver.hpp>
#include <kdl/jntarrayvel.hpp>
#include <kdl/tree.hpp>
#include <kdl/treefksolverpos_recursive.hpp>
#include <kdl/treejnttojacsolver.hpp>
#include <stdexcept>
#include <string>

namespace inbetween {
namespace {

void require(bool holds, const char* what) {
  if (!holds) throw std::logic_error(std::string("KDL: ") + what);
}

KDL::Vector vector_of(const std::array<double, 3>& v) {
  return {v[0], v[1], v[2]};
}

std::string link_name(int link) {
  return link == -1 ? "world" : "link" + std::to_string(link);
}

KDL::Segment segment_of(const OracleJoint& joint, int link) {
  const KDL::Frame origin(KDL::Rotation::RPY(joint.rpy[0], joint.rpy[1], joint.rpy[2]), vector_of(joint.xyz));
  const std::string name = "joint" + std::to_string(link);
  if (joint.kind == OracleJointKind::fixed) return KDL::Segment(link_name(link), KDL::Joint(name), origin);
  const auto kind = joint.kind == OracleJointKind::revolute ? KDL::Joint::RotAxis : KDL::Joint::TransAxis;
  return KDL::Segment(link_name(link), KDL::Joint(name, origin.p, origin.M * vector_of(joint.axis), kind),
                      origin);
}

OracleTwist twist_of(const KDL::Twist& twist) {
  OracleTwist numbers{};
  for (int i = 0; i < 6; ++i) numbers.at(static_cast<std::size_t>(i)) = twist(i);
  return numbers;
}

}  // namespace

struct OracleTree::Kdl {
  // KDL's solvers keep a copy, and copying a tree numbers its joints anew, branch by branch. A copy of a copy
  // keeps the numbers, so this is one.
  KDL::Tree tree;

  explicit Kdl(const KDL::Tree& original) : tree(original) {}

  [[nodiscard]] unsigned place_of(int link) const {
    return GetTreeElementQNr(tree.getSegment(link_name(link))->second);
  }
};

OracleTree::OracleTree(const std::vector<OracleJoint>& joints) : joints_(joints) {
  KDL::Tree tree("world");
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const int link = static_cast<int>(i);
    require(tree.addSegment(segment_of(joints[i], link), link_name(joints[i].parent)), "addSegment");
  }
  // KDL looks at the first joint value of a fixed link too, so there is to be one.
  require(tree.addSegment(segment_of({.kind = OracleJointKind::revolute}, -2), link_name(-1)), "addSegment");
  kdl_ = std::make_unique<Kdl>(tree);
}

OracleTree::~OracleTree() = default;

namespace {

/// One number for each of KDL's joints; those that are fixed have none.
template <class Number>
KDL::JntArray joint_values(const std::vector<OracleJoint>& joints, const KDL::Tree& tree, Number number) {
  KDL::JntArray values(tree.getNrOfJoints());  // zeros
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (joints[i].kind == OracleJointKind::fixed) continue;
    const auto& element = tree.getSegment(link_name(static_cast<int>(i)))->second;
    values(GetTreeElementQNr(element)) = number(joints[i]);
  }
  return values;
}

KDL::JntArray positions_of(const std::vector<OracleJoint>& joints, const KDL::Tree& tree,
                           const std::vector<double>& coordinates) {
  return joint_values(joints, tree, [&](const OracleJoint& joint) {
    return joint.factor * coordinates.at(static_cast<std::size_t>(joint.coordinate)) + joint.offset;
  });
}

}  // namespace

OraclePose OracleTree::pose(int link, const std::vector<double>& coordinates) const {
  KDL::TreeFkSolverPos_recursive solver(kdl_->tree);
  KDL::Frame frame;
  require(solver.JntToCart(positions_of(joints_, kdl_->tree, coordinates), frame, link_name(link)) >= 0,
          "JntToCart");
  OraclePose pose;
  for (int row = 0; row < 3; ++row) {
    const auto r = static_cast<std::size_t>(row);
    pose.position.at(r) = frame.p(row);
    for (int column = 0; column < 3; ++column) {
      pose.columns.at(static_cast<std::size_t>(column)).at(r) = frame.M(row, column);
    }
  }
  return pose;
}

std::vector<OracleTwist> OracleTree::jacobian(int link, const std::vector<double>& coordinates) const {
  KDL::TreeJntToJacSolver solver(kdl_->tree);
  KDL::Jacobian jacobian(kdl_->tree.getNrOfJoints());
  require(solver.JntToJac(positions_of(joints_, kdl_->tree, coordinates), jacobian, link_name(link)) >= 0,
          "JntToJac");
  std::vector<OracleTwist> columns(coordinates.size());
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    if (joints_[i].kind == OracleJointKind::fixed) continue;
    const OracleTwist column = twist_of(jacobian.getColumn(kdl_->place_of(static_cast<int>(i))));
    OracleTwist& sum = columns.at(static_cast<std::size_t>(joints_[i].coordinate));
    for (std::size_t row = 0; row < 6; ++row) sum.at(row) += joints_[i].factor * column.at(row);
  }
  return columns;
}

OracleLinkMotion OracleTree::motion(int link, const std::vector<double>& coordinates,
                                    const std::vector<double>& velocities,
                                    const std::vector<double>& accelerations) const {
  // Along the branch alone: J qdd + (dJ/dt) qd.
  KDL::Chain chain;
  require(kdl_->tree.getChain("world", link_name(link), chain), "getChain");
  KDL::JntArrayVel state(chain.getNrOfJoints());
  KDL::JntArray second(chain.getNrOfJoints());
  std::vector<int> branch;
  for (int i = link; i >= 0; i = joints_[static_cast<std::size_t>(i)].parent) branch.push_back(i);
  std::ranges::reverse(branch);
  unsigned place = 0;
  for (const int i : branch) {
    const OracleJoint& joint = joints_[static_cast<std::size_t>(i)];
    if (joint.kind == OracleJointKind::fixed) continue;
    const auto c = static_cast<std::size_t>(joint.coordinate);
    state.q(place) = joint.factor * coordinates.at(c) + joint.offset;
    state.qdot(place) = joint.factor * velocities.at(c);
    second(place) = joint.factor * accelerations.at(c);
    ++place;
  }
  OracleLinkMotion motion;
  if (place == 0) return motion;
  KDL::ChainJntToJacDotSolver dot_solver(chain);
  KDL::ChainJntToJacSolver solver(chain);
  KDL::Jacobian jacobian(place);
  KDL::Twist bias;
  require(solver.JntToJac(state.q, jacobian) >= 0, "JntToJac");
  require(dot_solver.JntToJacDot(state, bias) >= 0, "JntToJacDot");
  KDL::Twist first;
  KDL::Twist last;
  KDL::MultiplyJacobian(jacobian, state.qdot, first);
  KDL::MultiplyJacobian(jacobian, second, last);
  motion.velocity = twist_of(first);
  motion.acceleration = twist_of(last + bias);
  return motion;
}

}  // namespace inbetween
