// A rig whose joints are given as the oracle of kinematics takes them.
#pragma once

#include <vector>

#include "host_tools/joints/kinematics.hpp"
#include "tests/support/oracle_kinematics.hpp"

namespace inbetween {

/// Coordinate i is an axis in rad or m. The first joint with a coordinate has it to itself, with factor 1;
/// joints behind it mimic that one. Link i of the oracle is link i + 1 here.
Kinematics kinematics_of(const std::vector<OracleJoint>& joints);

}  // namespace inbetween
