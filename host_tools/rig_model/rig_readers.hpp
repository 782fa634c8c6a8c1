// The parts of the reader of a rig: its drives, what lies between its axes and their motors, homes.
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>

#include "host_tools/rig_model/gpio_line_reader.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/text/toml_value.hpp"

namespace inbetween {

/// The names and addresses that are taken already, each with the words that say by whom.
using Taken = std::map<std::string, Place>;

/// Throws InputError at `value` if `what` is taken already.
void take(Taken& taken, const TomlValue& value, const std::string& what, std::string_view remedy);

/// The part of the rig that the reader of an axis needs.
struct RigContext {
  std::span<const Bus> buses;
  Taken& taken;
  TakenLines& lines;
};

/// Reads the table `drive` of an axis whose limits have been read.
Drive read_drive(const TomlValue& value, const RigAxis& axis, const RigContext& rig);

// rig_gear_reader.cpp

/// Reads `offset`, `calibration` and `backlash` of an axis whose limits have been read.
void read_gear(const TomlTable& table, RigAxis& axis);

/// Reads `ganged` and `max_skew` of an axis whose first drive has been read.
void read_ganged(const TomlTable& table, RigAxis& axis, const RigContext& rig);

/// Lowers the limits of an axis without a calibration by what the take-up of its backlash needs.
void leave_room_for_backlash(RigAxis& axis);

// rig_home_reader.cpp

/// Reads `home` of an axis whose drive and gear have been read: by a switch, or by the drive itself.
void read_home_of_axis(const TomlValue& home, RigAxis& axis, TakenLines& lines);

}  // namespace inbetween
