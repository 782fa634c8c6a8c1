#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>

#include "drivers/linux/raw_terminal.hpp"
#include "host_tools/rig_model/rig_readers.hpp"
#include "inbetween/limits/limits.hpp"

namespace inbetween {
namespace {

constexpr std::array<std::string_view, 16> cia402_fields = {"type",
                                                            "bus",
                                                            "node",
                                                            "mode",
                                                            "counts_per_unit",
                                                            "deceleration_per_unit",
                                                            "enable_timeout_s",
                                                            "reset",
                                                            "watchdog",
                                                            "eds",
                                                            "vendor",
                                                            "product",
                                                            "serial",
                                                            "watches_following_error",
                                                            "max_following_error",
                                                            "in_position"};
constexpr std::array<std::string_view, 7> odrive_fields = {
    "type", "bus", "node", "turns_per_unit", "firmware", "max_following_error", "in_position"};
constexpr std::array<std::string_view, 6> moteus_fields = {
    "type", "bus", "node", "turns_per_unit", "max_following_error", "in_position"};
constexpr std::array<std::string_view, 7> rmd_fields = {
    "type", "bus", "node", "turns_per_unit", "max_following_error", "in_position", "no_watchdog"};
constexpr std::array<std::string_view, 12> cubemars_fields = {
    "type",       "bus",  "node", "turns_per_unit", "max_following_error", "in_position",
    "pole_pairs", "gear", "mode", "counts_per_deg", "erpm_per_count",      "no_watchdog"};
constexpr std::array<std::string_view, 13> step_dir_fields = {
    "type",     "chip",     "step",         "dir",         "enable",        "steps_per_unit", "max_step_rate",
    "pulse_us", "pause_us", "dir_setup_us", "dir_hold_us", "enable_active", "latest_us"};
constexpr std::array<std::string_view, 8> pipe_fields = {
    "type", "path", "counts_per_unit", "count_at_zero", "min_count", "max_count", "baud", "no_watchdog"};

constexpr double max_pipe_count = std::numeric_limits<std::int32_t>::max();

struct CanAddress {
  std::string bus;
  int node;
};

struct NodeRange {
  int min;
  int max;
};
enum class CanFrames { classic, fd };

/// Classic drives answer a CAN FD frame of others with error frames, so that nothing gets through.
void refuse_other_frames(const TomlValue& field, const Bus& bus, CanFrames frames) {
  if (frames == CanFrames::fd && !bus.data_bitrate) {
    field.refuse(
        fmt::format("is {}, a bus of classic CAN, and this drive speaks CAN FD; write data_bitrate = "
                    "5_000_000, say, in [bus.{}], or give the drive a bus that has one",
                    in_quotes(bus.name), bus.name));
  }
  if (frames == CanFrames::classic && bus.data_bitrate) {
    field.refuse(
        fmt::format("is {}, a bus of CAN FD (it has a data_bitrate), and this drive speaks classic CAN, "
                    "which disturbs the others; give it a bus of its own",
                    in_quotes(bus.name)));
  }
}

CanAddress read_can_address(const TomlTable& table, NodeRange range, const RigContext& rig,
                            CanFrames frames = CanFrames::classic) {
  const TomlValue bus = table.required("bus", R"(the CAN bus, bus = "can0")");
  CanAddress address{bus.text(), 0};
  const auto known = std::ranges::find(rig.buses, address.bus, &Bus::name);
  if (known == rig.buses.end()) {
    bus.refuse(fmt::format("is {}, which the rig does not have; add a [bus.NAME] for it with its bitrate",
                           in_quotes(address.bus)));
  }
  refuse_other_frames(bus, *known, frames);
  const TomlValue node = table.required("node", "the node id of the drive, node = 1");
  address.node = static_cast<int>(node.integer(range.min, range.max));
  take(rig.taken, node, fmt::format("node {} of bus {}", address.node, address.bus),
       "give each drive its own");
  return address;
}

/// A scale in drive units per axis unit; both ends of the axis must stay within `max` drive units of 0.
double read_scale(const TomlTable& table, std::string_view field, const RigAxis& axis, double max) {
  const TomlValue value = table.required(field, fmt::format("{} = 1000.0, say", field));
  const double scale = value.number();
  if (scale == 0) value.refuse("is 0; write a positive number, or a negative one to reverse the motor");
  const std::string_view counted = field.substr(0, field.find('_'));
  for (const double end : {axis.min, axis.max}) {
    const double position = end * scale;
    if (std::abs(std::round(position)) > max) {
      value.refuse(
          fmt::format("is {}, so that {} {} is {:.15g} {}, beyond {:.15g} {}; lower the scale or the range",
                      scale, end, to_string(axis.unit), position, counted, max, counted));
    }
  }
  return scale;
}

double read_count_scale(const TomlTable& table, std::string_view field, const RigAxis& axis) {
  return read_scale(table, field, axis, std::numeric_limits<std::int32_t>::max());
}

/// The deceleration of the drive in a quick stop, in its own units.
std::uint32_t read_stop_deceleration(const TomlTable& table, double counts_per_unit, const RigAxis& axis) {
  const auto field = table.optional("deceleration_per_unit");
  const double scale = field ? field->positive_number() : std::abs(counts_per_unit);
  const double stop = stop_acceleration_of(axis);
  const double deceleration = std::round(stop * scale);
  if (deceleration >= 1 && deceleration <= std::numeric_limits<std::uint32_t>::max()) {
    return static_cast<std::uint32_t>(deceleration);
  }
  field.value_or(*table.optional("counts_per_unit"))
      .refuse(fmt::format(
          "is {}, so that a stop by {:.15g} {}/s^2 is {:.15g} units of the drive; its object 6085 "
          "takes 1 to {}",
          field ? scale : counts_per_unit, stop, to_string(axis.unit), deceleration,
          std::numeric_limits<std::uint32_t>::max()));
}

/// What a drive needs that does not do what most do.
void read_habits(const TomlTable& table, Cia402Drive& drive) {
  constexpr double min_enable_s = 0.1;
  constexpr double max_enable_s = 60;
  if (const auto timeout = table.optional("enable_timeout_s")) {
    drive.enable_timeout_s = timeout->number(min_enable_s, max_enable_s);
  }
  if (const auto reset = table.optional("reset")) {
    drive.resets_node = reset->choice({"communication", "node"}) == 1;
  }
  if (const auto eds = table.optional("eds")) {
    drive.eds = (std::filesystem::path(eds->place().file).parent_path() / eds->text()).string();
  }
  const auto read_word = [&](std::string_view field, std::optional<std::uint32_t>& word) {
    const auto value = table.optional(field);
    constexpr std::int64_t max_word = std::numeric_limits<std::uint32_t>::max();
    if (value) word = static_cast<std::uint32_t>(value->integer(1, max_word));
  };
  read_word("vendor", drive.vendor);
  read_word("product", drive.product);
  read_word("serial", drive.serial);
  if (const auto watchdog = table.optional("watchdog")) {
    drive.is_guarded = watchdog->choice({"heartbeat", "life-guarding"}) == 1;
  }
  if (const auto mode = table.optional("mode")) {
    drive.interpolates = mode->choice({"cyclic", "interpolated"}) == 1;
  }
  if (const auto watches = table.optional("watches_following_error")) {
    drive.watches_following_error = watches->boolean();
  }
}

/// `field` in microseconds, rounded up to nanoseconds; `time_ns` stays as it is without it.
void read_time(const TomlTable& table, std::string_view field, double max_us, std::int64_t& time_ns) {
  const auto value = table.optional(field);
  if (!value) return;
  const double time_us = value->number(0, max_us);
  if (!(time_us > 0)) value->refuse(fmt::format("is {}; write a number above 0", time_us));
  time_ns = static_cast<std::int64_t>(std::ceil(time_us * 1000));
}

void read_step_times(const TomlTable& table, StepDirDrive& drive) {
  constexpr double max_time_us = 1'000;
  read_time(table, "pulse_us", max_time_us, drive.pulse_ns);
  read_time(table, "pause_us", max_time_us, drive.pause_ns);
  read_time(table, "dir_setup_us", max_time_us, drive.dir_setup_ns);
  read_time(table, "dir_hold_us", max_time_us, drive.dir_hold_ns);
  read_time(table, "latest_us", 1'000'000, drive.latest_ns);
}

void read_step_rate(const TomlTable& table, const TomlValue& scale, const RigAxis& axis,
                    StepDirDrive& drive) {
  const auto rate = table.optional("max_step_rate");
  if (rate) {
    drive.max_step_rate = rate->number(0, max_step_rate);
    if (!(drive.max_step_rate > 0)) rate->refuse("is 0; write a number above 0");
  }
  const double fastest = std::abs(drive.steps_per_unit) * axis.max_velocity;
  if (!(fastest <= drive.max_step_rate)) {
    scale.refuse(
        fmt::format("is {}, so that max_velocity = {} {}/s is {:.15g} steps/s, more than "
                    "max_step_rate = {} steps/s{}; lower max_velocity or the microstepping, or raise "
                    "max_step_rate if the driver and this computer can do it",
                    drive.steps_per_unit, axis.max_velocity, to_string(axis.unit), fastest,
                    drive.max_step_rate, rate ? "" : " (the default)"));
  }
  const double period_ns = 1e9 / drive.max_step_rate;
  const std::int64_t step_ns = drive.pulse_ns + drive.pause_ns;
  if (static_cast<double>(step_ns) > period_ns) {
    // The defaults go with each other, so that one of the three fields is there.
    const auto pulse = table.optional("pulse_us");
    const TomlValue field = rate ? *rate : pulse ? *pulse : *table.optional("pause_us");
    field.refuse(
        fmt::format("does not go with the others: pulse_us + pause_us is {:.15g} us, longer than a step at "
                    "max_step_rate = {}, {:.15g} us; lower one of the three",
                    static_cast<double>(step_ns) / 1000, drive.max_step_rate, period_ns / 1000));
  }
}

StepDirDrive read_step_dir(const TomlTable& table, const RigAxis& axis, TakenLines& lines) {
  StepDirDrive drive;
  drive.chip = read_chip(table);
  drive.step = read_line_of(drive.chip, table.required("step", "the step line, by offset or name"), lines);
  drive.dir = read_line_of(drive.chip, table.required("dir", "the direction line, by offset or name"), lines);
  if (const auto enable = table.optional("enable")) drive.enable = read_line_of(drive.chip, *enable, lines);
  drive.steps_per_unit = read_count_scale(table, "steps_per_unit", axis);
  read_step_times(table, drive);
  read_step_rate(table, *table.optional("steps_per_unit"), axis, drive);
  if (const auto active = table.optional("enable_active")) {
    if (!drive.enable) active->refuse("needs an enable line; add enable = ..., or remove it");
    drive.enable_active = read_level(*active);
  }
  return drive;
}

/// Whatever the drive watches by itself. Positions are `count` apart, in axis units.
FollowLimits read_follow_limits(const TomlTable& table, const RigAxis& axis, double count) {
  constexpr double usual_s = 0.1;
  constexpr double usual_share = 0.1;
  const auto error = table.optional("max_following_error");
  const double largest = std::max(usual_s * axis.max_velocity, 4 * count);
  FollowLimits limits{.max_following_error = error ? error->positive_number() : largest};
  const auto place = table.optional("in_position");
  limits.in_position = place ? place->positive_number()
                             : std::min(std::max(usual_share * limits.max_following_error, 2 * count),
                                        limits.max_following_error);
  if (limits.in_position <= limits.max_following_error) return limits;
  place->refuse(fmt::format("is {}, more than max_following_error = {}; write less", limits.in_position,
                            limits.max_following_error));
}

/// Whether somebody accepts that the drive does not stop by itself if this program dies.
bool accepts_no_watchdog(const TomlTable& table) {
  const auto accepted = table.optional("no_watchdog");
  return accepted && accepted->choice({"accepted"}) == 0;
}

OdriveDrive read_odrive(const TomlTable& table, OdriveDrive drive, const RigAxis& axis) {
  const double turns_per_s = axis.max_velocity * std::abs(drive.turns_per_unit);
  if (turns_per_s > max_odrive_turns_per_s) {
    table.optional("turns_per_unit")
        ->refuse(
            fmt::format("is {}, so that max_velocity = {} {}/s is {:.15g} turns/s, and the feed-forward of "
                        "an ODrive goes to {}; lower max_velocity or the scale",
                        drive.turns_per_unit, axis.max_velocity, to_string(axis.unit), turns_per_s,
                        max_odrive_turns_per_s));
  }
  const TomlValue firmware = table.required("firmware", R"(the firmware of the drive, firmware = "0.6")");
  drive.firmware = static_cast<OdriveFirmware>(firmware.choice({"0.5", "0.6"}));
  drive.follow = read_follow_limits(table, axis, count_of(Drive(drive)));
  return drive;
}

/// The velocity that an axis may have must be one that its drive can be told.
RmdDrive read_rmd(const TomlTable& table, RigAxis axis, const RigContext& rig) {
  const auto [bus, node] = read_can_address(table, {1, 32}, rig);
  const double turns_per_unit = read_scale(table, "turns_per_unit", axis, max_turns);
  RmdDrive drive{.bus = bus, .node = node, .turns_per_unit = turns_per_unit};
  drive.follow = read_follow_limits(table, axis, count_of(Drive(drive)));
  drive.has_no_watchdog = accepts_no_watchdog(table);
  axis.drive = drive;
  const double deg_per_s = max_rmd_deg_per_s_of(axis);
  if (deg_per_s > max_rmd_deg_per_s) {
    table.optional("turns_per_unit")
        ->refuse(
            fmt::format("is {}, so that 1.2 times max_velocity is {} deg/s, and the limit that goes with a "
                        "position holds {}; lower max_velocity or the scale",
                        turns_per_unit, deg_per_s, max_rmd_deg_per_s));
  }
  return drive;
}

void refuse_cubemars_range(const TomlTable& table, const RigAxis& axis) {
  const CubemarsDrive& drive = std::get<CubemarsDrive>(axis.drive);
  const TomlValue scale = *table.optional("turns_per_unit");
  const CubemarsLimits limits = cubemars_limits_of(axis);
  const double erpm = limits.velocity * drive.erpm_per_count;
  if (limits.velocity > CubemarsLimits::max) {
    scale.refuse(fmt::format(
        "is {}, so that 1.2 times max_velocity is {:.15g} electrical turns a minute, and the limit "
        "that goes with a position holds {:.15g}; lower max_velocity",
        drive.turns_per_unit, erpm, CubemarsLimits::max * drive.erpm_per_count));
  }
  if (limits.stop_acceleration > CubemarsLimits::max) {
    scale.refuse(fmt::format(
        "is {}, so that a controlled stop is {:.15g} electrical turns a minute per second, and the "
        "limit that goes with a position holds {:.15g}; lower max_acceleration",
        drive.turns_per_unit, limits.stop_acceleration * drive.erpm_per_count,
        CubemarsLimits::max * drive.erpm_per_count));
  }
  constexpr double max_count = std::numeric_limits<std::int32_t>::max();
  for (const double end : {axis.min, axis.max}) {
    const double deg = 360 * std::abs(end * drive.turns_per_unit);
    if (deg * drive.counts_per_deg <= max_count) continue;
    scale.refuse(fmt::format(
        "is {}, so that {} {} is {:.15g} deg of the motor, and with counts_per_deg = {:.15g} it can "
        "be told {:.15g}; lower the range",
        drive.turns_per_unit, end, to_string(axis.unit), deg, drive.counts_per_deg,
        std::floor(max_count / drive.counts_per_deg)));
  }
}

/// Nothing is known to stop such a motor when this program dies.
void require_accepted_mode(const TomlTable& table) {
  const auto mode = table.optional("mode");
  if (mode && mode->choice({"servo", "mit"}) == 1) {
    mode->refuse(
        "is \"mit\", in which a motor goes on with its last torque, without a velocity limit, if this "
        "program dies: no firmware is known to have a watchdog that can be read or tried; write \"servo\"");
  }
  static_cast<void>(table.required(
      "no_watchdog",
      "no_watchdog = \"accepted\" if it may go on to its last position and hold it when this program "
      "dies: no firmware is known to have a watchdog"));
  accepts_no_watchdog(table);
}

/// The velocity and the acceleration that an axis may have must be ones that its drive can be told.
CubemarsDrive read_cubemars(const TomlTable& table, RigAxis axis, const RigContext& rig) {
  const auto [bus, node] = read_can_address(table, {1, 255}, rig);
  const double turns_per_unit = read_scale(table, "turns_per_unit", axis, max_cubemars_turns);
  CubemarsDrive drive{.bus = bus, .node = node, .turns_per_unit = turns_per_unit};
  drive.follow = read_follow_limits(table, axis, count_of(Drive(drive)));
  constexpr std::int64_t max_pole_pairs = 100;
  constexpr double min_gear = 0.01;
  constexpr double max_gear = 1000;
  const TomlValue pole_pairs =
      table.required("pole_pairs", "the pole pairs of the motor, pole_pairs = 21, say");
  drive.pole_pairs = static_cast<double>(pole_pairs.integer(1, max_pole_pairs));
  drive.gear = table.required("gear", "the turns of the motor per turn of its output shaft, gear = 9, say")
                   .number(min_gear, max_gear);
  // The firmware has one of two scales, and manuals of both are about.
  const auto either = [&](std::string_view field, std::int64_t one, std::int64_t other, double& scale) {
    const auto value = table.optional(field);
    if (!value) return;
    const std::int64_t number = value->integer(std::min(one, other), std::max(one, other));
    if (number != one && number != other) {
      value->refuse(fmt::format("is {}; write {} or {}, whichever the firmware has", number, one, other));
    }
    scale = static_cast<double>(number);
  };
  either("counts_per_deg", 10'000, 1'000'000, drive.counts_per_deg);
  either("erpm_per_count", 10, 1, drive.erpm_per_count);
  require_accepted_mode(table);
  axis.drive = drive;
  refuse_cubemars_range(table, axis);
  return drive;
}

/// The counts of both ends of the axis must be those of the servo.
void refuse_pipe_range(const TomlTable& table, const PipeDrive& drive, const RigAxis& axis) {
  for (const std::string_view field : {"min_count", "max_count"}) {
    const auto limit = table.optional(field);
    if (!limit) continue;
    const double bound = limit->number(-max_pipe_count, max_pipe_count);
    for (const double end : {axis.min, axis.max}) {
      const double count = std::floor(end * drive.counts_per_unit + drive.count_at_zero + 0.5);
      if (field == "min_count" ? count >= bound : count <= bound) continue;
      limit->refuse(
          fmt::format("is {:.15g}, and {} {} is count {:.15g}; correct counts_per_unit, count_at_zero or "
                      "the range of the axis",
                      bound, end, to_string(axis.unit), count));
    }
  }
}

PipeDrive read_pipe(const TomlTable& table, const RigAxis& axis) {
  const TomlValue path = table.required("path", "the FIFO or serial port, path = \"...\"");
  PipeDrive drive;
  drive.path = (std::filesystem::path(path.place().file).parent_path() / path.text()).string();
  drive.counts_per_unit = read_count_scale(table, "counts_per_unit", axis);
  if (const auto zero = table.optional("count_at_zero")) {
    drive.count_at_zero = zero->number(-max_pipe_count, max_pipe_count);
  }
  if (const auto baud = table.optional("baud")) {
    drive.baud = static_cast<std::int32_t>(baud->integer(1, 1'000'000));
    if (!is_baud(drive.baud)) {
      baud->refuse(
          fmt::format("is {}; write one that serial ports have, such as 115200 or 1000000", drive.baud));
    }
  }
  drive.has_no_watchdog = accepts_no_watchdog(table);
  refuse_pipe_range(table, drive, axis);
  return drive;
}

}  // namespace

void take(Taken& taken, const TomlValue& value, const std::string& what, std::string_view remedy) {
  const auto [earlier, is_new] = taken.emplace(what, value.place());
  if (!is_new)
    value.refuse(fmt::format("is {}, which line {} has already; {}", what, earlier->second.line, remedy));
}

Drive read_drive(const TomlValue& value, const RigAxis& axis, const RigContext& rig) {
  const toml::table& fields = value.table();
  const toml::node* type = fields.get("type");
  if (type == nullptr) {
    value.refuse(
        R"(has no type; add type = "cia402", "odrive", "moteus", "rmd", "cubemars", "step-dir" or "pipe")");
  }
  switch (TomlValue(*type, "type")
              .choice({"cia402", "odrive", "moteus", "rmd", "cubemars", "step-dir", "pipe"})) {
    case 0: {
      const TomlTable table(fields, "a cia402 drive", cia402_fields);
      const auto [bus, node] = read_can_address(table, {1, 127}, rig);
      const double counts_per_unit = read_count_scale(table, "counts_per_unit", axis);
      Cia402Drive drive{bus, node, counts_per_unit, read_stop_deceleration(table, counts_per_unit, axis)};
      const auto deceleration = table.optional("deceleration_per_unit");
      drive.acceleration_scale = deceleration ? deceleration->number() : std::abs(counts_per_unit);
      read_habits(table, drive);
      drive.follow = read_follow_limits(table, axis, count_of(Drive(drive)));
      return drive;
    }
    case 1: {
      const TomlTable table(fields, "an odrive drive", odrive_fields);
      const auto [bus, node] = read_can_address(table, {0, 62}, rig);
      return read_odrive(table, {bus, node, read_scale(table, "turns_per_unit", axis, max_turns)}, axis);
    }
    case 2: {
      const TomlTable table(fields, "a moteus drive", moteus_fields);
      const auto [bus, node] = read_can_address(table, {1, 126}, rig, CanFrames::fd);
      MoteusDrive drive{bus, node, read_scale(table, "turns_per_unit", axis, max_turns)};
      drive.follow = read_follow_limits(table, axis, count_of(Drive(drive)));
      return drive;
    }
    case 3:
      return read_rmd(TomlTable(fields, "an rmd drive", rmd_fields), axis, rig);
    case 4:
      return read_cubemars(TomlTable(fields, "a cubemars drive", cubemars_fields), axis, rig);
    case 5:
      return read_step_dir(TomlTable(fields, "a step-dir drive", step_dir_fields), axis, rig.lines);
    default:
      break;
  }
  return read_pipe(TomlTable(fields, "a pipe drive", pipe_fields), axis);
}

}  // namespace inbetween
