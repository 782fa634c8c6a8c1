// The JSON of blender-servo-animation: a whole number for each servo and frame.
//
// Source: timhendriks93/blender-servo-animation, addon/ops/json_export.py and its examples. Two shapes are
// read: `servos` with the positions of each, and `positions` with the servos of each frame. A position counts
// in what the servo counts in (pulse lengths, ticks): what that is in degrees, and the first frame, are not
// in the file.
#pragma once

#include <string>
#include <string_view>

#include "host_tools/exchange/baked_table.hpp"

namespace inbetween {

inline constexpr std::int64_t max_servo_id = 254;
inline constexpr std::int64_t max_servo_position = 1'000'000'000;  // in either direction

/// Throws InputError at line and column: where `frames`, `bones` or `seconds` say another number than there
/// are, a servo is missing on a frame, or a position is no whole number.
BakedTable read_servo_json(std::string_view text, const std::string& file);

/// By servo. Positions are rounded to whole numbers. A column without a channel gets the lowest number that
/// is free. Throws InputError where the rate is no whole number, or a position is too large.
std::string write_servo_json(const BakedTable& table);

}  // namespace inbetween
