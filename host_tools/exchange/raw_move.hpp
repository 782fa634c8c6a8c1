// Dragonframe's Raw Move (.txt): a row a frame, a column an axis, and nothing else.
//
// Source: what BlenderMoco (Defaultio, MoCoExportAddon.py) writes and Dragonframe reads; no grammar is
// public. The file has no names, units, frame numbers or rate; its first row is the first frame of the move.
#pragma once

#include <string>
#include <string_view>

#include "host_tools/exchange/table_text.hpp"

namespace inbetween {

/// Throws InputError at line and column. O(bytes).
BakedTable read_raw_move(std::string_view text, const std::string& file);

/// Columns of 16 characters, as BlenderMoco writes them, but never cut: a number that is longer makes its
/// column longer. Throws InputError where the table cannot be written.
std::string write_raw_move(const BakedTable& table, const TableWriting& writing = {});

}  // namespace inbetween
