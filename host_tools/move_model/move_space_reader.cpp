#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "host_tools/move_model/move_readers.hpp"
#include "host_tools/rig_model/move_unit.hpp"

namespace inbetween {
namespace {

/// Metres. The farthest that the geometry of a rig goes.
constexpr double max_place = 1e6;

/// The length unit of numbers in the world.
MoveUnit length_unit_of(const TomlTable& table, MoveUnit otherwise) {
  const auto unit = table.optional("unit");
  if (!unit) return otherwise;
  const auto chosen = static_cast<MoveUnit>(unit->choice(move_unit_words) + 1);
  if (!converted(1, chosen, AxisUnit::m)) unit->refuse("is not a length; write m, mm, cm, in or ft");
  return chosen;
}

void read_place(const TomlValue& value, MoveUnit unit, MoveKey& key) {
  for (const WorldNumber& number : read_world_place(value, unit)) {
    key.at.push_back(number.metres);
    key.at_places.push_back(number.place);
  }
}

void refuse_in_space(const TomlTable& table, std::initializer_list<std::string_view> fields) {
  table.refuse_any(fields, "is for axes, and the keys of this track are places in the world; remove it");
}

/// One link, or the row of a network.
std::vector<std::string> read_tips(const TomlTable& table, const TomlValue& space) {
  const auto network = table.optional("network");
  const bool is_row = network && network->boolean();
  if (!space.node().is_array()) {
    if (!is_row) return {space.text()};
    space.refuse(R"(names one tip, and a network has a row of them; write space = ["left", "right"], say)");
  }
  if (!is_row) {
    space.refuse(
        "is a row of points, of which a network is made; add network = true, or name one tip and give the "
        "others tracks of their own");
  }
  std::vector<std::string> tips;
  for (const TomlValue& name : space.list(max_track_axes)) {
    if (std::ranges::find(tips, name.text()) != tips.end()) {
      name.refuse(fmt::format("is {} again; name each point of the row once", in_quotes(name.text())));
    }
    tips.push_back(name.text());
  }
  return tips;
}

void read_near(const TomlTable& table, MoveTrack& track) {
  const auto near = table.optional("near");
  if (!near) return;
  const std::vector<std::string_view> names(track.axes.begin(), track.axes.end());
  const TomlTable values(near->table(), near->name(), names);
  for (const std::string_view name : names) {
    const auto value = values.optional(name);
    track.space->near.push_back(value ? std::optional(value->number()) : std::nullopt);
  }
}

/// The point of a row where nothing is said of it: on its drawn curve, or where it was at the key before.
void leave_out(const TomlValue& at, const MoveTrack& track, std::size_t point, MoveKey& key) {
  const auto is_of_point = [&](const DrawnAxis& drawn) { return drawn.axis / world_coordinates == point; };
  const bool is_drawn = std::ranges::any_of(track.network->drawn, is_of_point);
  if (!is_drawn && track.keys.empty()) {
    at.refuse(
        fmt::format("leaves out point {}, which has no key before to keep its place from; name every "
                    "point in the first key",
                    in_quotes(track.space->tips[point])));
  }
  key.is_left_out.resize(world_coordinates * track.space->tips.size());
  for (std::size_t c = world_coordinates * point; c < world_coordinates * (point + 1); ++c) {
    key.at.push_back(is_drawn ? 0 : track.keys.back().at[c]);
    key.at_places.push_back(at.place());
    key.is_left_out[c] = is_drawn;
  }
}

}  // namespace

std::array<WorldNumber, world_coordinates> read_world_place(const TomlValue& value, MoveUnit unit) {
  const std::vector<TomlValue> numbers = value.list(max_track_axes);
  if (numbers.size() != world_coordinates) {
    value.refuse(fmt::format("has {}; write three, x, y and z in the world",
                             counted(static_cast<std::int64_t>(numbers.size()), "number")));
  }
  std::array<WorldNumber, world_coordinates> place;
  for (std::size_t c = 0; c < world_coordinates; ++c)
    place.at(c) = {world_metres(numbers[c].number(), unit, numbers[c].place()), numbers[c].place()};
  return place;
}

double world_metres(double number, MoveUnit unit, const Place& place) {
  const std::optional<double> metres = converted(number, unit, AxisUnit::m);
  if (!metres) throw InputError(place, "a place in the world is given as an angle; give it a unit of length");
  if (*metres >= -max_place && *metres <= max_place) return *metres;
  throw InputError(place, fmt::format("{:g} m is more than 1e6 m from the origin; bring it nearer", *metres));
}

void read_row_position(const TomlTable& table, const MoveTrack& track, MoveKey& key) {
  refuse_in_space(table, {"way", "turns"});
  table.refuse_any({"aim", "roll"}, "is for one link, and the points of a row look nowhere; remove it");
  const MoveUnit unit = length_unit_of(table, track.space->unit);
  const TomlValue at = table.required("at", "at = { NAME_OF_A_POINT = [x, y, z] }");
  const std::vector<std::string_view> names(track.space->tips.begin(), track.space->tips.end());
  const TomlTable points(at.table(), at.name(), names);
  for (std::size_t point = 0; point < names.size(); ++point) {
    const auto place = points.optional(names[point]);
    if (place) {
      read_place(*place, unit, key);
    } else {
      leave_out(at, track, point, key);
    }
  }
}

void read_space(const TomlTable& table, MoveTrack& track) {
  const auto space = table.optional("space");
  if (const auto distance = table.optional("distance")) {
    if (space) distance->refuse("is that of the link in space anyway; remove distance");
    track.distance.emplace();
    track.distance->tip = distance->text();
    track.distance->place = distance->place();
  }
  if (!space) {
    return table.refuse_any({"aim", "elbow", "near"},
                            R"(needs keys in the world; add space = "camera", the name of a tip of the rig)");
  }
  MoveSpace& read = track.space.emplace();
  read.tips = read_tips(table, *space);
  read.has_at = space->node().is_array();  // one link: as its keys say
  read.place = read.aim_place = read.elbow_place = space->place();
  refuse_in_space(table, {"wrap"});
  static_cast<void>(length_unit_of(table, MoveUnit::m));
  if (const auto elbow = table.optional("elbow")) {
    track.space->elbow_up = elbow->choice({"up", "down"}) == 0;
    track.space->elbow_place = elbow->place();
  }
  const auto aim = table.optional("aim");
  if (aim && space->node().is_array()) {
    aim->refuse("is for one link, and the points of a row look nowhere; remove it");
  }
  if (aim) {
    track.space->aim_place = aim->place();
    if (aim->node().is_string()) {
      track.space->aim_node = aim->text();
    } else {
      MoveKey fixed;
      read_place(*aim, length_unit_of(table, MoveUnit::m), fixed);
      track.space->fixed_aim = fixed.at;
    }
  }
  read_near(table, track);
  track.space->unit = length_unit_of(table, MoveUnit::m);
}

void read_space_position(const TomlTable& table, std::size_t index, MoveTrack& track, MoveKey& key) {
  refuse_in_space(table, {"way", "turns"});
  MoveSpace& space = *track.space;
  const MoveUnit unit = length_unit_of(table, space.unit);
  const auto at = table.optional("at");
  const auto aim = table.optional("aim");
  const auto roll = table.optional("roll");
  if (index == 0) {
    space.has_at = at.has_value();
    space.has_aim = aim.has_value();
    space.has_roll = roll.has_value();
    if (!at && !aim) {
      throw InputError(table.place(),
                       "key 0 has neither at nor aim; write at = [x, y, z], where the link is, or "
                       "aim = [x, y, z], where it looks");
    }
  }
  if (aim && (space.aim_node || !space.fixed_aim.empty())) {
    aim->refuse("is said by the track already; remove one of the two");
  }
  for (const auto& [name, first_has, has] :
       {std::tuple("at", space.has_at, at.has_value()), std::tuple("aim", space.has_aim, aim.has_value()),
        std::tuple("roll", space.has_roll, roll.has_value())}) {
    if (first_has == has) continue;
    throw InputError(table.place(),
                     fmt::format("key {} has {} {}, and key 0 has {}; give it to all keys or to none", index,
                                 has ? "the field" : "no", name, has ? "none" : "one"));
  }
  if (at) read_place(*at, unit, key);
  if (aim) read_place(*aim, unit, key);
  if (roll) {
    key.at.push_back(roll->number(-360, 360));
    key.at_places.push_back(roll->place());
  }
}

void refuse_space_fields(const TomlTable& table) {
  table.refuse_any(
      {"aim", "roll"},
      R"(needs keys in the world; add space = "camera" to the track, the name of a tip of the rig)");
}

}  // namespace inbetween
