// The axes of a rig by their names, and where they stand before anything moves.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

/// The index of an axis of the rig. Throws InputError where there is none of that name.
std::size_t axis_named(const RigFile& rig, const std::string& name);

/// The place of a simulated axis before anything moves it: as near to 0 as its limits allow.
double parked(const RigAxis& axis);

/// `positions`, in the order of the rig's axes, but where somebody has said that an axis stands elsewhere.
/// Throws InputError for a name that is no axis.
std::vector<double> standing_positions(const RigFile& rig, std::vector<double> positions,
                                       const std::map<std::string, double>& said);

}  // namespace inbetween
