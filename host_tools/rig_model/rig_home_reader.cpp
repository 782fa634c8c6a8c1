#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "host_tools/rig_model/rig_motors.hpp"
#include "host_tools/rig_model/rig_readers.hpp"
#include "inbetween/can/cia402_homing.hpp"

namespace inbetween {
namespace {

constexpr std::array<std::string_view, 12> home_fields = {
    "by", "chip", "line", "active", "bias", "direction", "fast", "slow", "back_off", "search", "at", "park"};
constexpr std::array<std::string_view, 9> drive_home_fields = {
    "by", "method", "fast", "slow", "acceleration", "speed_per_unit", "at", "timeout_s", "park"};

/// A position that the drive of an open-loop axis cannot count to.
void refuse_uncountable(const TomlValue& value, double position, const RigAxis& axis) {
  const auto* stepper = std::get_if<StepDirDrive>(&axis.drive);
  const double scale =
      stepper != nullptr ? stepper->steps_per_unit : std::get<PipeDrive>(axis.drive).counts_per_unit;
  const double motor = motor_position(axis, {.axis = 0, .offset = axis.offset}, position);
  if (std::abs(std::round(motor * scale)) <= std::numeric_limits<std::int32_t>::max()) return;
  value.refuse(fmt::format("is {} {}, which the drive cannot count to in 32 bits; write where the switch is",
                           position, to_string(axis.unit)));
}

/// Both speeds of a home: fast at most max_velocity, and slow below it.
template <class AnyHome>
void read_home_speeds(const TomlTable& table, const RigAxis& axis, AnyHome& home) {
  const TomlValue fast = table.required("fast", "fast = 20.0 (unit/s), say, to find the switch");
  home.fast = fast.positive_number();
  if (home.fast > axis.max_velocity) {
    fast.refuse(fmt::format("is {}, above max_velocity = {}; lower it", home.fast, axis.max_velocity));
  }
  const TomlValue slow = table.required("slow", "slow = 2.0 (unit/s), say, to meet its edge");
  home.slow = slow.positive_number();
  if (home.slow >= home.fast) {
    slow.refuse(fmt::format("is {}, not below fast = {}; lower it", home.slow, home.fast));
  }
}

/// A speed or an acceleration in units of the drive.
std::uint32_t in_units_of_drive(const TomlValue& value, double number, double scale) {
  const double units = std::round(number * scale);
  if (units >= 1 && units <= std::numeric_limits<std::uint32_t>::max()) {
    return static_cast<std::uint32_t>(units);
  }
  value.refuse(
      fmt::format("is {}, which is {:.15g} units of the drive, and its object takes 1 to {}; "
                  "correct it, or the scale",
                  number, units, std::numeric_limits<std::uint32_t>::max()));
}

/// How it gets home, and how fast.
void read_home_motion(const TomlTable& table, const RigAxis& axis, DriveHome& home) {
  const auto& drive = std::get<Cia402Drive>(axis.drive);
  if (can::homes_where_it_stands(home.method)) {
    table.refuse_any(
        {"fast", "slow", "acceleration", "speed_per_unit", "timeout_s"},
        fmt::format("has no meaning with method = {}, which moves nothing; leave it out", home.method));
    home.timeout_s = 10;
    return;
  }
  read_home_speeds(table, axis, home);
  const TomlValue acceleration =
      table.required("acceleration", "acceleration = 50.0 (unit/s^2), say, for both speeds");
  home.acceleration = acceleration.positive_number();
  if (home.acceleration > axis.max_acceleration) {
    acceleration.refuse(fmt::format("is {}, above max_acceleration = {}; lower it", home.acceleration,
                                    axis.max_acceleration));
  }
  const auto scale = table.optional("speed_per_unit");
  const double per_unit = scale ? scale->positive_number() : std::abs(drive.counts_per_unit);
  home.fast_speed = in_units_of_drive(*table.optional("fast"), home.fast, per_unit);
  home.slow_speed = in_units_of_drive(*table.optional("slow"), home.slow, per_unit);
  home.acceleration_rate = in_units_of_drive(acceleration, home.acceleration, drive.acceleration_scale);
  constexpr double max_timeout_s = 3600;
  const auto timeout = table.optional("timeout_s");
  home.timeout_s = timeout ? timeout->number(0, max_timeout_s)
                           : std::min(10 + 2 * (axis.max - axis.min) / home.fast, max_timeout_s);
  if (!(home.timeout_s > 0)) timeout->refuse("is 0; write a number above 0");
}

DriveHome read_drive_home(const TomlValue& value, const RigAxis& axis) {
  const TomlTable table(value.table(), "a home by its drive", drive_home_fields);
  const TomlValue by = *table.optional("by");
  const auto* drive = std::get_if<Cia402Drive>(&axis.drive);
  if (drive == nullptr) {
    by.refuse(
        is_open_loop(axis.drive)
            ? R"(is "drive", and this drive cannot home itself; write the line of a switch)"
            : R"(is "drive", and only a cia402 drive is told to home itself; leave `home` out, and let )"
              "the tool of its maker home it");
  }
  if (has_gear(axis)) {
    by.refuse(
        R"(is "drive", which knows one motor and nothing of an offset, a calibration, a backlash or other )"
        R"(motors of the axis; leave `home` out, and home it by hand (reference = "operator"))");
  }
  if (drive->resets_node) {
    by.refuse(R"(is "drive", and reset = "node" lets the drive forget its home; leave one of the two out)");
  }
  DriveHome home;
  home.place = value.place();
  const TomlValue method = table.required("method", "method = 17, say, from the manual of the drive (6098)");
  home.method = static_cast<int>(method.integer(-128, 127));
  if (!can::is_homing_method(home.method)) {
    method.refuse(fmt::format("is {}, which CiA 402 does not have; write 1 to 14, 17 to 30, 33 to 35 or 37",
                              home.method));
  }
  if (const auto at = table.optional("at")) {
    home.at = at->number();
  }
  if (home.at < axis.min || home.at > axis.max) {
    table.optional("at").value_or(value).refuse(
        fmt::format("puts the home at {} {}, outside {}, and a drive that stands there would go back inside; "
                    "write where it is, or correct min and max",
                    home.at, to_string(axis.unit), range_in_words(axis)));
  }
  read_home_motion(table, axis, home);
  return home;
}

/// Whether the drive is to do it.
bool is_by_drive(const TomlValue& home) {
  const toml::node* by = home.table().get("by");
  return by != nullptr && TomlValue(*by, "by").choice({"switch", "drive"}) == 1;
}

/// Reads park of a home, by a switch or by the drive.
std::optional<double> read_park(const TomlValue& home, const RigAxis& axis) {
  const toml::node* node = home.table().get("park");
  if (node == nullptr) return std::nullopt;
  const TomlValue value(*node, "park");
  const double park = value.number();
  if (park < axis.min || park > axis.max) {
    value.refuse(fmt::format("is {} {}, outside {}; write a position between min and max", park,
                             to_string(axis.unit), range_in_words(axis)));
  }
  return park;
}

Home read_home(const TomlValue& value, const RigAxis& axis, TakenLines& lines) {
  if (std::holds_alternative<Cia402Drive>(axis.drive)) {
    value.refuse(R"(is one by a switch on a line, and a cia402 drive homes itself; write home = { by = )"
                 R"("drive", method = 17, ... }, or remove it)");
  }
  if (!is_open_loop(axis.drive)) {
    value.refuse("has no meaning for a drive that knows where it is; remove it, the drive homes itself");
  }
  const TomlTable table(value.table(), "a home", home_fields);
  Home home;
  home.place = value.place();
  home.input = read_input(table, BrokenWire::preferably_active, lines);
  const TomlValue direction =
      table.required("direction", R"(direction = "negative" or "positive", towards the switch)");
  home.direction = direction.choice({"negative", "positive"}) == 0 ? -1 : 1;
  if (axis.backlash && axis.backlash->approach_is_up != (home.direction > 0)) {
    direction.refuse(
        "is not the approach of the backlash, on which places are exact; home from the other side, "
        "or let the approach be this way");
  }
  read_home_speeds(table, axis, home);
  home.back_off =
      table.required("back_off", "back_off = 5.0 (unit), say, to leave the switch").positive_number();
  if (const auto at = table.optional("at")) {
    home.at = at->number();
    refuse_uncountable(*at, home.at, axis);
  }
  const double far_end = home.direction < 0 ? axis.max : axis.min;
  if ((home.at - far_end) * home.direction <= 0) {
    table.optional("at").value_or(value).refuse(fmt::format(
        "puts the switch at {} {}, where no way {} leads from {} = {}; write where it is, or the other "
        "direction",
        home.at, to_string(axis.unit), home.direction < 0 ? "down" : "up", home.direction < 0 ? "max" : "min",
        far_end));
  }
  const auto search = table.optional("search");
  home.search = search ? search->positive_number()
                       : std::max(axis.max - axis.min, std::abs(far_end - home.at)) + home.back_off;
  return home;
}

}  // namespace

void read_home_of_axis(const TomlValue& home, RigAxis& axis, TakenLines& lines) {
  if (is_by_drive(home)) {
    axis.drive_home = read_drive_home(home, axis);
  } else {
    axis.home = read_home(home, slow_enough_everywhere(axis), lines);
  }
  axis.park = read_park(home, axis);
}

}  // namespace inbetween
