#include "host_tools/exchange/plan_table.hpp"

#include <fmt/format.h>

#include <vector>

namespace inbetween {
namespace {

/// Where row `row` is, in frames of the move: exact in integers, and rounded once.
FrameTime time_of_row(std::int64_t row, bool is_centre, std::int32_t first_frame, FrameRate of_move,
                      FrameRate of_rows) {
  // (row + 1/2) / rows a second * frames a second, over one denominator.
  const std::int64_t halves = 2 * row + (is_centre ? 1 : 0);
  const std::int64_t scaled = halves * of_rows.denominator * of_move.numerator;
  const std::int64_t unit = std::int64_t{2} * of_rows.numerator * of_move.denominator;
  return {first_frame + static_cast<std::int32_t>(scaled / unit),
          static_cast<double>(scaled % unit) / static_cast<double>(unit)};
}

/// Rows up to the first at or after the end.
std::int64_t rows_of_plan(std::int64_t frames, bool is_centre, FrameRate of_move, FrameRate of_rows) {
  const std::int64_t scaled = 2 * frames * of_move.denominator * of_rows.numerator;
  const std::int64_t unit = std::int64_t{2} * of_move.numerator * of_rows.denominator;
  const std::int64_t shift = is_centre ? unit / 2 : 0;
  return (scaled - shift + unit - 1) / unit + 1;
}

}  // namespace

FrameTime time_of_plan_row(const Plan& plan, const PlanTableOptions& options, std::int64_t row) {
  const Move& move = plan.motion().move();
  const std::int32_t first = options.has_rolls ? move.first_frame() : plan.part().first;
  const std::int32_t last = options.has_rolls ? move.last_frame() : plan.part().last;
  const FrameTime time = time_of_row(row, options.phase == ShutterPhase::exposure_centre, first,
                                     move.frame_rate(), options.fps.value_or(move.frame_rate()));
  return FrameTime{last, 0} < time ? FrameTime{last, 0} : time;  // it holds there, rolls or not
}

BakedTable table_of_plan(const Plan& plan, const PlanTableOptions& options) {
  const PlayedMotion& motion = plan.motion();
  const Move& move = motion.move();
  const FrameRate of_move = move.frame_rate();
  const FrameRate of_rows = options.fps.value_or(of_move);
  const bool is_centre = options.phase == ShutterPhase::exposure_centre;
  const std::int32_t first = options.has_rolls ? move.first_frame() : plan.part().first;
  const std::int32_t last = options.has_rolls ? move.last_frame() : plan.part().last;
  const std::int64_t rows = rows_of_plan(std::int64_t{last} - first, is_centre, of_move, of_rows);
  BakedTable table{.file = plan.move().name};
  if (rows > static_cast<std::int64_t>(max_table_rows)) {
    throw InputError({table.file},
                     fmt::format("{} rows are more than {}; export a part of the move, or fewer rows "
                                 "a second",
                                 rows, max_table_rows));
  }
  table.fps = of_rows;
  table.first_frame = of_rows == of_move ? first : 0;
  table.phase = options.phase;
  std::vector<std::size_t> axes;
  for (const PlanAxis& axis : plan.axes()) {
    if (!axis.track) continue;
    BakedColumn& column = table.columns.emplace_back();
    column.name = axis.name;
    if (axis.unit) column.unit = as_move_unit(*axis.unit);
    column.values.reserve(static_cast<std::size_t>(rows));
    axes.push_back(axis.move_axis);
  }
  std::vector<double> positions(motion.axis_count());
  for (std::int64_t row = 0; row < rows; ++row) {
    motion.positions(time_of_plan_row(plan, options, row), positions);
    for (std::size_t i = 0; i < axes.size(); ++i) table.columns[i].values.push_back(positions[axes[i]]);
  }
  check_table(table);
  return table;
}

}  // namespace inbetween
