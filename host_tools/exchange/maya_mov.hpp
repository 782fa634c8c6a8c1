// Maya's channel move (.mov): a row a frame, a column a channel, blanks or tabs between.
//
// Source: Autodesk Maya 2011, "Channel move files", movIn and movOut. Comment lines at the top may list the
// attributes; that they begin with # is inferred. Names, units, rate and start time are not in the file: both
// sides set the same units, which are cm and degrees where nobody changed them.
#pragma once

#include <string>
#include <string_view>

#include "host_tools/exchange/table_text.hpp"

namespace inbetween {

/// Whether a file is a film of QuickTime, which has the same extension.
bool is_quicktime(std::string_view bytes);

/// Throws InputError at line and column; a film is refused at the file. O(bytes).
BakedTable read_maya_mov(std::string_view text, const std::string& file);

/// Comment lines name the columns. Throws InputError where the table cannot be written.
std::string write_maya_mov(const BakedTable& table, const TableWriting& writing = {});

}  // namespace inbetween
