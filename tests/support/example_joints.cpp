#include "tests/support/example_joints.hpp"

namespace inbetween {
namespace {

constexpr double degree = 0.017453292519943295;

}  // namespace

std::vector<OracleJoint> joints_of_arm() {
  using Kind = OracleJointKind;
  return {{.kind = Kind::revolute, .parent = -1, .coordinate = 0, .factor = degree},
          {.kind = Kind::revolute, .parent = 0, .coordinate = 1, .factor = degree, .xyz = {0.3, 0, 0}},
          {.kind = Kind::fixed, .parent = 1, .xyz = {0.25, 0, 0}}};
}

std::vector<OracleJoint> joints_of_crane() {
  using Kind = OracleJointKind;
  return {{.kind = Kind::prismatic, .parent = -1, .coordinate = 0, .factor = 1e-3, .axis = {1, 0, 0}},
          {.kind = Kind::revolute, .parent = 0, .coordinate = 1, .factor = degree, .xyz = {0, 0, 0.4}},
          {.kind = Kind::revolute,
           .parent = 1,
           .coordinate = 2,
           .factor = degree,
           .xyz = {0, 0, 0.9},
           .axis = {0, -1, 0}},
          {.kind = Kind::revolute,
           .parent = 2,
           .coordinate = 2,
           .factor = -degree,
           .xyz = {2.5, 0, 0},
           .axis = {0, -1, 0}},
          {.kind = Kind::revolute, .parent = 3, .coordinate = 3, .factor = degree, .xyz = {0.2, 0, -0.25}},
          {.kind = Kind::revolute, .parent = 4, .coordinate = 4, .factor = degree, .axis = {0, -1, 0}},
          {.kind = Kind::revolute, .parent = 5, .coordinate = 5, .factor = degree, .axis = {1, 0, 0}},
          {.kind = Kind::fixed, .parent = 6, .xyz = {0.1, 0, 0}}};
}

}  // namespace inbetween
