// Nuke's .chan: a row a frame: its number, position, angles in degrees, and for a camera the vertical angle
// of view.
//
// Source: nukescripts.import_boujou of Foundry (FRAME TX TY TZ RX RY RZ VFOV) and Blender's add-on
// io_anim_nuke_chan, which writes tabs, %f, and not the last frame of its range. The order of the angles, the
// unit of the position and the rate are not in the file. Nuke's y is up; the add-on writes Blender's z up
// too.
#pragma once

#include <string>
#include <string_view>

#include "host_tools/exchange/table_text.hpp"

namespace inbetween {

/// Lines that begin with # say nothing. Columns tx ty tz rx ry rz, and vfov where it is there. Throws
/// InputError at line and column. O(bytes).
BakedTable read_nuke_chan(std::string_view text, const std::string& file);

/// The columns tx ty tz rx ry rz, and vfov if there is one, from frame `first_frame` of the table or 1.
/// Throws InputError where one is missing, or an angle is not in degrees.
std::string write_nuke_chan(const BakedTable& table, const TableWriting& writing = {});

}  // namespace inbetween
