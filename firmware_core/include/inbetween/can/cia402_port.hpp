#pragma once

#include "inbetween/base/precision.hpp"
#include "inbetween/can/bus_port.hpp"
#include "inbetween/can/cia402_bus.hpp"

/// CiA 402 drives as the drives of a rig.

namespace inbetween::can {

template <FrameLink<Frame> Link>
using Cia402Lane = BusLane<Cia402Bus, Link>;
using Cia402Axis = BusAxis<Cia402Bus>;
template <FrameLink<Frame> Link>
using Cia402Port = BusPort<Cia402Bus, Link>;

}  // namespace inbetween::can
