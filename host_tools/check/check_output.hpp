// The report of a check, as a table, as JSON and as the data of a picture (check_plot.cpp). docs/formats.md
// describes the JSON.
#pragma once

#include <cstdio>

#include "host_tools/check/check.hpp"
#include "host_tools/check/check_frames.hpp"
#include "host_tools/plot/plot_limits.hpp"
#include "host_tools/text/json_writer.hpp"

namespace inbetween {

/// Prints a row for each quantity of each axis, the first 20 steps, and the verdict as the last line.
void print_check(const Plan& plan, const CheckReport& report, const SmallestFrames& smallest, std::FILE* out);

/// Writes the members of the JSON object, version 1 of the format, into an object that is open.
void write_check(JsonWriter& json, const Plan& plan, const CheckReport& report,
                 const SmallestFrames& smallest);

/// The data that draw_limits_plot shows. Samples are dense, and closer around each peak.
LimitsPlot limits_plot_of(const Plan& plan, const CheckReport& report);

}  // namespace inbetween
