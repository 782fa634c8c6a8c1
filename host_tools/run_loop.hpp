// The motion loop as this program runs it.
#pragma once

#include "host_tools/rig_drives.hpp"
#include "host_tools/rig_lines.hpp"
#include "inbetween/motion_loop.hpp"

namespace inbetween {

using RunLoop = MotionLoop<double, RigDrives, RigLines>;

}  // namespace inbetween
