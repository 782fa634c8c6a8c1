#include "host_tools/rig_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <utility>

#include "host_tools/toml_source.hpp"
#include "host_tools/toml_value.hpp"

namespace inbetween {
namespace {

constexpr std::array<std::string_view, 4> rig_fields = {"name", "rate_hz", "bus", "axis"};
constexpr std::array<std::string_view, 1> bus_fields = {"bitrate"};
constexpr std::array<std::string_view, 11> axis_fields = {"name",
                                                          "unit",
                                                          "min",
                                                          "max",
                                                          "max_velocity",
                                                          "max_acceleration",
                                                          "max_jerk",
                                                          "max_acceleration_step",
                                                          "stop_acceleration",
                                                          "stop_jerk",
                                                          "drive"};
constexpr std::array<std::string_view, 4> cia402_fields = {"type", "bus", "node", "counts_per_unit"};
constexpr std::array<std::string_view, 4> turns_fields = {"type", "bus", "node", "turns_per_unit"};
constexpr std::array<std::string_view, 6> step_dir_fields = {"type", "chip",   "step",
                                                             "dir",  "enable", "steps_per_unit"};
constexpr std::array<std::string_view, 3> pipe_fields = {"type", "path", "counts_per_unit"};

constexpr std::array<std::string_view, 6> unit_names = {"mm", "m", "deg", "rad", "turn", "unit"};

/// Who has taken what: axis names, nodes of a bus, lines of a chip. The text says which.
using Taken = std::map<std::string, Place>;

void take(Taken& taken, const TomlValue& value, const std::string& what, std::string_view remedy) {
  const auto [earlier, is_new] = taken.emplace(what, value.place());
  if (!is_new)
    value.refuse(fmt::format("is {}, which line {} has already; {}", what, earlier->second.line, remedy));
}

std::vector<Bus> read_buses(const TomlTable& rig) {
  std::vector<Bus> buses;
  const auto section = rig.optional("bus");
  if (!section) return buses;
  for (const auto& [key, node] : section->table()) {
    const TomlValue value(node, fmt::format("bus {}", in_quotes(key.str())));
    const TomlTable table(value.table(), value.name(), bus_fields);
    // What Linux allows as the name of a network interface (IFNAMSIZ, dev_valid_name).
    const std::string_view name = key.str();
    const bool is_interface_name = !name.empty() && name.size() <= 15 && name != "." && name != ".." &&
                                   std::all_of(name.begin(), name.end(), [](char c) {
                                     return c > ' ' && c < 0x7f && c != '/' && c != ':';
                                   });
    if (!is_interface_name) value.refuse("is not a network interface; write a name such as can0");
    buses.push_back({std::string(name),
                     table.required("bitrate", "bitrate = 1_000_000").integer(10'000, 1'000'000),
                     table.place()});
  }
  return buses;
}

/// What reading one drive needs to know about the rig so far.
struct RigContext {
  std::span<const Bus> buses;
  Taken& taken;
};

struct CanAddress {
  std::string bus;
  int node;
};

struct NodeRange {
  int least;
  int most;
};

CanAddress read_can_address(const TomlTable& table, NodeRange range, const RigContext& rig) {
  const TomlValue bus = table.required("bus", R"(the CAN bus, bus = "can0")");
  CanAddress address{bus.text(), 0};
  const auto is_the_bus = [&](const Bus& known) { return known.name == address.bus; };
  if (std::none_of(rig.buses.begin(), rig.buses.end(), is_the_bus)) {
    bus.refuse(fmt::format("is {}, which the rig does not have; add a [bus.NAME] for it with its bitrate",
                           in_quotes(address.bus)));
  }
  const TomlValue node = table.required("node", "the node id of the drive, node = 1");
  address.node = static_cast<int>(node.integer(range.least, range.most));
  take(rig.taken, node, fmt::format("node {} of bus {}", address.node, address.bus),
       "give each drive its own");
  return address;
}

/// A scale in drive units per axis unit; both ends of the axis must stay within `most` drive units of 0.
double read_scale(const TomlTable& table, std::string_view field, const RigAxis& axis, double most) {
  const TomlValue value = table.required(field, fmt::format("{} = 1000.0, say", field));
  const double scale = value.number();
  if (scale == 0) value.refuse("is 0; write a positive number, or a negative one to reverse the motor");
  const std::string_view counted = field.substr(0, field.find('_'));
  for (const double end : {axis.min, axis.max}) {
    const double position = end * scale;
    if (std::abs(std::round(position)) > most) {
      value.refuse(
          fmt::format("is {}, so that {} {} is {:.15g} {}, beyond {:.15g}; lower the scale or the range",
                      scale, end, to_string(axis.unit), position, counted, most));
    }
  }
  return scale;
}

double read_count_scale(const TomlTable& table, std::string_view field, const RigAxis& axis) {
  return read_scale(table, field, axis, std::numeric_limits<std::int32_t>::max());
}

GpioLine read_line(const TomlValue& value, const std::string& chip, Taken& taken) {
  constexpr std::string_view remedy = "use each line once";
  if (value.node().is_string()) {
    std::string name = value.text();
    take(taken, value, fmt::format("line {} of chip {}", in_quotes(name), in_quotes(chip)), remedy);
    return name;
  }
  const auto offset = static_cast<int>(value.integer(0, max_line_offset));
  take(taken, value, fmt::format("line {} of chip {}", offset, in_quotes(chip)), remedy);
  return offset;
}

std::string read_chip(const TomlTable& table) {
  const TomlValue value = table.required("chip", R"(the label of the GPIO chip, chip = "pinctrl-bcm2711")");
  std::string chip = value.text();
  std::string_view number = chip;
  for (const std::string_view prefix : {"/dev/", "gpiochip"}) {
    if (number.starts_with(prefix)) number.remove_prefix(prefix.size());
  }
  if (number.find_first_not_of("0123456789") == number.npos) {
    value.refuse(fmt::format("is {}, a number that may change at every start; write the chip's label",
                             in_quotes(chip)));
  }
  return chip;
}

StepDirDrive read_step_dir(const TomlTable& table, const RigAxis& axis, const RigContext& rig) {
  StepDirDrive drive;
  drive.chip = read_chip(table);
  drive.step = read_line(table.required("step", "the step line, by offset or name"), drive.chip, rig.taken);
  drive.dir =
      read_line(table.required("dir", "the direction line, by offset or name"), drive.chip, rig.taken);
  if (const auto enable = table.optional("enable")) drive.enable = read_line(*enable, drive.chip, rig.taken);
  drive.steps_per_unit = read_count_scale(table, "steps_per_unit", axis);
  return drive;
}

Drive read_drive(const TomlValue& value, const RigAxis& axis, const RigContext& rig) {
  const toml::table& fields = value.table();
  const toml::node* type = fields.get("type");
  if (type == nullptr) {
    value.refuse(R"(has no type; add type = "cia402", "odrive", "moteus", "step-dir" or "pipe")");
  }
  switch (TomlValue(*type, "type").choice({"cia402", "odrive", "moteus", "step-dir", "pipe"})) {
    case 0: {
      const TomlTable table(fields, "a cia402 drive", cia402_fields);
      const auto [bus, node] = read_can_address(table, {1, 127}, rig);
      return Cia402Drive{bus, node, read_count_scale(table, "counts_per_unit", axis)};
    }
    case 1: {
      const TomlTable table(fields, "an odrive drive", turns_fields);
      const auto [bus, node] = read_can_address(table, {0, 63}, rig);
      return OdriveDrive{bus, node, read_scale(table, "turns_per_unit", axis, max_turns)};
    }
    case 2: {
      const TomlTable table(fields, "a moteus drive", turns_fields);
      const auto [bus, node] = read_can_address(table, {1, 127}, rig);
      return MoteusDrive{bus, node, read_scale(table, "turns_per_unit", axis, max_turns)};
    }
    case 3:
      return read_step_dir(TomlTable(fields, "a step-dir drive", step_dir_fields), axis, rig);
    default:
      break;
  }
  const TomlTable table(fields, "a pipe drive", pipe_fields);
  const TomlValue path = table.required("path", "the FIFO or serial port, path = \"...\"");
  return PipeDrive{path.text(), read_count_scale(table, "counts_per_unit", axis)};
}

void read_limits(const TomlTable& table, RigAxis& axis) {
  axis.min = table.required("min", "the lowest position, min = 0.0").number();
  const TomlValue max = table.required("max", "the highest position, max = 1500.0");
  axis.max = max.number();
  if (axis.min >= axis.max) {
    max.refuse(fmt::format("is {}, not above min = {}; write min < max", axis.max, axis.min));
  }
  axis.max_velocity = table.required("max_velocity", "max_velocity = 400.0 (unit/s), say").positive_number();
  axis.max_acceleration =
      table.required("max_acceleration", "max_acceleration = 800.0 (unit/s^2), say").positive_number();
  const auto limit = [&](std::string_view field) -> std::optional<double> {
    const auto value = table.optional(field);
    return value ? std::optional(value->positive_number()) : std::nullopt;
  };
  axis.max_jerk = limit("max_jerk");
  axis.max_acceleration_step = limit("max_acceleration_step");
  // A stop begins in the midst of the motion: what the motion may do, the stop must be able to do.
  const auto stop_limit = [&](std::string_view field, std::string_view motion_field,
                              const std::optional<double>& motion) {
    const auto value = limit(field);
    if (value && motion && *value < *motion) {
      table.optional(field)->refuse(fmt::format("is {}, below {} = {}; write {} or more, or leave it out",
                                                *value, motion_field, *motion, *motion));
    }
    return value;
  };
  axis.stop_acceleration = stop_limit("stop_acceleration", "max_acceleration", axis.max_acceleration);
  axis.stop_jerk = stop_limit("stop_jerk", "max_jerk", axis.max_jerk);
}

RigAxis read_axis(const TomlValue& value, const RigContext& rig) {
  const TomlTable table(value.table(), "an axis", axis_fields);
  RigAxis axis;
  axis.place = table.place();
  const TomlValue name = table.required("name", R"(name = "track", say)");
  axis.name = name.text();
  take(rig.taken, name, fmt::format("axis {}", in_quotes(axis.name)), "give each axis its own name");
  axis.unit =
      static_cast<AxisUnit>(table.required("unit", R"(unit = "mm", "m", "deg", "rad", "turn" or "unit")")
                                .choice({unit_names[0], unit_names[1], unit_names[2], unit_names[3],
                                         unit_names[4], unit_names[5]}));
  read_limits(table, axis);
  axis.drive = read_drive(table.required("drive", R"(drive = { type = ... })"), axis, rig);
  return axis;
}

void refuse_inexact_cia402_rate(const RigFile& rig, const TomlValue& rate) {
  const auto is_cia402 = [](const RigAxis& axis) { return std::holds_alternative<Cia402Drive>(axis.drive); };
  if (is_cia402_rate(rig.rate_hz) || std::none_of(rig.axes.begin(), rig.axes.end(), is_cia402)) return;
  // 1 Hz and max_rate_hz are exact, so both searches end.
  std::int32_t below = rig.rate_hz;
  std::int32_t above = rig.rate_hz;
  while (!is_cia402_rate(below)) --below;
  while (!is_cia402_rate(above)) ++above;
  rate.refuse(fmt::format(
      "is {}, whose period CiA 402 cannot state exactly (60C2, whole microseconds); write {} or {}",
      rig.rate_hz, below, above));
}

}  // namespace

std::string_view to_string(AxisUnit unit) {
  return unit_names.at(static_cast<std::size_t>(unit));
}

bool is_cia402_rate(std::int32_t rate_hz) {
  if (rate_hz < 1 || 1'000'000 % rate_hz != 0) return false;
  std::int32_t period = 1'000'000 / rate_hz;  // microseconds
  while (period % 10 == 0) period /= 10;
  return period <= 255;
}

RigFile parse_rig(std::string_view text, const std::string& file_name) {
  const toml::table root = parse_toml(text, file_name);
  if (root.empty()) {
    throw InputError(place_of(root), "the file is empty; a rig has name, rate_hz and an [[axis]]");
  }
  const TomlTable table(root, "the rig", rig_fields);
  RigFile rig;
  rig.path = file_name;
  rig.name = table.required("name", R"(name = "what the rig is called")").text();
  const TomlValue rate = table.required("rate_hz", "rate_hz = 250, say");
  rig.rate_hz = static_cast<std::int32_t>(rate.integer(1, max_rate_hz));
  rig.buses = read_buses(table);
  Taken taken;
  for (const TomlValue& axis :
       table.required("axis", "an [[axis]] with its limits and drive").tables(max_rig_axes)) {
    rig.axes.push_back(read_axis(axis, {rig.buses, taken}));
  }
  refuse_inexact_cia402_rate(rig, rate);
  return rig;
}

RigFile read_rig_file(const std::filesystem::path& path) {
  return parse_rig(read_text_file(path), path.string());
}

}  // namespace inbetween
