#pragma once

#include "inbetween/can/canopen_id.hpp"
#include "sim/object_dictionary.hpp"

namespace inbetween {

/// The objects of a simulated CiA 402 drive as it leaves the factory: four PDOs each way, of which none is as
/// the host wants it, no heartbeat, profile position mode.
ObjectDictionary factory_objects(can::NodeId node);

}  // namespace inbetween
