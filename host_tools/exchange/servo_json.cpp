#include "host_tools/exchange/servo_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "host_tools/exchange/placed_json.hpp"
#include "host_tools/exchange/table_text.hpp"

namespace inbetween {
namespace {

std::int32_t servo_id(const JsonValue& servo) {
  const std::string& key = servo.key();
  const bool is_number =
      !key.empty() && key.size() <= 3 && key.find_first_not_of("0123456789") == std::string::npos;
  if (!is_number || std::stoi(key) > max_servo_id) {
    servo.refuse(
        fmt::format("{} is no number of a servo; write one from 0 to {}", in_quotes(key), max_servo_id));
  }
  return std::stoi(key);
}

double servo_position(const JsonValue& value) {
  return static_cast<double>(value.whole_number("a position", -max_servo_position, max_servo_position));
}

BakedColumn& add_servo(const JsonValue& servo, BakedTable& table) {
  if (table.columns.size() == static_cast<std::size_t>(max_servo_id) + 1) {
    servo.refuse(fmt::format("the file has more than {} servos; leave some out", max_servo_id + 1));
  }
  BakedColumn& column = table.columns.emplace_back();
  column.channel = servo_id(servo);
  column.name = fmt::format("servo {}", *column.channel);
  column.is_in_counts = true;
  column.decimals = 0;
  return column;
}

void take_servos(const JsonValue& servos, std::int64_t frames, BakedTable& table) {
  std::vector<std::string> names;
  for (const JsonValue& servo : servos.items()) {
    BakedColumn& column = add_servo(servo, table);
    const auto name = servo.find("name");
    names.push_back(name ? name->text("name") : "");
    const JsonValue positions = servo.required("positions", "\"positions\": [1500, 1510]");
    if (positions.kind() != JsonKind::array) positions.refuse("\"positions\" is no list; write [1500, 1510]");
    for (const JsonValue& position : positions.items()) column.values.push_back(servo_position(position));
    if (static_cast<std::int64_t>(column.values.size()) != frames) {
      positions.refuse(fmt::format(
          "servo {} has {}, and \"frames\" is {}; write one for each frame", in_quotes(servo.key()),
          counted(static_cast<std::int64_t>(column.values.size()), "position"), frames));
    }
  }
  // Bones may share a name, or have none: then their numbers tell them apart.
  const std::set<std::string> different(names.begin(), names.end());
  if (different.size() != names.size() || different.contains("")) return;
  for (std::size_t i = 0; i < names.size(); ++i) table.columns[i].name = names[i];
}

void take_positions(const JsonValue& positions, std::int64_t frames, BakedTable& table) {
  const std::vector<JsonValue> rows = positions.items();
  if (static_cast<std::int64_t>(rows.size()) != frames) {
    positions.refuse(
        fmt::format("\"positions\" has {}, and \"frames\" is {}; correct \"frames\", or write what "
                    "is missing",
                    counted(static_cast<std::int64_t>(rows.size()), "frame"), frames));
  }
  std::map<std::string, std::size_t> of_id;
  for (const JsonValue& row : rows) {
    if (row.kind() != JsonKind::object) row.refuse(R"(a frame is no object; write { "0": 1500 })");
    const std::vector<JsonValue> servos = row.items();
    if (of_id.empty()) {
      for (const JsonValue& servo : servos) {
        add_servo(servo, table);
        of_id.emplace(servo.key(), table.columns.size() - 1);
      }
    }
    if (servos.size() != of_id.size()) {
      row.refuse(fmt::format("this frame has {}, and the first has {}; write the same on each",
                             counted(static_cast<std::int64_t>(servos.size()), "servo"), of_id.size()));
    }
    for (const JsonValue& servo : servos) {
      const auto found = of_id.find(servo.key());
      if (found == of_id.end()) {
        servo.refuse(
            fmt::format("the first frame has no servo {}; write the same on each", in_quotes(servo.key())));
      }
      table.columns[found->second].values.push_back(servo_position(servo));
    }
  }
}

void check_said(const JsonValue& root, std::int64_t frames, const BakedTable& table) {
  if (const auto bones = root.find("bones")) {
    const std::int64_t said = bones->whole_number("\"bones\"", 0, max_servo_id + 1);
    if (said != static_cast<std::int64_t>(table.columns.size())) {
      bones->refuse(fmt::format("\"bones\" is {}, and {} are there; correct one of the two", said,
                                table.columns.size()));
    }
  }
  const auto seconds = root.find("seconds");
  if (!seconds) return;
  // Rounded to a whole number in either direction.
  const double rate = table.fps ? table.fps->frames_per_second() : *table.about_fps;
  const double expected = static_cast<double>(frames) / rate;
  if (std::fabs(seconds->number("\"seconds\"") - expected) <= 1) return;
  seconds->refuse(
      fmt::format("\"seconds\" is {}, and {} at {} a second last {:.3g} s; correct one of the three",
                  seconds->number("\"seconds\""), counted(frames, "frame"), rate, expected));
}

}  // namespace

BakedTable read_servo_json(std::string_view text, const std::string& file) {
  const PlacedJson document(text, file);
  const JsonValue root = document.root();
  BakedTable table{.file = file};
  const JsonValue fps = root.required("fps", "\"fps\": 25");
  take_rate(fps.number("\"fps\""), fps.place(), table);
  const std::int64_t frames = root.required("frames", "\"frames\": 100")
                                  .whole_number("\"frames\"", 0, static_cast<std::int64_t>(max_table_rows));
  const auto servos = root.find("servos");
  const auto positions = root.find("positions");
  if (servos.has_value() == positions.has_value()) {
    root.refuse(R"(either "servos" or "positions" has the motion; write one of the two)");
  }
  if (servos && servos->kind() != JsonKind::object)
    servos->refuse(R"("servos" is no object; write { "0": {...} })");
  if (positions && positions->kind() != JsonKind::array)
    positions->refuse(R"("positions" is no list; write [{ "0": 1500 }])");
  if (servos) take_servos(*servos, frames, table);
  if (positions) take_positions(*positions, frames, table);
  check_table(table);
  check_said(root, frames, table);
  return table;
}

std::string write_servo_json(const BakedTable& table) {
  check_written(table);
  if (!table.fps || table.fps->denominator != 1) {
    throw InputError({table.file}, "a file of servos has a whole number of frames a second; say one");
  }
  std::set<std::int32_t> taken;
  for (const BakedColumn& column : table.columns) {
    if (!column.channel) continue;
    const bool is_free = taken.insert(*column.channel).second;
    if (!is_free || *column.channel < 0 || *column.channel > max_servo_id) {
      throw InputError({table.file},
                       fmt::format("{} has number {}; give each servo one of its own from 0 to {}",
                                   in_quotes(column.name), *column.channel, max_servo_id));
    }
  }
  nlohmann::ordered_json servos = nlohmann::ordered_json::object();
  std::int32_t free = 0;
  for (const BakedColumn& column : table.columns) {
    std::int32_t id = column.channel.value_or(free);
    while (!column.channel && !taken.insert(id).second) id = ++free;
    if (id > max_servo_id) {
      throw InputError({table.file},
                       fmt::format("a file of servos has at most {}; leave some axes out", max_servo_id + 1));
    }
    nlohmann::ordered_json positions = nlohmann::ordered_json::array();
    for (std::size_t row = 0; row < column.values.size(); ++row) {
      if (std::fabs(column.values[row]) > static_cast<double>(max_servo_position)) {
        throw InputError(table.place_of(row),
                         fmt::format("{} is at {}, which is no count of a servo; say what a "
                                     "count is",
                                     in_quotes(column.name), column.values[row]));
      }
      positions.push_back(std::llround(column.values[row]));
    }
    servos[fmt::format("{}", id)] = {{"name", column.name}, {"positions", std::move(positions)}};
  }
  const auto frames = static_cast<std::int64_t>(table.rows());
  // Python's round() goes to the even number, as nearbyint does.
  const auto seconds =
      static_cast<std::int64_t>(std::nearbyint(static_cast<double>(frames) / table.fps->frames_per_second()));
  const nlohmann::ordered_json all = {{"description", "Blender Servo Animation Positions"},
                                      {"fps", table.fps->numerator},
                                      {"frames", frames},
                                      {"seconds", seconds},
                                      {"bones", table.columns.size()},
                                      {"armature", ""},
                                      {"file", ""},
                                      {"scene", ""},
                                      {"servos", std::move(servos)}};
  return all.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace inbetween
