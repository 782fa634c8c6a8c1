#include "host_tools/cli/import_fit.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "host_tools/cli/command.hpp"
#include "host_tools/cli/progress_bar.hpp"
#include "host_tools/exchange/wrong_rows.hpp"
#include "host_tools/fit/row_smoothing.hpp"
#include "host_tools/plan/plan.hpp"
#include "host_tools/plan/plan_rows.hpp"
#include "host_tools/plot/plot_run.hpp"

namespace inbetween {
namespace {

const RigAxis& axis_of_rig(const RigFile& rig, const std::string& name) {
  return *std::ranges::find(rig.axes, name, &RigAxis::name);
}

std::string spike_in_words(const BakedTable& table, const std::string& axis, std::string_view unit,
                           const RowSpike& spike) {
  const auto frame = static_cast<std::int64_t>(spike.first) + table.first_frame.value_or(0);
  const std::string where =
      spike.count == 1
          ? fmt::format("frame {}", frame)
          : fmt::format("frames {} to {}", frame, frame + static_cast<std::int64_t>(spike.count) - 1);
  return fmt::format("axis {} is {:.4g} {} off the motion around it on {}", in_quotes(axis),
                     std::fabs(spike.off), unit, where);
}

/// Of the acceleration of rows, in a unit a second and second.
double acceleration_of(std::span<const double> rows, const FrameRate& fps) {
  return largest_second_difference(rows) * std::pow(fps.frames_per_second(), 2);
}

}  // namespace

std::vector<double> numbers_of_axes(const std::vector<std::string>& said, const BakedTable& table,
                                    const std::string& option) {
  std::vector<std::optional<double>> numbers(table.columns.size());
  std::optional<double> of_all;
  for (const std::string& text : said) {
    const std::size_t equals = text.rfind('=');
    const std::string word = equals == std::string::npos ? text : text.substr(equals + 1);
    double number = 0;
    if (!CLI::detail::lexical_cast(word, number) || !(number > 0) || !std::isfinite(number))
      throw UsageError(fmt::format("{} {}: write a number above 0, or AXIS=NUMBER", option, in_quotes(text)));
    if (equals == std::string::npos) {
      if (of_all) throw UsageError(fmt::format("{} {}: a number for all axes was said before", option, text));
      of_all = number;
      continue;
    }
    const auto column = std::ranges::find(table.columns, text.substr(0, equals), &BakedColumn::name);
    if (column == table.columns.end())
      throw UsageError(fmt::format("{} {}: no column is this axis", option, in_quotes(text)));
    std::optional<double>& own = numbers[static_cast<std::size_t>(column - table.columns.begin())];
    if (own) throw UsageError(fmt::format("{} {}: this axis has a number already", option, in_quotes(text)));
    own = number;
  }
  std::vector<double> found;
  for (std::size_t c = 0; c < numbers.size(); ++c) {
    if (!numbers[c] && !of_all)
      throw UsageError(fmt::format("{} is missing for axis {}", option, in_quotes(table.columns[c].name)));
    found.push_back(numbers[c] ? *numbers[c] : *of_all);
  }
  return found;
}

void smooth_table(BakedTable& table, const RigFile& rig, const std::vector<double>& resolutions,
                  bool leaves_spikes_out) {
  const FrameRate fps = table.fps.value_or(FrameRate{});
  ProgressBar bar;
  WrongRows wrong(table.file);
  std::vector<std::string> lines;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    bar.show(static_cast<double>(c) / static_cast<double>(table.columns.size()),
             "smoothing " + table.columns[c].name);
    BakedColumn& column = table.columns[c];
    const RigAxis& axis = axis_of_rig(rig, column.name);
    SmoothRows smooth = smooth_rows(column.values, resolutions[c], {axis.min, axis.max});
    for (const RowSpike& spike : smooth.spikes) {
      const std::string words = spike_in_words(table, axis.name, to_string(axis.unit), spike);
      if (leaves_spikes_out) {
        table.warnings.push_back({table.place_of(spike.first), words + "; it follows that motion instead"});
      } else {
        wrong.add(InputError(table.place_of(spike.first),
                             words + "; correct the row, or leave such rows out (--without-spikes)"));
      }
    }
    lines.push_back(fmt::format(
        "  {}: acceleration up to {:.4g} {}/s^2; by its rounding it would be {:.4g}\n", axis.name,
        acceleration_of(smooth.rows, fps), to_string(axis.unit), acceleration_of(column.values, fps)));
    column.values = std::move(smooth.rows);
  }
  wrong.refuse();
  for (const std::string& line : lines) fmt::print("{}", line);
}

void warn_of_spikes(BakedTable& table, const RigFile& rig) {
  constexpr double share_of_range = 1e-3;
  for (const BakedColumn& column : table.columns) {
    const auto [low, high] = std::ranges::minmax(column.values);
    if (high == low) continue;
    const RigAxis& axis = axis_of_rig(rig, column.name);
    for (const RowSpike& spike : smooth_rows(column.values, share_of_range * (high - low)).spikes) {
      table.warnings.push_back({table.place_of(spike.first),
                                spike_in_words(table, axis.name, to_string(axis.unit), spike) +
                                    "; correct it, or take it out with --smooth and --without-spikes"});
    }
  }
}

RowFit fit_rows_move(const RowsMove& rows, const RigFile& rig, const std::vector<double>& tolerances) {
  ProgressBar bar;
  RowFit fit = fit_rows({.axes = rows.axes,
                         .table = {.rows = rows.positions, .tolerances = tolerances},
                         .fps = {.rate = rows.fps,
                                 .as_written = to_string(rows.fps),
                                 .written_as_integer = rows.fps.denominator == 1}},
                        [&](double share) { bar.show(share, "looking for keys"); });
  fit.move.name = rows.name;
  for (std::size_t a = 0; a < rows.axes.size(); ++a) {
    fmt::print("  {}: misses its rows by up to {:.3g} {}\n", rows.axes[a], fit.worst[a],
               to_string(axis_of_rig(rig, rows.axes[a]).unit));
  }
  return fit;
}

void draw_fit(const RowsMove& rows, const RowFit& fit, const RigFile& rig,
              const std::filesystem::path& file) {
  RunPlot plot{.name = rows.name,
               .summary = fmt::format("{} frames; {} numbers in place of {}", rows.frames(), fit.numbers,
                                      rows.axes.size() * (rows.frames() + 1)),
               .axes = {},
               .words = {.error = "miss",
                         .heading = "Positions over frames",
                         .legend = "dashed: rows; line: fitted move",
                         .description = "rows and the move that was fitted to them"}};
  const Plan plan(fit.move, std::nullopt, {});
  for (std::size_t a = 0; a < rows.axes.size(); ++a) {
    const std::size_t of_plan = static_cast<std::size_t>(
        std::ranges::find(plan.axes(), rows.axes[a], &PlanAxis::name) - plan.axes().begin());
    const AxisColumn column(plan, plan.axes()[of_plan], PlanRows::frame);
    RunPlotAxis axis{.name = rows.axes[a],
                     .unit = std::string(to_string(axis_of_rig(rig, rows.axes[a]).unit))};
    for (std::size_t frame = 0; frame <= rows.frames(); ++frame) {
      const auto x = static_cast<double>(frame);
      const double row = rows.positions[a][frame];
      const double position = column.position(static_cast<std::int64_t>(frame));
      axis.commanded.push_back({x, row});
      axis.actual.push_back({x, position});
      axis.following_error.push_back({x, position - row});
    }
    plot.axes.push_back(std::move(axis));
  }
  draw_run_plot(plot, file);
}

}  // namespace inbetween
