// One axis of a rig, used as if the rig had no other.
#pragma once

#include <cstddef>
#include <functional>

#include "host_tools/loop/rig_session.hpp"
#include "host_tools/reference/rig_reference.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

/// The rig as far as this axis needs it: no other drive is opened or spoken to. Its switches and the
/// emergency stop stay.
RigFile lone_axis(const RigFile& rig, std::size_t axis);

/// The options of a session of that rig: where the axis stands in a simulation, and the faults of its drive.
SessionOptions lone_axis_options(const SessionOptions& options, const RigFile& rig, std::size_t axis,
                                 const RigReference& reference);

/// Does the task with axis 0 of a session of lone_axis(), which is an axis that does not know where it is: it
/// stays so, and nothing is kept. A drive that has power holds what it is told, and one that nobody has asked
/// where it stands may jump there: therefore the other drives get none. SetupEnd::positions are those of
/// `rig`, 0 for the others. Throws what RigSession throws.
SetupEnd use_alone(const RigFile& rig, std::size_t axis, const RigReference& reference,
                   const SessionOptions& options,
                   const std::function<SetupEnd(RigSession&, RigReference&)>& task);

}  // namespace inbetween
