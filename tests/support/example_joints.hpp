// The rigs of examples/arm/arm.urdf and examples/crane/crane.urdf, written again by hand: axes in degrees and
// mm.
#pragma once

#include <vector>

#include "tests/support/oracle_kinematics.hpp"

namespace inbetween {

std::vector<OracleJoint> joints_of_arm();
/// The joint of the plate follows the boom.
std::vector<OracleJoint> joints_of_crane();

}  // namespace inbetween
