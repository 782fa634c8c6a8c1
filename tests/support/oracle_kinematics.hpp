// Articulated trees by Orocos KDL: poses, Jacobians and motion of links, to compare with.
#pragma once

#include <array>
#include <memory>
#include <vector>

namespace inbetween {

enum class OracleJointKind { fixed, revolute, prismatic };

/// A link on its parent (-1: the world); the value of its joint is factor * coordinate + offset (rad or m).
struct OracleJoint {
  OracleJointKind kind = OracleJointKind::fixed;
  int parent = -1;
  int coordinate = -1;
  double factor = 1;
  double offset = 0;
  std::array<double, 3> xyz = {};  // m
  std::array<double, 3> rpy = {};  // rad, about the fixed x, then y, then z
  std::array<double, 3> axis = {0, 0, 1};
};

struct OraclePose {
  std::array<double, 3> position{};
  std::array<std::array<double, 3>, 3> columns{};  // the axes of the link in the world
};

/// Linear, then angular.
using OracleTwist = std::array<double, 6>;

struct OracleLinkMotion {
  OracleTwist velocity{};
  OracleTwist acceleration{};
};

class OracleTree {
 public:
  explicit OracleTree(const std::vector<OracleJoint>& joints);
  ~OracleTree();
  OracleTree(const OracleTree&) = delete;
  OracleTree& operator=(const OracleTree&) = delete;

  [[nodiscard]] OraclePose pose(int link, const std::vector<double>& coordinates) const;
  /// A column for each coordinate.
  [[nodiscard]] std::vector<OracleTwist> jacobian(int link, const std::vector<double>& coordinates) const;
  [[nodiscard]] OracleLinkMotion motion(int link, const std::vector<double>& coordinates,
                                        const std::vector<double>& velocities,
                                        const std::vector<double>& accelerations) const;

 private:
  struct Kdl;
  std::vector<OracleJoint> joints_;
  std::unique_ptr<Kdl> kdl_;
};

}  // namespace inbetween
