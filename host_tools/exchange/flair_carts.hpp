// Flair's Cartesian points (MRMC, CARTS_RAW): where the camera is and at what it looks, a row a frame.
//
// Source: the reader and writer of a Blender add-on, whose author cites Mark Roberts' manual. XV YV ZV is the
// camera, XT YT ZT the point at which it looks, in cm or m with z up; ROLL is in degrees; SPEED is the rate.
// Where in the exposure a row is, is not in the file: the add-on's author says that it is the frame boundary.
#pragma once

#include <string>
#include <string_view>

#include "host_tools/exchange/table_text.hpp"

namespace inbetween {

inline constexpr std::int32_t flair_decimals = 5;

/// Lines that begin with # say nothing. Columns go by their headings, in any order, and more than those of
/// the format are kept. What stands behind POINTS rows is a warning. A comma may stand behind a number, and
/// not in it. Throws InputError at line and column. O(bytes).
BakedTable read_flair_carts(std::string_view text, const std::string& file);

/// The columns XV YV ZV XT YT ZT ROLL, from frame `first_frame` of the table or 1. A rate that is no whole
/// number is written as a decimal, which is not exact, and is asked again. Throws InputError where a column
/// or the rate is missing, where z is not up, or where the positions are not all in cm or all in m.
std::string write_flair_carts(const BakedTable& table, const TableWriting& writing = {flair_decimals});

}  // namespace inbetween
