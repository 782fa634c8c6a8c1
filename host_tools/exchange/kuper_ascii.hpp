// Kuper ASCII: a line of axis names, then a row a camera frame.
//
// Sources: the part of Kuper's manual at michaelkarp.net, and KUPERIN.TXT. CRLF ends a line, numbers have
// four decimals; that blanks stand between columns is inferred, so commas are read as well. Whether a row is
// centred on the blurred image or on the closed shutter was chosen when it was saved, and is not in the file;
// nor are units and rate. The first row is the marker (LED) frame.
#pragma once

#include <string>
#include <string_view>

#include "host_tools/exchange/table_text.hpp"

namespace inbetween {

inline constexpr std::int32_t kuper_decimals = 4;

/// Throws InputError at line and column. O(bytes).
BakedTable read_kuper_ascii(std::string_view text, const std::string& file);

/// Throws InputError where the table cannot be written: a name has a comma in it, a line break or blanks at
/// an end.
std::string write_kuper_ascii(const BakedTable& table, const TableWriting& writing = {kuper_decimals});

}  // namespace inbetween
