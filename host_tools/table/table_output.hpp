// A trajectory table as JSON and as a C header. docs/formats.md describes both.
#pragma once

#include <cstdio>
#include <string>
#include <string_view>

#include "host_tools/table/trajectory_table.hpp"

namespace inbetween {

/// Version 1 of the format.
void write_table_json(const TrajectoryTable& table, std::FILE* file);

/// Version 1 of the header: C99 and C++, that stands alone. What it defines begins with `name`, which is a
/// name of C (table_name_of). Numbers read back exactly.
void write_table_header(const TrajectoryTable& table, std::string_view name, std::FILE* file);

/// The beginning of the names that the header in a file defines: the file's name without folder and ending,
/// with '_' for what a name of C cannot have, and in front of a digit. The table is NAME_table, since NAME
/// alone may be a word of C.
std::string table_name_of(const std::string& file);

}  // namespace inbetween
