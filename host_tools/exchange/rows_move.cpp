#include "host_tools/exchange/rows_move.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host_tools/exchange/table_words.hpp"
#include "host_tools/exchange/toml_text.hpp"
#include "host_tools/exchange/wrong_rows.hpp"
#include "host_tools/move_model/move_file.hpp"
#include "host_tools/text/csv_table.hpp"
#include "inbetween/timing/track.hpp"

namespace inbetween {
namespace {

constexpr double max_rows_move_rate = 1'000;  // as `fps` of a move

const RigAxis& rig_axis(const RigFile& rig, const std::string& name) {
  return *std::ranges::find(rig.axes, name, &RigAxis::name);
}

std::string beyond_range(const RigAxis& axis, double position) {
  return fmt::format("axis {} is at {:.10g} {}, beyond its range {}", in_quotes(axis.name), position,
                     to_string(axis.unit), range_in_words(axis));
}

bool is_in_range(const RigAxis& axis, double position) {
  return position >= axis.min && position <= axis.max;
}

void refuse_rows_beyond(const BakedTable& table, const RigFile& rig) {
  WrongRows wrong(table.file);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    for (const BakedColumn& column : table.columns) {
      const RigAxis& axis = rig_axis(rig, column.name);
      if (is_in_range(axis, column.values[row])) continue;
      wrong.add(InputError(table.place_of(row), fmt::format("{}; correct the row, its unit, or the rig",
                                                            beyond_range(axis, column.values[row]))));
    }
  }
  wrong.refuse();
}

/// Positions on frames 0..n of rows that are half a frame later, n of them. Between four rows the weights are
/// Lagrange's in the middle, and beside an end those of the four rows that are there.
std::vector<double> between_rows(const std::vector<double>& rows) {
  const std::size_t n = rows.size();
  std::vector<double> positions{rows[0] - (rows[1] - rows[0]) / 2};
  constexpr std::size_t rows_of_a_cubic = 4;
  const auto beside_end = [](double a, double b, double c, double d) {
    return (5 * a + 15 * b - 5 * c + d) / 16;
  };
  for (std::size_t frame = 1; frame < n; ++frame) {
    if (n < rows_of_a_cubic) {
      positions.push_back((rows[frame - 1] + rows[frame]) / 2);
    } else if (frame == 1) {
      positions.push_back(beside_end(rows[0], rows[1], rows[2], rows[3]));
    } else if (frame == n - 1) {
      positions.push_back(beside_end(rows[n - 1], rows[n - 2], rows[n - 3], rows[n - 4]));
    } else {
      positions.push_back((9 * (rows[frame - 1] + rows[frame]) - rows[frame - 2] - rows[frame + 1]) / 16);
    }
  }
  positions.push_back(rows[n - 1] + (rows[n - 1] - rows[n - 2]) / 2);
  return positions;
}

void refuse_frames_beyond(const RowsMove& move, const RigFile& rig, const std::string& file) {
  for (std::size_t a = 0; a < move.axes.size(); ++a) {
    const RigAxis& axis = rig_axis(rig, move.axes[a]);
    for (std::size_t frame = 0; frame < move.positions[a].size(); ++frame) {
      if (is_in_range(axis, move.positions[a][frame])) continue;
      throw InputError({file},
                       fmt::format("between its rows, on frame {}, {}; let the rig have more room, or "
                                   "give the rows at frame boundaries",
                                   frame, beyond_range(axis, move.positions[a][frame])));
    }
  }
}

void take_centred_rows(const BakedTable& table, const RigFile& rig, RowsMove& move) {
  for (std::vector<double>& positions : move.positions) positions = between_rows(positions);
  refuse_frames_beyond(move, rig, table.file);
  move.warnings.push_back(
      fmt::format("rows are the middle of exposures: frame k of the move is half a frame before row k, "
                  "computed from the rows around it, and frames 0 and {} continue the motion by half a frame",
                  move.frames()));
}

}  // namespace

RowsMove rows_move_of(const BakedTable& table, const RigFile& rig, const std::string& name) {
  check_table(table);
  const FrameRate fps = table.fps.value_or(FrameRate{});
  if (fps.frames_per_second() > max_rows_move_rate) {
    throw InputError({table.file}, fmt::format("{} rows a second are more than the {} frames a second that a "
                                               "move has at most; take fewer rows",
                                               to_string(fps), max_rows_move_rate));
  }
  refuse_rows_beyond(table, rig);
  RowsMove move{.name = name, .fps = fps, .axes = {}, .positions = {}};
  for (const BakedColumn& column : table.columns) {
    move.axes.push_back(column.name);
    move.positions.push_back(column.values);
  }
  const bool is_centred = table.has_exposures && table.phase == ShutterPhase::exposure_centre;
  if (is_centred) take_centred_rows(table, rig, move);
  if (move.frames() > static_cast<std::size_t>(max_frames)) {
    throw InputError({table.file},
                     fmt::format("{} frames are more than the {} that a move has; import the file "
                                 "in parts",
                                 move.frames(), max_frames));
  }
  move.comments.push_back(fmt::format("Imported from {}: {} at {} a second{}.", table.file,
                                      counted(static_cast<std::int64_t>(table.rows()), "row"), to_string(fps),
                                      is_centred ? ", each the middle of an exposure" : ""));
  if (table.first_frame && *table.first_frame != 0)
    move.comments.push_back(fmt::format("Frame {} there is frame 0 here.", *table.first_frame));
  return move;
}

std::string summary_of(const RowsMove& move) {
  return fmt::format("{} of {} at {} fps, {:.3f} s",
                     counted(static_cast<std::int64_t>(move.frames()), "frame"), comma_separated(move.axes),
                     to_string(move.fps), static_cast<double>(move.frames()) / move.fps.frames_per_second());
}

std::string move_text_of(const RowsMove& move, const std::string& rows) {
  std::string text;
  for (const std::string& comment : move.comments) text += toml_comment(comment);
  text += toml_comment("The rows are played as they are; a [[cue]] of the rig's outputs may stand below.");
  text += fmt::format("name = {}\n", toml_quoted(move.name));
  text += move.fps.denominator == 1 ? fmt::format("fps = {}\n", move.fps.numerator)
                                    : fmt::format("fps = \"{}\"\n", to_string(move.fps));
  text += fmt::format("frames = {}\n\n", move.frames());
  text += fmt::format("[[track]]\naxes = {}\ntable = {}\n", toml_list(move.axes), toml_quoted(rows));
  return text;
}

std::string rows_text_of(const RowsMove& move, const std::string& rows) {
  std::string text = "frame";
  for (const std::string& axis : move.axes) text += "," + csv_field(axis);
  text += '\n';
  for (std::size_t frame = 0; frame <= move.frames(); ++frame) {
    fmt::format_to(std::back_inserter(text), "{}", frame);
    for (const std::vector<double>& positions : move.positions) {
      const double position = positions[frame];
      fmt::format_to(std::back_inserter(text), ",{}", position == 0 ? 0.0 : position);
    }
    text += '\n';
    if (text.size() <= max_table_bytes) continue;
    throw InputError({rows},
                     fmt::format("the rows would be more than {} MiB, which a move has at most; import the "
                                 "file in parts, or fewer of its columns",
                                 max_table_bytes >> 20U));
  }
  return text;
}

}  // namespace inbetween
