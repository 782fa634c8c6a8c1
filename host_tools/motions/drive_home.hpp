// An axis is homed by its drive.
#pragma once

#include <cstddef>

#include "host_tools/loop/rig_session.hpp"
#include "host_tools/reference/rig_reference.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

/// Lets the drive of an axis with a `drive_home` home it, in a session in which the rig has this axis alone:
/// no other drive is spoken to, and this one takes no targets from when it is set up until it is off again.
/// So nothing can be left to jump to. The emergency stop, the switches of the axis, the operator and every
/// fault that is found in motion halt it. At the end the reference has the position that the drive tells, or
/// that it is lost.
///
/// Throws what RigSession throws.
SetupEnd home_by_drive(const RigFile& rig, std::size_t axis, RigReference& reference,
                       const SessionOptions& options);

}  // namespace inbetween
