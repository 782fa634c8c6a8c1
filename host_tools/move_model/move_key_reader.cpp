#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "host_tools/move_model/move_readers.hpp"

namespace inbetween {
namespace {

constexpr std::array<std::string_view, 15> key_fields = {"at",      "tension", "continuity", "bias", "frame",
                                                         "overlap", "round",   "break",      "hold", "ease",
                                                         "unit",    "way",     "turns",      "aim",  "roll"};

constexpr std::int64_t max_whole_turns = 1'000'000;

/// Visits what a field says of each axis: a table names some of them, anything else is for all.
template <class Visit>
void by_axis(const TomlValue& value, const std::vector<std::string>& axes, const Visit& visit) {
  if (!value.node().is_table()) {
    for (std::size_t d = 0; d < axes.size(); ++d) visit(d, value);
    return;
  }
  const std::vector<std::string_view> names(axes.begin(), axes.end());
  const TomlTable table(value.table(), value.name(), names);
  for (std::size_t d = 0; d < axes.size(); ++d) {
    if (const auto of_axis = table.optional(names[d])) visit(d, *of_axis);
  }
}

std::vector<MoveUnit> read_units(const TomlTable& table, const MoveTrack& track,
                                 std::vector<MoveUnit> units) {
  const auto value = table.optional("unit");
  if (!value) return units;
  units.resize(track.axes.size());
  by_axis(*value, track.axes, [&](std::size_t d, const TomlValue& unit) {
    units[d] = static_cast<MoveUnit>(unit.choice(move_unit_words) + 1);
  });
  return units;
}

void read_shape(const TomlTable& table, Spline spline, MoveKey& key) {
  const std::array<std::pair<std::string_view, double*>, 3> parameters = {
      {{"tension", &key.tension}, {"continuity", &key.continuity}, {"bias", &key.bias}}};
  for (const auto& [name, parameter] : parameters) {
    const auto value = table.optional(name);
    if (!value) continue;
    if (spline != Spline::tcb) {
      value->refuse(R"(has a meaning only with spline = "tcb"; remove it or change the spline)");
    }
    *parameter = value->number(-1, 1);
  }
}

void read_lock(const TomlTable& table, std::int32_t frames, MoveKey& key) {
  if (const auto frame = table.optional("frame")) {
    key.frame = static_cast<std::int32_t>(frame->integer(0, frames));
    key.frame_place = frame->place();
  }
  if (const auto breaks = table.optional("break")) {
    key.breaks = breaks->boolean();
    if (!key.frame)
      breaks->refuse("needs the frame at which the key is met; add frame = ..., or remove break");
  }
  if (const auto hold = table.optional("hold")) {
    key.hold = static_cast<std::int32_t>(hold->integer(1, frames));
    key.hold_place = hold->place();
  }
  if (const auto ease = table.optional("ease")) {
    key.ease = ease->boolean();
    if (key.ease && key.hold) ease->refuse("is what a hold does anyway; remove one of the two");
    if (key.ease && key.breaks)
      ease->refuse("contradicts break, where the speed jumps; remove one of the two");
  }
}

bool is_drawn(const MoveTrack& track, std::size_t axis) {
  return track.network &&
         std::ranges::find(track.network->drawn, axis, &DrawnAxis::axis) != track.network->drawn.end();
}

/// A list has all coordinates, a table some: an axis that it leaves out is where its drawn curve is, and
/// without one it stays where it is.
void read_position(const TomlTable& table, std::size_t index, const MoveTrack& track, MoveKey& key) {
  const TomlValue at = table.required("at", "at = [...], a number for each axis");
  key.units = read_units(table, track, track.units);
  if (!at.node().is_table()) {
    const std::vector<TomlValue> coordinates = at.list(max_track_axes);
    if (coordinates.size() != track.axes.size()) {
      throw InputError(at.place(),
                       fmt::format("key {} has {}; write {}, one for each of its axes ({}){}", index,
                                   counted(static_cast<std::int64_t>(coordinates.size()), "number"),
                                   track.axes.size(), comma_separated(track.axes),
                                   coordinates.size() > track.axes.size()
                                       ? "; a decimal has a point, 0.5, and a comma begins another number"
                                       : ""));
    }
    for (const TomlValue& coordinate : coordinates) {
      key.at.push_back(coordinate.number());
      key.at_places.push_back(coordinate.place());
    }
    return;
  }
  std::vector<bool> is_named(track.axes.size());
  key.at.assign(track.axes.size(), 0);
  key.at_places.assign(track.axes.size(), at.place());
  by_axis(at, track.axes, [&](std::size_t d, const TomlValue& coordinate) {
    is_named[d] = true;
    key.at[d] = coordinate.number();
    key.at_places[d] = coordinate.place();
  });
  for (std::size_t d = 0; d < track.axes.size(); ++d) {
    if (is_named[d]) continue;
    if (is_drawn(track, d)) {
      key.is_left_out.resize(track.axes.size());
      key.is_left_out[d] = true;
      if (!key.units.empty()) key.units[d] = track.units.empty() ? MoveUnit::of_rig : track.units[d];
      continue;
    }
    if (track.keys.empty()) {
      at.refuse(
          fmt::format("leaves out axis {}, which has no key before to keep its value from; name every "
                      "axis in the first key",
                      in_quotes(track.axes[d])));
    }
    const MoveKey& before = track.keys.back();
    key.at[d] = before.at[d];
    if (key.units.empty() && before.units.empty()) continue;
    key.units.resize(track.axes.size());
    key.units[d] = before.units.empty() ? MoveUnit::of_rig : before.units[d];
  }
}

/// Which way round, of the axes that have a wrap.
void read_way(const TomlTable& table, const MoveTrack& track, MoveKey& key) {
  const auto way = table.optional("way");
  const auto turns = table.optional("turns");
  if (way && turns) turns->refuse("says which way round, and so does way; remove one of the two");
  for (const auto& value : {way, turns}) {
    if (!value) continue;
    key.ways.resize(track.axes.size());
    bool is_of_any = false;
    by_axis(*value, track.axes, [&](std::size_t d, const TomlValue& of_axis) {
      const bool wraps = !track.wraps.empty() && track.wraps[d] > 0;
      if (!wraps && value->node().is_table()) {
        of_axis.refuse(fmt::format("is for an axis that counts round; give the track a wrap for axis {}",
                                   in_quotes(track.axes[d])));
      }
      is_of_any = is_of_any || wraps;
      if (way) {
        key.ways[d].is_long = of_axis.choice({"short", "long"}) == 1;
      } else {
        key.ways[d].turns = static_cast<std::int32_t>(of_axis.integer(-max_whole_turns, max_whole_turns));
      }
    });
    if (!is_of_any) value->refuse("is for an axis that counts round; give the track wrap = 360, say");
  }
}

MoveKey read_key(const TomlValue& value, std::int32_t frames, MoveTrack& track) {
  const std::size_t index = track.keys.size();
  const TomlTable table(value.table(), fmt::format("key {}", index), key_fields);
  MoveKey key;
  key.place = table.place();
  if (is_row_of_points(track)) {
    read_row_position(table, track, key);
  } else if (track.space) {
    read_space_position(table, index, track, key);
  } else {
    refuse_space_fields(table);
    read_position(table, index, track, key);
    read_way(table, track, key);
  }
  read_shape(table, track.spline, key);
  read_lock(table, frames, key);
  const CornerFields corner = read_corner_fields(table, track);
  key.overlap = corner.overlap;
  key.round = corner.round;
  return key;
}

}  // namespace

CornerFields read_corner_fields(const TomlTable& table, const MoveTrack& track) {
  CornerFields fields;
  const bool is_straight = track.spline == Spline::linear;
  const bool is_curve = has_speed_curve(track);
  if (const auto overlap = table.optional("overlap")) {
    if (!is_straight || is_curve || kinetic_of(track) != MoveKinetic::linear) {
      overlap->refuse(
          R"(is for straight lines timed by frames: timing = "frames" and spline = "linear"; with a speed )"
          "curve use round, or remove it");
    }
    fields.overlap = static_cast<std::int32_t>(overlap->integer(0, max_frames));
  }
  if (const auto round = table.optional("round")) {
    if (!is_straight || !is_curve) {
      round->refuse(
          R"(is for a straight path with a speed curve: spline = "linear" without timing = "frames"; with )"
          "keys on frames use overlap, or remove it");
    }
    fields.round = round->number(0, max_magnitude);
  }
  return fields;
}

void read_counting(const TomlTable& table, MoveTrack& track) {
  track.units = read_units(table, track, {});
  const auto wrap = table.optional("wrap");
  if (!wrap) return;
  track.wraps.assign(track.axes.size(), 0);
  by_axis(*wrap, track.axes,
          [&](std::size_t d, const TomlValue& turn) { track.wraps[d] = turn.positive_number(); });
}

void read_keys(const TomlTable& table, std::int32_t frames, MoveTrack& track) {
  const TomlValue keys = table.required("keys", "keys = [ { at = [...] }, ... ]");
  for (const TomlValue& key : keys.tables(max_keys)) track.keys.push_back(read_key(key, frames, track));
  const bool is_returned_to = track.closed && track.keys.size() > 1;
  if (track.keys.front().ways.empty() || is_returned_to) return;
  throw InputError(track.keys.front().place,
                   "the first key has a way or turns, and nothing leads there; remove them, or make the path "
                   "closed, with two keys or more");
}

}  // namespace inbetween
