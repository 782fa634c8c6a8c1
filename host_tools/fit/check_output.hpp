// What a check has found, as a table, as JSON and as the data of a picture. docs/formats.md describes the
// JSON.
#pragma once

#include <cstdio>
#include <optional>
#include <string>

#include "host_tools/check/check.hpp"
#include "host_tools/check/check_frames.hpp"
#include "host_tools/fit/speed_fit.hpp"
#include "host_tools/plot/plot_limits.hpp"

namespace inbetween {

/// A row for each quantity of each axis, the steps (the first 20 of them), and the verdict as the last line.
void print_check(const Plan& plan, const CheckReport& report, const SmallestFrames& smallest, std::FILE* out);

/// Version 1 of the format. With a fit it has one field more.
void write_check_json(const CheckReport& report, const SmallestFrames& smallest,
                      const std::optional<SpeedFit>& fit, std::FILE* file);

/// For people: what the fit changed and where, or why there is none.
void print_fit(const Plan& plan, const SpeedFit& fit, const std::string& file, std::FILE* out);

/// What draw_limits_plot shows. Samples are dense, and closer around each peak.
LimitsPlot limits_plot_of(const Plan& plan, const CheckReport& report);

}  // namespace inbetween
