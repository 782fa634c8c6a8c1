#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "host_tools/move_model/move_readers.hpp"
#include "host_tools/text/csv_table.hpp"

namespace inbetween {
namespace {

/// All that says where the axes are, or when.
void refuse_other_motion(const TomlTable& table) {
  table.refuse_any(
      {"keys",      "speed",   "weights", "timing",   "kinetic", "spline",  "closed", "periodic",
       "overshoot", "corners", "ease_in", "ease_out", "through", "overlap", "round",  "space",
       "aim",       "elbow",   "near",    "distance", "network", "places",  "drawn"},
      "is for other tracks: the rows of a table say where every axis is on which frame; remove it, or table");
  table.refuse_any({"wrap"},
                   "is for other tracks: the axes of a table do not count round; remove it, and write "
                   "positions that go on over whole turns");
}

/// The axes of a track in the rows of its file.
class TableRows {
 public:
  TableRows(const CsvReader& reader, const std::vector<MoveUnit>& units, const MoveTrack& track,
            std::int32_t frames, MoveTable& made)
      : reader_(reader), axes_(track.axes), frames_(frames), made_(made) {
    const std::vector<std::string>& columns = reader_.columns();
    const auto frame = std::ranges::find(columns, "frame");
    if (frame == columns.end()) refuse_missing("frame");
    frame_column_ = static_cast<std::size_t>(frame - columns.begin());
    for (std::size_t d = 0; d < axes_.size(); ++d)
      find_column(d, units.empty() ? MoveUnit::of_rig : units[d]);
  }

  void take(const CsvRow& row) {
    const Place place{made_.file, row.line, 0};
    const double frame = csv_number("frame", row.fields[frame_column_], place);
    if (frame != std::floor(frame) || frame < 0 || frame > frames_) {
      throw InputError(place, fmt::format("frame {:.10g} is none of the move; write a whole number from 0 to "
                                          "{}, the frames of the move, or give the move more frames",
                                          frame, frames_));
    }
    const auto whole = static_cast<std::int32_t>(frame);
    refuse_disorder(whole, place);
    made_.frames.push_back(whole);
    made_.lines.push_back(row.line);
    for (std::size_t d = 0; d < axes_.size(); ++d)
      made_.at.push_back(csv_number(reader_.columns()[columns_[d]], row.fields[columns_[d]], place));
  }

  void finish() const {
    if (!made_.frames.empty() && made_.frames.back() == frames_) return;
    const Place last{made_.file, made_.lines.empty() ? 1 : made_.lines.back(), 0};
    if (made_.frames.empty()) {
      throw InputError(last, fmt::format("the table has no row; write one for frame 0, one for frame {}, "
                                         "where the move ends, and any between them",
                                         frames_));
    }
    const std::int32_t end = made_.frames.back();
    throw InputError(
        last, fmt::format("the table ends on frame {}; give it a row on frame {}, where the move ends{}", end,
                          frames_, end > 0 ? fmt::format(", or the move frames = {}", end) : ""));
  }

 private:
  [[noreturn]] void refuse_missing(const std::string& column) const {
    throw InputError({made_.file, 1, 0},
                     fmt::format("the first row names no column {}; name the columns, with commas between "
                                 "them, as in frame,{}",
                                 in_quotes(column), comma_separated(axes_)));
  }
  void find_column(std::size_t axis, MoveUnit otherwise) {
    const std::vector<std::string>& columns = reader_.columns();
    std::optional<std::size_t> found;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const auto unit = unit_of_column(columns[c], axes_[axis], otherwise);
      if (!unit) continue;
      if (found) {
        throw InputError(
            {made_.file, 1, 0},
            fmt::format("the columns {} and {} are both of axis {}; leave one out",
                        in_quotes(columns[*found]), in_quotes(columns[c]), in_quotes(axes_[axis])));
      }
      found = c;
      made_.units.push_back(*unit);
    }
    if (!found) refuse_missing(axes_[axis]);
    columns_.push_back(*found);
  }
  void refuse_disorder(std::int32_t frame, const Place& place) const {
    if (made_.frames.empty()) {
      if (frame == 0) return;
      throw InputError(place, fmt::format("the table begins on frame {}; count its frames from 0, where the "
                                          "move begins",
                                          frame));
    }
    if (frame > made_.frames.back()) return;
    throw InputError(place, fmt::format("frame {} comes behind frame {}; write each frame once, in order",
                                        frame, made_.frames.back()));
  }

  const CsvReader& reader_;
  const std::vector<std::string>& axes_;
  std::int32_t frames_;
  MoveTable& made_;
  std::size_t frame_column_ = 0;
  std::vector<std::size_t> columns_;  // of each axis
};

/// A row as a key: who asks where a track begins or ends need not know of tables.
MoveKey key_of_row(const MoveTable& table, std::size_t row, std::size_t axes) {
  MoveKey key;
  const auto first = table.at.begin() + static_cast<std::ptrdiff_t>(row * axes);
  key.at.assign(first, first + static_cast<std::ptrdiff_t>(axes));
  if (std::ranges::any_of(table.units, [](MoveUnit unit) { return unit != MoveUnit::of_rig; }))
    key.units = table.units;
  key.frame = table.frames[row];
  key.place = key.frame_place = table.place_of(row);
  key.at_places.assign(axes, key.place);
  return key;
}

}  // namespace

void read_table(const TomlTable& table, std::int32_t frames, const TextReader& read, MoveTrack& track) {
  refuse_other_motion(table);
  read_counting(table, track);
  const TomlValue named = table.required("table", R"(table = "rows.csv", say)");
  MoveTable made{
      .file = path_beside(named), .frames = {}, .at = {}, .units = {}, .lines = {}, .place = named.place()};
  const std::string text = read(made.file, max_table_bytes);
  CsvReader reader(text, made.file);
  reader.read_columns();
  TableRows rows(reader, track.units, track, frames, made);
  for (CsvRow row; reader.next(row);) rows.take(row);
  rows.finish();
  track.timing = Timing::frames;
  track.speed_place = track.place;
  track.keys = {key_of_row(made, 0, track.axes.size()),
                key_of_row(made, made.frames.size() - 1, track.axes.size())};
  track.table = std::move(made);
}

}  // namespace inbetween
