// The motion loop as this program runs it.
#pragma once

#include "host_tools/rig/gpio_inputs.hpp"
#include "host_tools/rig/rig_drives.hpp"
#include "inbetween/loop/motion_loop.hpp"

namespace inbetween {

using RunLoop = MotionLoop<RigDrives, RigInputs>;

}  // namespace inbetween
