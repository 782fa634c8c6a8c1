// A CiA 402 drive as its data sheet (EDS or DCF) describes it: what it lacks is known before anything is
// connected, and a simulated drive has its dictionary.
#pragma once

#include "host_tools/files/eds_file.hpp"
#include "host_tools/files/rig_file.hpp"
#include "sim/object_dictionary.hpp"

namespace inbetween {

/// The dictionary of a drive with a data sheet. Throws InputError at its lines.
ObjectDictionary dictionary_of(const EdsFile& eds);

/// Each drive of the rig that has a data sheet is set up here as it will be on its bus. Throws InputError if
/// that fails: at the line of the object that is not as it must be. What somebody may have set in the drive
/// (1005, 6065, 607B) is not judged before it is connected.
void refuse_unfit_drives(const RigFile& rig);

}  // namespace inbetween
