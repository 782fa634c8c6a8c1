#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host_tools/move_model/move_readers.hpp"
#include "host_tools/text/csv_table.hpp"

namespace inbetween {
namespace {

constexpr std::array<std::string_view, 2> point_fields = {"frame", "at"};

/// A network is C2 in time because all its curves are.
void refuse_other_curves(const TomlTable& table, const TomlValue& network, const MoveTrack& track) {
  if (track.timing != Timing::frames) {
    network.refuse(R"(needs curves over time; add timing = "frames", and a frame for every key)");
  }
  if (track.spline != Spline::smooth) {
    table.required("spline", "").refuse(R"(is for other tracks, and a network is "smooth"; remove it)");
  }
  if (kinetic_of(track) != MoveKinetic::curves) {
    table.required("kinetic", "").refuse(R"(is for other tracks, and a network has "curves"; remove it)");
  }
  if (!track.overshoot) {
    table.required("overshoot", "")
        .refuse(
            "is for other tracks: a network goes beyond its keys where what "
            "is drawn beside them does; remove it");
  }
  if (track.closed) table.required("closed", "").refuse("is for other tracks: a network is open; remove it");
  if (const auto periodic = table.optional("periodic"); periodic && periodic->boolean()) {
    periodic->refuse("is for other tracks: a network is played once; remove it");
  }
}

/// What the row is made of: axes, or points in space.
const std::vector<std::string>& row_of(const MoveTrack& track) {
  return track.space ? track.space->tips : track.axes;
}

void refuse_other_keys(const TomlTable& table, const MoveTrack& track) {
  table.refuse_any({"distance"}, "is for other tracks: a network goes by the frames of its keys; remove it");
  if (!track.wraps.empty()) {
    table.required("wrap", "")
        .refuse(
            "is for other tracks: the axes of a network do not count round; remove it, and write positions "
            "that "
            "go on over whole turns");
  }
}

std::vector<double> read_places(const TomlTable& table, const MoveTrack& track) {
  std::vector<double> places;
  const auto written = table.optional("places");
  const std::vector<std::string>& row = row_of(track);
  if (!written) {  // evenly spaced
    for (std::size_t i = 0; i < row.size(); ++i) places.push_back(static_cast<double>(i));
    return places;
  }
  for (const TomlValue& place : written->list(max_track_axes)) {
    places.push_back(place.number());
    if (places.size() < 2 || places.back() >= places[places.size() - 2]) continue;
    place.refuse(
        fmt::format("is {:g}, behind {:g}; write the {} in the order of their row, and the places "
                    "so that none is below the one before",
                    places.back(), places[places.size() - 2], track.space ? "points" : "axes"));
  }
  if (places.size() == row.size()) return places;
  written->refuse(fmt::format("has {}; write {}, one for each of its {} ({})",
                              counted(static_cast<std::int64_t>(places.size()), "number"), row.size(),
                              track.space ? "points" : "axes", comma_separated(row)));
}

/// The next point of a curve, which comes later than those that it has.
void add_point(DrawnAxis& drawn, std::int32_t frame, double at, const Place& frame_place, Place at_place) {
  if (drawn.frames.empty() && frame != 0) {
    throw InputError(frame_place, fmt::format("the curve begins on frame {}; give it a point on frame 0, "
                                              "where the move begins",
                                              frame));
  }
  if (!drawn.frames.empty() && frame <= drawn.frames.back()) {
    throw InputError(frame_place, fmt::format("frame {} comes behind frame {}; write each frame once, in "
                                              "order",
                                              frame, drawn.frames.back()));
  }
  if (drawn.frames.size() == max_drawn_points) {
    throw InputError(frame_place,
                     fmt::format("the curve has more than {} points; leave some out", max_drawn_points));
  }
  drawn.frames.push_back(frame);
  drawn.at.push_back(at);
  drawn.places.push_back(std::move(at_place));
}

void refuse_unfinished(const DrawnAxis& drawn, std::int32_t frames, const Place& place) {
  if (!drawn.frames.empty() && drawn.frames.back() == frames) return;
  const std::string end =
      drawn.frames.empty() ? "has no point" : fmt::format("ends on frame {}", drawn.frames.back());
  throw InputError(
      place, fmt::format("the curve {}; give it a point on frame {}, where the move ends", end, frames));
}

/// The points of an axis, which are numbers in its unit, or of the three curves of a point, which are places.
void read_points(const TomlValue& value, std::int32_t frames, const MoveTrack& track,
                 std::span<DrawnAxis> drawn) {
  for (const TomlValue& point : value.tables(max_drawn_points)) {
    const TomlTable table(point.table(), point.name(), point_fields);
    const TomlValue written_frame = table.required("frame", "frame = 0, say");
    const TomlValue at = table.required("at", track.space ? "at = [x, y, z]" : "at = 30, say");
    const auto frame = static_cast<std::int32_t>(written_frame.integer(0, frames));
    if (!track.space) {
      add_point(drawn.front(), frame, at.number(), written_frame.place(), at.place());
      continue;
    }
    const std::array place = read_world_place(at, track.space->unit);
    for (std::size_t c = 0; c < drawn.size(); ++c)
      add_point(drawn[c], frame, place.at(c).metres, written_frame.place(), place.at(c).place);
  }
  refuse_unfinished(drawn.front(), frames, value.place());
}

/// A column is that of the axis, or of its frames.
struct Columns {
  std::size_t frame = 0;
  std::size_t at = 0;
};
Columns find_columns(const CsvTable& table, const std::string& axis, DrawnAxis& drawn) {
  const Place first_row{table.path, 1, 0};
  const auto frame = std::ranges::find(table.columns, "frame");
  const auto at = std::ranges::find_if(table.columns, [&](const std::string& column) {
    return unit_of_column(column, axis, drawn.unit).has_value();
  });
  if (frame == table.columns.end() || at == table.columns.end()) {
    throw InputError(first_row,
                     fmt::format("the first row names no column {}; name the columns, with commas between "
                                 "them, as in frame,{}",
                                 in_quotes(frame == table.columns.end() ? "frame" : axis), axis));
  }
  drawn.unit = *unit_of_column(*at, axis, drawn.unit);
  return {static_cast<std::size_t>(frame - table.columns.begin()),
          static_cast<std::size_t>(at - table.columns.begin())};
}

/// A row without a number for the axis is one on which another axis is drawn.
void read_csv(const CsvTable& table, const std::string& axis, std::int32_t frames, DrawnAxis& drawn) {
  const auto [frame_column, at_column] = find_columns(table, axis, drawn);
  for (const CsvRow& row : table.rows) {
    if (row.fields[at_column].empty()) continue;
    const Place place = table.place_of(row);
    const double frame = csv_number(table, row, frame_column);
    if (frame != std::floor(frame) || frame < 0 || frame > frames) {
      throw InputError(place, fmt::format("frame {:.10g} is none of the move; write a whole number from 0 "
                                          "to {}",
                                          frame, frames));
    }
    add_point(drawn, static_cast<std::int32_t>(frame), csv_number(table, row, at_column), place, place);
  }
  refuse_unfinished(drawn, frames, {table.path, table.rows.empty() ? 1 : table.rows.back().line, 0});
}

/// The columns tip.x, tip.y and tip.z, in metres. All three have the same frames.
void read_csv_in_space(const CsvTable& table, const std::string& tip, std::int32_t frames,
                       std::span<DrawnAxis> drawn) {
  for (std::size_t c = 0; c < drawn.size(); ++c) {
    DrawnAxis& coordinate = drawn[c];
    read_csv(table, coordinate_name(tip, c), frames, coordinate);
    for (std::size_t i = 0; i < coordinate.at.size(); ++i)
      coordinate.at[i] = world_metres(coordinate.at[i], coordinate.unit, coordinate.places[i]);
    const auto [here, first] = std::ranges::mismatch(coordinate.frames, drawn[0].frames);
    if (here == coordinate.frames.end() && first == drawn[0].frames.end()) continue;
    throw InputError(coordinate.places[static_cast<std::size_t>(here - coordinate.frames.begin())],
                     fmt::format("frame {} has one of {} and {} alone; give every row that draws a point all "
                                 "three numbers",
                                 std::min(*here, *first), coordinate_name(tip, 0), coordinate_name(tip, c)));
  }
}

/// What is drawn of an entry of the row: one curve of an axis, three of a point.
void read_drawn(const TomlValue& curve, std::size_t index, std::int32_t frames, const TextReader& read,
                const MoveTrack& track, MoveNetwork& network) {
  const std::string& name = row_of(track)[index];
  const std::size_t curves = track.space ? world_coordinates : 1;
  const MoveUnit unit_of_axes = track.units.empty() ? MoveUnit::of_rig : track.units[index];
  const std::size_t first = network.drawn.size();
  for (std::size_t c = 0; c < curves; ++c) {
    DrawnAxis& axis = network.drawn.emplace_back();
    axis.axis = curves * index + c;
    axis.unit = track.space ? track.space->unit : unit_of_axes;
  }
  const std::span<DrawnAxis> drawn = std::span(network.drawn).subspan(first);
  if (curve.node().is_array()) return read_points(curve, frames, track, drawn);
  const std::string path = path_beside(curve);
  const CsvTable table = parse_csv(read(path, max_file_bytes), path);
  if (std::ranges::count(network.files, table.path) == 0) network.files.push_back(table.path);
  if (track.space) return read_csv_in_space(table, name, frames, drawn);
  read_csv(table, name, frames, drawn.front());
}

}  // namespace

std::string path_beside(const TomlValue& value) {
  const std::string name = value.text();
  if (name.find('/') != std::string::npos) {
    value.refuse(fmt::format("is {}; put the file beside that of the move, and write its name alone",
                             in_quotes(name)));
  }
  return (std::filesystem::path(value.place().file).parent_path() / name).string();
}

std::optional<MoveUnit> unit_of_column(const std::string& column, const std::string& axis,
                                       MoveUnit otherwise) {
  if (column == axis) return otherwise;
  for (std::size_t unit = 0; unit < move_unit_words.size(); ++unit) {
    if (column == fmt::format("{} ({})", axis, move_unit_words.at(unit)))
      return static_cast<MoveUnit>(unit + 1);
  }
  if (column == fmt::format("{} ({})", axis, to_string(AxisUnit::unit))) return MoveUnit::of_rig;
  return std::nullopt;
}

void read_network(const TomlTable& table, std::int32_t frames, const TextReader& read, MoveTrack& track) {
  const auto network = table.optional("network");
  if (!network || !network->boolean()) {
    return table.refuse_any({"places", "drawn"}, "belongs to a network; add network = true, or remove it");
  }
  refuse_other_curves(table, *network, track);
  refuse_other_keys(table, track);
  MoveNetwork made{.places = read_places(table, track), .drawn = {}, .place = network->place()};
  const std::string_view example = track.space ? R"(drawn = { NAME_OF_A_POINT = "curve.csv" })"
                                               : R"(drawn = { NAME_OF_AN_AXIS = "curve.csv" })";
  const TomlValue drawn = table.required("drawn", example);
  const std::vector<std::string>& row = row_of(track);
  const std::vector<std::string_view> names(row.begin(), row.end());
  const TomlTable curves(drawn.table(), "drawn", names);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto value = curves.optional(names[i]);
    if (!value) continue;
    read_drawn(TomlValue(value->node(), fmt::format("drawn.{}", names[i])), i, frames, read, track, made);
  }
  if (made.drawn.empty()) {
    drawn.refuse(
        fmt::format("names no {}; write {}, or remove network", track.space ? "point" : "axis", example));
  }
  track.network = std::move(made);
}

