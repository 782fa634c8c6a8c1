// Reads what lies between the axes of a rig and their motors.
#pragma once

#include "host_tools/rig_model/rig_drive_reader.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/text/toml_value.hpp"

namespace inbetween {

/// Reads `offset`, `calibration` and `backlash` of an axis whose limits have been read.
void read_gear(const TomlTable& table, RigAxis& axis);

/// Reads `ganged` and `max_skew` of an axis whose first drive has been read.
void read_ganged(const TomlTable& table, RigAxis& axis, const RigContext& rig);

/// Lowers the limits of an axis without a calibration by what the take-up of its backlash needs.
void leave_room_for_backlash(RigAxis& axis);

}  // namespace inbetween
