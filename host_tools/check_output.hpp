// What a check has found, as a table, as JSON and as the data of a picture. docs/formats.md describes the
// JSON.
#pragma once

#include <cstdio>

#include "host_tools/check.hpp"
#include "host_tools/check_frames.hpp"
#include "host_tools/plot_limits.hpp"

namespace inbetween {

/// A row for each quantity of each axis, the steps (the first 20 of them), and the verdict as the last line.
void print_check(const Plan& plan, const CheckReport& report, const SmallestFrames& smallest, std::FILE* out);

/// Version 1 of the format.
void write_check_json(const CheckReport& report, const SmallestFrames& smallest, std::FILE* file);

/// What draw_limits_plot shows. Samples are dense, and closer around each peak.
LimitsPlot limits_plot_of(const Plan& plan, const CheckReport& report);

}  // namespace inbetween
