// What `inbetween import` makes of rows beyond playing them: smoother rows, and keys.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/exchange/rows_move.hpp"
#include "host_tools/fit/row_fit.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

/// A number for each column of a table, whose names are axes of the rig, as it was said: "0.05" for all,
/// "pan=0.05" for one. Throws UsageError where it is neither, is not above 0, names no axis of the table or
/// one twice, or leaves one out.
std::vector<double> numbers_of_axes(const std::vector<std::string>& said, const BakedTable& table,
                                    const std::string& option);

/// Makes every column as smooth as its resolution allows, and prints how much acceleration the rounding alone
/// would have made. Throws WrongRowsError with a line for each spike, unless spikes are left out; then each
/// is a warning of the table.
void smooth_table(BakedTable& table, const RigFile& rig, const std::vector<double>& resolutions,
                  bool leaves_spikes_out);

/// Adds a warning for each spike: rows are looked at as if they were rounded to a thousandth of their range.
void warn_of_spikes(BakedTable& table, const RigFile& rig);

/// The move of few keys, named as the rows. Prints what it misses of every axis.
RowFit fit_rows_move(const RowsMove& rows, const RigFile& rig, const std::vector<double>& tolerances);

/// The rows, what the fitted move plays, and what that misses.
void draw_fit(const RowsMove& rows, const RowFit& fit, const RigFile& rig, const std::filesystem::path& file);

}  // namespace inbetween
