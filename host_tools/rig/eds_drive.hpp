// A CiA 402 drive as its data sheet (EDS or DCF) describes it: what it lacks is known before anything is
// connected, and a simulated drive has its dictionary.
#pragma once

#include <string>
#include <vector>

#include "host_tools/rig_model/eds_file.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "inbetween/can/canopen_id.hpp"
#include "sim/object_dictionary.hpp"

namespace inbetween {

/// The dictionary of a drive with a data sheet, as node `node`. What the sheet leaves open is as in a drive
/// of the profile, within the limits of the sheet.
ObjectDictionary dictionary_of(const EdsFile& eds, can::NodeId node);

/// Each drive of the rig that has a data sheet is set up here as it will be on its bus. Throws InputError if
/// that fails: at the line of the object that is not as it must be. What somebody may have set in the drive
/// (1005, 6065, 607B) is not judged before it is connected. Returns the warnings of the sheets, each once.
std::vector<std::string> refuse_unfit_drives(const RigFile& rig);

}  // namespace inbetween
