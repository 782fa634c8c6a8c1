#include "host_tools/exchange/arc_move.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host_tools/exchange/toml_text.hpp"

namespace inbetween {
namespace {

/// Of all axes together: ten of them for an hour at 24 frames a second. Each takes 64 halvings, a second in
/// all.
constexpr std::size_t max_arc_values = 1'000'000;

struct ArcFrames {
  double first = 0, last = 0;
};

ArcFrames frames_with_motion(const ArcScene& scene) {
  ArcFrames frames{static_cast<double>(max_table_frame), -static_cast<double>(max_table_frame)};
  for (const ArcAxis& axis : scene.axes) {
    if (axis.points.empty()) continue;
    frames.first = std::min(frames.first, std::floor(axis.points.front().frame));
    frames.last = std::max(frames.last, std::ceil(axis.points.back().frame));
  }
  return frames;
}

void warn_of_held_ends(const ArcAxis& axis, const ArcFrames& frames, BakedTable& table) {
  if (axis.points.front().frame <= frames.first && axis.points.back().frame >= frames.last) return;
  table.warnings.push_back(
      {axis.place,
       fmt::format("axis {} has points on frames {} to {} of {} to {}, and holds its ends elsewhere",
                   in_quotes(axis.name), axis.points.front().frame, axis.points.back().frame, frames.first,
                   frames.last)});
}

/// How far the value goes in a frame where point `row` is, by its neighbours.
double slope_at(const std::vector<double>& values, std::size_t row) {
  const std::size_t before = row == 0 ? 0 : row - 1;
  const std::size_t behind = std::min(row + 1, values.size() - 1);
  return (values[behind] - values[before]) / static_cast<double>(behind - before);
}

std::string word_of_arc_unit(const BakedColumn& column, const std::string& file) {
  switch (*column.unit) {
    case MoveUnit::m:
    case MoveUnit::cm:
    case MoveUnit::mm:
    case MoveUnit::inch:
    case MoveUnit::deg:
      return std::string(to_string(*column.unit));
    default:
      throw InputError({file}, fmt::format("{} is in none of m, cm, mm, in, deg, which Dragonframe knows; "
                                           "convert it",
                                           in_quotes(column.name)));
  }
}

ArcAxis arc_axis_of(const BakedColumn& column, std::int64_t first_frame, const std::string& file) {
  ArcAxis axis{.name = column.name};
  axis.attributes.push_back({"name", column.name});
  if (column.unit && column.unit != MoveUnit::of_rig) {
    axis.attributes.push_back({"units", word_of_arc_unit(column, file)});
  }
  const std::vector<double>& values = column.values;
  for (std::size_t row = 0; row < values.size(); ++row) {
    const double frame = static_cast<double>(first_frame + static_cast<std::int64_t>(row));
    axis.points.push_back({.frame = frame, .value = values[row]});
    const double third = slope_at(values, row) / 3;
    if (row > 0) axis.controls.push_back({.frame = frame - 1.0 / 3, .value = values[row] - third});
    if (row + 1 < values.size())
      axis.controls.push_back({.frame = frame + 1.0 / 3, .value = values[row] + third});
  }
  return axis;
}

std::string rig_axis_text(const ArcAxis& axis) {
  std::string text = fmt::format("\n[[axis]]\nname = {}\n", toml_quoted(axis.name));
  const std::optional<double> steps = axis.number("stepsPerUnit");
  const std::string* const channel = axis.attribute("connectionChannel");
  if (channel != nullptr) text += fmt::format("# motor {} of its controller\n", in_quotes(*channel));
  if (axis.unit == MoveUnit::mm || axis.unit == MoveUnit::m || axis.unit == MoveUnit::deg) {
    text += fmt::format("unit = \"{}\"\n", to_string(*axis.unit));
  } else if (axis.unit) {
    text +=
        fmt::format("# unit = ?  the scene counts in {}; write \"mm\" or \"m\", and convert what follows\n",
                    to_string(*axis.unit));
  } else {
    text += "# unit = ?  the scene does not say; write \"mm\" or \"deg\"\n";
  }
  text += "# min = ?\n# max = ?\n";
  const auto limit = [&](std::string_view field, std::string_view attribute, std::string_view unit) {
    const std::optional<double> said = axis.number(attribute);
    text += fmt::format("# {} = ?  in units a {}", field, unit);
    if (said && steps && *steps != 0) {
      text += fmt::format("; {} is {}, which is {:g} if it counts steps", attribute, *said,
                          *said / std::fabs(*steps));
    }
    text += '\n';
  };
  limit("max_velocity", "runMaxVelocity", "second");
  limit("max_acceleration", "runMaxAcceleration", "second^2");
  text += "# drive = ?";
  if (steps) text += fmt::format("  with steps_per_unit or counts_per_unit = {}", *steps);
  return text + "\n";
}

}  // namespace

BakedTable read_arc_move(std::string_view text, const std::string& file) {
  const ArcScene scene = read_arc_scene(text, file);
  if (!scene.has_motion()) {
    throw InputError({file},
                     "no axis of the scene has points, so that nothing moves; name an .arcm file, or make "
                     "a rig of this one");
  }
  const ArcFrames frames = frames_with_motion(scene);
  const auto rows = static_cast<std::size_t>(frames.last - frames.first) + 1;
  if (rows > max_arc_values / scene.axes.size()) {
    throw InputError({file}, fmt::format("{} frames of {} axes are more than {} positions; leave some out",
                                         rows, scene.axes.size(), max_arc_values));
  }
  BakedTable table{.file = file};
  table.first_frame = static_cast<std::int64_t>(frames.first);
  for (const ArcAxis& axis : scene.axes) {
    if (axis.points.empty()) {
      table.warnings.push_back(
          {axis.place, fmt::format("axis {} has no points and does not move", in_quotes(axis.name))});
      continue;
    }
    warn_of_held_ends(axis, frames, table);
    BakedColumn& column = table.columns.emplace_back();
    column.name = axis.name;
    column.unit = axis.unit;
    column.values.reserve(rows);
    for (std::size_t row = 0; row < rows; ++row) {
      column.values.push_back(arc_value(axis, frames.first + static_cast<double>(row)));
    }
  }
  check_table(table);
  return table;
}

std::string write_arc_move(const BakedTable& table, const TableWriting& writing) {
  check_written(table, writing);
  const std::int64_t first = table.first_frame.value_or(1);
  ArcScene scene{.file = table.file};
  scene.attributes = {{"xmlns:scen", std::string(arc_namespace)},
                      {"endframe", fmt::format("{}", static_cast<std::int64_t>(table.rows()) - 1)}};
  for (const BakedColumn& column : table.columns)
    scene.axes.push_back(arc_axis_of(column, first, table.file));
  return write_arc_scene(scene, writing.decimals);
}

std::string rig_of_arc_scene(const ArcScene& scene, std::int32_t rate_hz) {
  std::string text = fmt::format("name = {}\nrate_hz = {}\n", toml_quoted(scene.file), rate_hz);
  for (const ArcAxis& axis : scene.axes) text += rig_axis_text(axis);
  return text;
}

}  // namespace inbetween
