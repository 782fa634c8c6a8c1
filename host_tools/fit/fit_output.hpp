// The result of a fit, for people and as JSON. docs/formats.md describes the JSON.
#pragma once

#include <cstdio>
#include <string>

#include "host_tools/files/json_writer.hpp"
#include "host_tools/fit/speed_fit.hpp"

namespace inbetween {

/// Writes the member "fit" into the JSON object of a check.
void write_fit(JsonWriter& json, const SpeedFit& fit);

/// Prints what the fit changed and where. Prints nothing if it found no curve. `file` is the name of the file
/// with the new curve.
void print_fit(const Plan& plan, const SpeedFit& fit, const std::string& file, std::FILE* out);

}  // namespace inbetween
