// The report of a check, as a table and as JSON. docs/formats.md describes the JSON.
#pragma once

#include <cstdio>

#include "host_tools/check/check.hpp"
#include "host_tools/check/check_frames.hpp"
#include "host_tools/text/json_writer.hpp"

namespace inbetween {

/// Prints a row for each quantity of each axis, the first 20 steps, and the verdict as the last line.
void print_check(const Plan& plan, const CheckReport& report, const SmallestFrames& smallest, std::FILE* out);

/// Writes the members of the JSON object, version 1 of the format, into an object that is open.
void write_check(JsonWriter& json, const Plan& plan, const CheckReport& report,
                 const SmallestFrames& smallest);

}  // namespace inbetween