void check_network_keys(const MoveTrack& track, std::int32_t frames) {
  if (track.keys.size() < 2) {
    throw InputError(track.network->place, fmt::format("a network goes from key to key and has one; write "
                                                       "two or more, the first on frame 0, the last on {}",
                                                       frames));
  }
  for (std::size_t k = 0; k < track.keys.size(); ++k) {
    const MoveKey& key = track.keys[k];
    if (key.hold || key.ease || key.breaks) {
      throw InputError(key.place,
                       fmt::format("key {} has hold, ease or break, which belong to a speed curve; remove "
                                   "them",
                                   k));
    }
    if (!key.frame) throw InputError(key.place, fmt::format("key {} has no frame; give it one", k));
    if (k > 0 && *key.frame <= *track.keys[k - 1].frame) {
      throw InputError(key.frame_place, fmt::format("key {} is on frame {}, and the key before on {}; write "
                                                    "the keys in order",
                                                    k, *key.frame, *track.keys[k - 1].frame));
    }
    const bool is_first = k == 0;
    const bool is_last = k + 1 == track.keys.size();
    if ((!is_first && !is_last) || *key.frame == (is_first ? 0 : frames)) continue;
    throw InputError(key.frame_place,
                     fmt::format("the {} key is on frame {}; write it on frame {}",
                                 is_first ? "first" : "last", *key.frame, is_first ? 0 : frames));
  }
}

}  // namespace inbetween
