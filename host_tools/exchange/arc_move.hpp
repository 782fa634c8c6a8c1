// A Dragonframe Arc move (.arcm) as a table, and a table as such a move; the axes of a scene (.arcx) as a
// rig.
//
// arc_scene.hpp says where the format comes from.
#pragma once

#include <string>
#include <string_view>

#include "host_tools/exchange/arc_scene.hpp"
#include "host_tools/exchange/table_text.hpp"

namespace inbetween {

/// A row for each whole frame from that of the first point to that of the last one, in frames of the file.
/// Axes without points have no motion, and are a warning; so is an axis whose curve begins later or ends
/// earlier. Dragonframe's own curve between two points may differ a little, and on points it does not. Throws
/// InputError as read_arc_scene does, and where no axis has points. O(bytes + rows * axes).
BakedTable read_arc_move(std::string_view text, const std::string& file);

/// A point on each frame, from `first_frame` of the table or 1. The curve between two is the cubic whose
/// slope on a point is half the way between its neighbours, so that speed does not step. Throws InputError
/// where a unit is none of m, cm, mm, in, deg.
std::string write_arc_move(const BakedTable& table, const TableWriting& writing = {});

/// The axes of a scene as a rig file. What a scene does not say stands there as a comment with a question,
/// and the rig is refused until it is answered: unit, range, and limits (those of the scene are in steps a
/// second, and apply to Dragonframe's own ramps). `rate_hz` is of the rig. Throws InputError where a number
/// is none.
std::string rig_of_arc_scene(const ArcScene& scene, std::int32_t rate_hz);

}  // namespace inbetween
