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

/// How the camera stands on a tip that looks along x with z up.
inline OraclePose camera_of(const OraclePose& tip) {
  OraclePose camera = tip;
  for (std::size_t i = 0; i < 3; ++i) {
    camera.columns[0][i] = -tip.columns[1][i];
    camera.columns[1][i] = tip.columns[2][i];
    camera.columns[2][i] = -tip.columns[0][i];
  }
  return camera;
}

/// The same place where y is up.
inline OraclePose in_y_up(const OraclePose& pose) {
  const auto turned = [](const std::array<double, 3>& v) { return std::array<double, 3>{v[0], v[2], -v[1]}; };
  OraclePose out{.position = turned(pose.position)};
  for (std::size_t i = 0; i < 3; ++i) out.columns[i] = turned(pose.columns[i]);
  return out;
}

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
