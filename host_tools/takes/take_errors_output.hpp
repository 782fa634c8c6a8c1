// What takes were like, as text, as JSON and as a picture. docs/formats.md describes the JSON.
#pragma once

#include <cstdio>
#include <optional>
#include <span>
#include <string>

#include "host_tools/plot/plot_trend.hpp"
#include "host_tools/takes/take_budget.hpp"
#include "host_tools/takes/take_compare.hpp"
#include "host_tools/takes/take_errors.hpp"
#include "host_tools/takes/take_passes.hpp"
#include "host_tools/takes/take_trend.hpp"
#include "host_tools/text/json_writer.hpp"

namespace inbetween {

/// A row for each measure: the worst with its frame, mean and root mean square; at rest and moving.
void print_errors(const TakeErrors& errors, const std::optional<BudgetVerdict>& verdict, std::FILE* out);
/// The members of a JSON object that is open; `verdict` is its member "budget".
void write_errors(JsonWriter& json, const TakeErrors& errors, const std::optional<BudgetVerdict>& verdict);

/// The sentence of in_one_sentence() first, then the same rows.
void print_comparison(const TakeComparison& comparison, const std::optional<BudgetVerdict>& verdict,
                      std::FILE* out);
void write_comparison(JsonWriter& json, const TakeComparison& comparison,
                      const std::optional<BudgetVerdict>& verdict);

/// AT and RT of each measure, with their frames.
void print_path_report(const PathReport& report, std::FILE* out);
void write_path_report(JsonWriter& json, const PathReport& report);

/// A row for each take and axis.
void print_trends(std::span<const TakeTrend> trends, std::FILE* out);
void write_trends(JsonWriter& json, std::span<const TakeTrend> trends);
/// The axes of the last take; a take whose rig had none of that name and unit has no value there.
TrendPlot trend_plot(std::string name, std::span<const TakeTrend> trends);

}  // namespace inbetween
