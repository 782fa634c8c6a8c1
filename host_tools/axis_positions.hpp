// "pan=-20": axes by their names, and where they stand, from a command line.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/rig_file.hpp"

namespace inbetween {

/// The whole of `text` as a finite number.
std::optional<double> number_of(std::string_view text);

/// Of AXIS=POSITION each, said with `argument`. Throws UsageError.
std::map<std::string, double> positions_of(const std::vector<std::string>& texts,
                                           const std::string& argument = "--from");

/// The index of an axis of the rig. Throws InputError where there is none of that name.
std::size_t axis_named(const RigFile& rig, const std::string& name);

/// Where a simulated axis stands before anything moves it: as near to 0 as its limits allow.
double parked(const RigAxis& axis);

/// `positions`, in the order of the rig's axes, but where somebody has said that an axis stands elsewhere.
/// Throws InputError for a name that is no axis.
std::vector<double> standing_positions(const RigFile& rig, std::vector<double> positions,
                                       const std::map<std::string, double>& said);

}  // namespace inbetween
