// The units in which a move may count, and what they are in the units of a rig.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

enum class MoveUnit : std::uint8_t { of_rig, mm, cm, m, inch, ft, deg, rad, turn };

/// As written in a file; the first is MoveUnit::mm.
inline constexpr std::array<std::string_view, 8> move_unit_words = {"mm", "cm",  "m",   "in",
                                                                    "ft", "deg", "rad", "turn"};
std::string_view to_string(MoveUnit unit);

/// of_rig where the axis counts in "unit".
MoveUnit as_move_unit(AxisUnit unit);

/// A position in the unit of an axis; nothing where one is a length and the other is not.
std::optional<double> converted(double position, MoveUnit from, AxisUnit to);

/// The unit in which an axis counts without a rig: that itself if a rig may have it, otherwise mm.
AxisUnit nearest_axis_unit(MoveUnit unit);

}  // namespace inbetween
