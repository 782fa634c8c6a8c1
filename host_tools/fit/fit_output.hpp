// The result of a fit, for people, as JSON and in the picture of the limits (fit_plot.cpp). docs/formats.md
// describes the JSON.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include "host_tools/fit/speed_fit.hpp"
#include "host_tools/plot/plot_limits.hpp"
#include "host_tools/text/json_writer.hpp"

namespace inbetween {

/// Writes the member "fit" into the JSON object of a check. `frames` are those of the fitted move.
void write_fit(JsonWriter& json, const SpeedFit& fit, std::int32_t frames);

/// Prints what the fit changed and where. Prints nothing if it found no curve. `file` is the name of the file
/// with the new curve, and `frames` are its frames.
void print_fit(const Plan& plan, const SpeedFit& fit, std::int32_t frames, const std::string& file,
               std::FILE* out);

/// Adds a row for each track that the fit has changed: `before` is the plan as drawn, `after` the fitted one,
/// of which `plot` is.
void add_fitted_curves(const Plan& before, const Plan& after, const SpeedFit& fit, LimitsPlot& plot);

}  // namespace inbetween
