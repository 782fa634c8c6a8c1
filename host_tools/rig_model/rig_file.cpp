#include "host_tools/rig_model/rig_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "host_tools/rig_model/gpio_line_reader.hpp"
#include "host_tools/rig_model/rig_dragonframe_reader.hpp"
#include "host_tools/rig_model/rig_lens_reader.hpp"
#include "host_tools/rig_model/rig_motors.hpp"
#include "host_tools/rig_model/rig_readers.hpp"
#include "host_tools/text/toml_source.hpp"
#include "host_tools/text/toml_value.hpp"
#include "inbetween/limits/limits.hpp"

namespace inbetween {
namespace {

constexpr std::array<std::string_view, 12> rig_fields = {
    "name",          "rate_hz", "step_watch_us", "bus",        "axis", "emergency_stop",
    "start_trigger", "camera",  "output",        "kinematics", "lens", "dragonframe"};
constexpr std::array<std::string_view, 2> bus_fields = {"bitrate", "data_bitrate"};
/// CAN FD transceivers carry no more.
constexpr std::int64_t max_data_bitrate = 8'000'000;
constexpr std::array<std::string_view, 23> axis_fields = {"name",
                                                          "unit",
                                                          "min",
                                                          "max",
                                                          "max_velocity",
                                                          "max_acceleration",
                                                          "max_jerk",
                                                          "max_acceleration_step",
                                                          "stop_acceleration",
                                                          "stop_jerk",
                                                          "drive",
                                                          "offset",
                                                          "calibration",
                                                          "backlash",
                                                          "ganged",
                                                          "max_skew",
                                                          "unpowered",
                                                          "coasts",
                                                          "on_host_lost",
                                                          "reference",
                                                          "home",
                                                          "limit_min",
                                                          "limit_max"};
constexpr std::array<std::string_view, 4> input_fields = {"chip", "line", "active", "bias"};
constexpr std::array<std::string_view, 4> emergency_stop_fields = {"chip", "line", "stops_at", "bias"};
constexpr std::array<std::string_view, 4> camera_fields = {"chip", "line", "idle", "asks"};
constexpr std::array<std::string_view, 3> output_fields = {"chip", "line", "idle"};
constexpr std::array<std::string_view, 4> kinematics_fields = {"urdf", "tip", "limits", "at"};

constexpr std::array<std::string_view, 3> reference_names = {"drive", "operator", "home"};
/// The name by which cues call the shutter of the camera.
constexpr std::string_view camera_name = "camera";

std::vector<Bus> read_buses(const TomlTable& rig) {
  std::vector<Bus> buses;
  const auto section = rig.optional("bus");
  if (!section) return buses;
  for (const auto& [key, node] : section->table()) {
    const TomlValue value(node, fmt::format("bus {}", in_quotes(key.str())));
    const TomlTable table(value.table(), value.name(), bus_fields);
    // Linux allows these names for a network interface (IFNAMSIZ, dev_valid_name).
    const std::string_view name = key.str();
    const bool is_interface_name = !name.empty() && name.size() <= 15 && name != "." && name != ".." &&
                                   std::all_of(name.begin(), name.end(), [](char c) {
                                     return c > ' ' && c < 0x7f && c != '/' && c != ':';
                                   });
    if (!is_interface_name) value.refuse("is not a network interface; write a name such as can0");
    Bus bus{.name = std::string(name),
            .bitrate = table.required("bitrate", "bitrate = 1_000_000").integer(10'000, 1'000'000),
            .data_bitrate = {},
            .place = table.place()};
    if (const auto data = table.optional("data_bitrate")) {
      bus.data_bitrate = data->integer(bus.bitrate, max_data_bitrate);
    }
    buses.push_back(std::move(bus));
  }
  return buses;
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
  // A stop begins within the motion, so its limits must not be below those of the motion.
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

/// A moteus proves by its home state that it knows its place. Any other drive may have forgotten turns, and
/// nothing that it tells shows that.
bool proves_its_place(const RigAxis& axis) {
  const auto is_moteus = [](const Drive& drive) { return std::holds_alternative<MoteusDrive>(drive); };
  return is_moteus(axis.drive) &&
         std::ranges::all_of(axis.ganged, [&](const GangedMotor& motor) { return is_moteus(motor.drive); });
}

void read_reference(const TomlTable& table, RigAxis& axis) {
  const bool open_loop = is_open_loop(axis.drive);
  const bool has_home = axis.home || axis.drive_home;
  axis.reference = has_home                 ? Reference::by_home
                   : proves_its_place(axis) ? Reference::by_drive
                                            : Reference::by_operator;
  const auto value = table.optional("reference");
  if (!value) return;
  const auto reference = static_cast<Reference>(value->choice(reference_names));
  if (reference == Reference::by_drive && open_loop) {
    value->refuse(R"(is "drive", but nothing reports where this axis is; write "operator", or add a home)");
  }
  if ((reference == Reference::by_home) != has_home) {
    value->refuse(has_home ? fmt::format(R"(is "{}", but the axis has a home; remove one of the two)",
                                         to_string(reference))
                           : R"(is "home", but the axis has none; add home = { ... } or write "operator")");
  }
  axis.reference = reference;
}

void read_loss_of_power(const TomlTable& table, RigAxis& axis) {
  if (const auto value = table.optional("unpowered")) {
    axis.unpowered = Unpowered{.holds = value->choice({"holds", "falls"}) == 0, .place = value->place()};
  }
  const bool is_cia402 = std::holds_alternative<Cia402Drive>(axis.drive);
  const auto of_cia402 = [&](std::string_view field) {
    auto value = table.optional(field);
    if (value && !is_cia402) value->refuse("belongs to a cia402 drive only; leave it out");
    return value;
  };
  if (const auto value = of_cia402("coasts")) axis.coasts = value->boolean();
  if (const auto value = of_cia402("on_host_lost")) axis.stops_without_host = value->choice({"stops"}) == 0;
}

std::optional<InputLine> read_switch(const TomlTable& parent, std::string_view field, BrokenWire broken,
                                     TakenLines& lines) {
  const auto value = parent.optional(field);
  if (!value) return std::nullopt;
  return read_input(TomlTable(value->table(), std::string(field), input_fields), broken, lines);
}

RigAxis read_axis(const TomlValue& value, const RigContext& rig) {
  const TomlTable table(value.table(), "an axis", axis_fields);
  RigAxis axis;
  axis.place = table.place();
  const TomlValue name = table.required("name", R"(name = "track", say)");
  axis.name = name.text();
  take(rig.taken, name, fmt::format("axis {}", in_quotes(axis.name)), "give each axis its own name");
  const TomlValue unit = table.required("unit", R"(unit = "mm", "m", "deg", "rad", "turn" or "unit")");
  axis.unit = static_cast<AxisUnit>(unit.choice(axis_unit_names));
  read_limits(table, axis);
  read_gear(table, axis);
  axis.drive = read_drive(table.required("drive", R"(drive = { type = ... })"),
                          motor_of(axis, {.axis = 0, .offset = axis.offset}), rig);
  read_ganged(table, axis, rig);
  leave_room_for_backlash(axis);
  read_loss_of_power(table, axis);
  if (const auto home = table.optional("home")) read_home_of_axis(*home, axis, rig.lines);
  read_reference(table, axis);
  axis.limit_min = read_switch(table, "limit_min", BrokenWire::preferably_active, rig.lines);
  axis.limit_max = read_switch(table, "limit_max", BrokenWire::preferably_active, rig.lines);
  return axis;
}

std::optional<InputLine> read_emergency_stop(const TomlTable& rig, TakenLines& lines) {
  const auto value = rig.optional("emergency_stop");
  if (!value) return std::nullopt;
  const TomlTable table(value->table(), "the emergency stop", emergency_stop_fields);
  const Level stops_at =
      read_level(table.required("stops_at", R"(stops_at = "high" or "low", the level that stops)"));
  return read_input(table, stops_at, BrokenWire::reads_active, lines);
}

std::optional<Camera> read_camera(const TomlTable& rig, TakenLines& lines) {
  const auto value = rig.optional(camera_name);
  if (!value) return std::nullopt;
  const TomlTable table(value->table(), "the camera", camera_fields);
  Camera camera;
  camera.place = value->place();
  camera.shutter = read_output(table, lines);
  camera.asks = read_switch(table, "asks", BrokenWire::reads_inactive, lines);
  return camera;
}

std::vector<Output> read_outputs(const TomlTable& rig, TakenLines& lines) {
  std::vector<Output> outputs;
  const auto section = rig.optional("output");
  if (!section) return outputs;
  const toml::table& tables = section->table();
  if (tables.size() > max_rig_outputs) {
    section->refuse(fmt::format("has {} lines; write at most {}", tables.size(), max_rig_outputs));
  }
  for (const auto& [key, node] : tables) {
    const std::string_view name = key.str();
    const TomlValue value(node, fmt::format("output {}", in_quotes(name)));
    const TomlTable table(value.table(), value.name(), output_fields);
    const bool is_plain =
        !name.empty() && name.size() <= max_text_bytes && std::all_of(name.begin(), name.end(), [](char c) {
          return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
                 c == '_';
        });
    if (!is_plain) value.refuse("is not a plain name; write letters, digits, - and _");
    if (name == camera_name)
      value.refuse("has the name of the shutter line; write [camera], or another name");
    outputs.push_back({std::string(name), read_output(table, lines), value.place()});
  }
  return outputs;
}

std::optional<RigKinematics> read_rig_kinematics(const TomlTable& rig) {
  const auto value = rig.optional("kinematics");
  if (!value) return std::nullopt;
  const TomlTable table(value->table(), "the kinematics", kinematics_fields);
  RigKinematics kinematics;
  kinematics.urdf = table.required("urdf", R"(urdf = "crane.urdf", say)").text();
  const TomlValue tip = table.required("tip", R"(tip = "camera", the link whose path is of interest)");
  if (tip.node().is_array()) {
    for (const TomlValue& one : tip.list(max_rig_tips)) kinematics.tips.push_back({one.text(), one.place()});
  } else {
    kinematics.tips.push_back({tip.text(), tip.place()});
  }
  if (const auto limits = table.optional("limits")) {
    kinematics.has_limits_of_rig = limits->choice({"both", "rig"}) == 1;
  }
  if (const auto at = table.optional("at")) {
    constexpr double max_value = 1e6;
    for (const auto& [key, node] : at->table()) {
      const std::string name(std::string_view{key});
      const TomlValue stays(node, "at." + name);
      kinematics.at.push_back({name, stays.number(-max_value, max_value), stays.place()});
    }
  }
  std::set<std::string_view> names;
  for (const RigTip& one : kinematics.tips) {
    if (!names.insert(one.name).second) {
      throw InputError(one.place, fmt::format("tip {} is named twice; remove one", in_quotes(one.name)));
    }
  }
  return kinematics;
}

/// STEP and DIR of a chip change in one call.
void refuse_too_many_step_dir_drives(const RigFile& rig) {
  std::map<std::string, std::size_t> drives;
  for (const RigAxis& axis : rig.axes) {
    const auto* drive = std::get_if<StepDirDrive>(&axis.drive);
    if (drive == nullptr || ++drives[drive->chip] <= max_step_dir_drives_of_chip) continue;
    throw InputError(axis.place,
                     fmt::format("axis {} is one more step-dir drive than the {} that chip {} can "
                                 "step at once; move it to another chip",
                                 in_quotes(axis.name), max_step_dir_drives_of_chip, in_quotes(drive->chip)));
  }
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

/// The rates above the drawn one are certified within this share of max_velocity.
constexpr double certified_share = 1.2;

}  // namespace

std::string_view to_string(AxisUnit unit) {
  return axis_unit_names.at(static_cast<std::size_t>(unit));
}

double place_tolerance(const RigAxis& axis) {
  constexpr double hold_s = 0.0005;
  return hold_s * axis.max_velocity;
}

double home_tolerance(const RigAxis& axis) {
  if (!axis.drive_home) return 0;
  const DriveHome& home = *axis.drive_home;
  const double braking = home.acceleration > 0 ? home.slow * home.slow / home.acceleration : 0;
  return place_tolerance(axis) + braking;
}

double count_of(const Drive& drive) {
  struct Count {
    // As far apart as they are at max_turns.
    static double of_turns(double turns_per_unit) { return 1 / std::fabs(1024 * turns_per_unit); }
    double operator()(const Cia402Drive& its) const { return 1 / std::fabs(its.counts_per_unit); }
    double operator()(const OdriveDrive& its) const { return of_turns(its.turns_per_unit); }
    double operator()(const MoteusDrive& its) const { return of_turns(its.turns_per_unit); }
    double operator()(const RmdDrive& its) const {
      return 1 / std::fabs(rmd_steps_per_turn * its.turns_per_unit);
    }
    double operator()(const CubemarsDrive& its) const {
      return 1 / std::fabs(cubemars_steps_per_turn * its.turns_per_unit);
    }
    double operator()(const StepDirDrive& its) const { return 1 / std::fabs(its.steps_per_unit); }
    double operator()(const PipeDrive& its) const { return 1 / std::fabs(its.counts_per_unit); }
  };
  return std::visit(Count{}, drive);
}

double stop_acceleration_of(const RigAxis& axis) {
  return axis.stop_acceleration.value_or(default_stop_ratio * axis.max_acceleration);
}

double rest_distance_of(const RigAxis& axis) {
  constexpr double seconds = 0.05;
  constexpr double usual_steps_per_turn = 8'192;
  constexpr double velocity_share = 0.01;
  const bool is_unsaid =
      std::holds_alternative<OdriveDrive>(axis.drive) || std::holds_alternative<MoteusDrive>(axis.drive);
  const double step = is_unsaid
                          ? 1 / std::fabs(usual_steps_per_turn * turns_per_unit_of(axis.drive).value_or(1))
                          : count_of(axis.drive);
  const double stoppable = std::sqrt(2 * stop_acceleration_of(axis) * step);
  return std::max(2 * step, seconds * std::min(velocity_share * axis.max_velocity, stoppable));
}

std::optional<double> turns_per_unit_of(const Drive& drive) {
  return std::visit(
      [](const auto& its) -> std::optional<double> {
        if constexpr (requires { its.turns_per_unit; }) return its.turns_per_unit;
        return {};
      },
      drive);
}

std::optional<FollowLimits> follow_limits_of(const Drive& drive) {
  return std::visit(
      [](const auto& its) -> std::optional<FollowLimits> {
        if constexpr (requires { its.follow; }) return its.follow;
        return {};
      },
      drive);
}

CubemarsLimits cubemars_limits_of(const RigAxis& axis) {
  const CubemarsDrive& drive = std::get<CubemarsDrive>(axis.drive);
  const double erpm_per_unit = 60 * std::fabs(drive.turns_per_unit) * drive.gear * drive.pole_pairs;
  const double counts_per_unit = erpm_per_unit / drive.erpm_per_count;
  const double stop = stop_acceleration_of(axis);
  return {.velocity = std::ceil(certified_share * axis.max_velocity * counts_per_unit),
          .stop_acceleration = std::ceil(stop * counts_per_unit)};
}

double max_rmd_deg_per_s_of(const RigAxis& axis) {
  constexpr double deg_per_turn = 360;
  const double scale = std::fabs(std::get<RmdDrive>(axis.drive).turns_per_unit);
  return std::ceil(certified_share * deg_per_turn * scale * axis.max_velocity);
}

bool is_open_loop(const Drive& drive) {
  return std::holds_alternative<StepDirDrive>(drive) || std::holds_alternative<PipeDrive>(drive);
}

std::string_view to_string(Reference reference) {
  return reference_names.at(static_cast<std::size_t>(reference));
}

std::string named(const RigAxis& axis) {
  return "axis " + in_quotes(axis.name);
}

std::string range_in_words(const RigAxis& axis) {
  return fmt::format("{}..{} {}", axis.min, axis.max, to_string(axis.unit));
}

Place place_of_bus(const RigFile& rig, const std::string& name) {
  const auto found = std::ranges::find(rig.buses, name, &Bus::name);
  return found != rig.buses.end() ? found->place : Place{rig.path, 0, 0};
}

const Bus& bus_named(const RigFile& rig, const std::string& name) {
  return *std::ranges::find(rig.buses, name, &Bus::name);
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
  if (const auto watch = table.optional("step_watch_us"))
    rig.step_watch_ns = 1000 * watch->integer(0, max_step_watch_us);
  rig.buses = read_buses(table);
  Taken taken;
  TakenLines lines;
  for (const TomlValue& axis :
       table.required("axis", "an [[axis]] with its limits and drive").tables(max_rig_axes)) {
    rig.axes.push_back(read_axis(axis, {rig.buses, taken, lines}));
  }
  refuse_inexact_cia402_rate(rig, rate);
  refuse_too_many_step_dir_drives(motors_of(rig).rig);
  rig.emergency_stop = read_emergency_stop(table, lines);
  rig.start_trigger = read_switch(table, "start_trigger", BrokenWire::reads_inactive, lines);
  rig.camera = read_camera(table, lines);
  rig.outputs = read_outputs(table, lines);
  rig.kinematics = read_rig_kinematics(table);
  rig.lens = read_lens(table, rig.kinematics);
  rig.dragonframe = read_dragonframe(table, rig.axes);
  return rig;
}

RigFile read_rig_file(const std::filesystem::path& path) {
  return parse_rig(read_text_file(path), path.string());
}

}  // namespace inbetween
