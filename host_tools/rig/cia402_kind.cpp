#include "host_tools/rig/cia402_kind.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host_tools/rig/eds_drive.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "inbetween/can/bus_load.hpp"
#include "inbetween/can/canopen_id.hpp"
#include "inbetween/can/pdo.hpp"
#include "inbetween/loop/tick_time.hpp"

namespace inbetween {
namespace {

/// By which a setpoint may be further from the last than max_velocity allows: rounding to counts, and the
/// rates above the drawn one that are certified within it.
constexpr double step_share = 1.2;
/// The host's heartbeat, and how many of them a drive waits for.
constexpr std::int64_t heartbeat_ns = 30'000'000;
constexpr std::int64_t heartbeats_waited_for = can::life_time_factor;
constexpr std::int64_t ns_per_ms = 1'000'000;
/// How long a drive waits for a setpoint: in ticks, of which one may be late, and at least. Meanwhile it
/// holds the last one, which stops the axis as hard as its motor can; then it brakes by its own ramp.
constexpr std::int64_t setpoints_waited_for = 4;
constexpr std::int64_t min_setpoint_wait_ms = 20;

std::int64_t tick_ns(std::int32_t rate_hz) {
  return ns_per_s / rate_hz;
}
std::int64_t heartbeat_period_ns(std::int32_t rate_hz) {
  return std::max(heartbeat_ns, tick_ns(rate_hz));
}

/// What a drive may lack that its owner should know.
struct Lack {
  std::uint16_t index;
  const char* words;
};
constexpr std::array lacks{
    Lack{0x6502,
         "the drive does not list its modes (no 6502); it is moved once 6061 shows the one that it was told"},
    Lack{0x60C2, "the drive is not told how long a tick is (no 60C2); it goes by the period of SYNC (1006)"},
    Lack{0x607D,
         "the drive has no soft limits (no 607D); only this program keeps the axis between min and max"},
    Lack{0x605A, "the drive does not say how it brakes in a quick stop (no 605A); its manual must"},
    Lack{0x6085, "the drive is not told how hard it brakes in a quick stop (no 6085); set that in the drive"},
    Lack{0x605E, "the drive does not say how it brakes in a fault (no 605E); its manual must"},
    Lack{0x1016,
         "the drive does not watch this program's heartbeat (no 1016); its setpoint timeout (1400:5) stops "
         "it"}};

/// A length of an axis in counts of its drive, at least one.
std::int32_t whole_counts(double length, double counts_per_unit) {
  return static_cast<std::int32_t>(std::clamp(std::round(length * std::fabs(counts_per_unit)), 1.0, 1e9));
}

/// Of an end of an axis, which the drive can count to, and a little beyond.
std::int32_t in_counts(double counts) {
  constexpr auto most = static_cast<double>(std::numeric_limits<std::int32_t>::max());
  return static_cast<std::int32_t>(std::clamp(counts, -most, most));
}

constexpr can::CountRange whole_range{.min = std::numeric_limits<std::int32_t>::min(),
                                      .max = std::numeric_limits<std::int32_t>::max()};

/// From `min` to `max`, for a drive that counts `zero` where its motor is at 0. Once homed the axis may rest
/// a little outside.
can::CountRange count_range_of(const RigAxis& axis, std::int64_t zero) {
  const double scale = std::get<Cia402Drive>(axis.drive).counts_per_unit;
  const double margin = home_tolerance(axis);
  const auto [low, high] = std::minmax({(axis.min - margin) * scale, (axis.max + margin) * scale});
  const auto first = static_cast<double>(zero);
  return {.min = in_counts(first + std::floor(low)), .max = in_counts(first + std::ceil(high))};
}

/// Half as much again as it was told, and two counts for rounding, is not too fast. One that homes where it
/// stands may settle.
can::DriveHomingSpec homing_spec_of(const RigAxis& axis, const DriveHome& home, double scale,
                                    std::int32_t rate_hz) {
  constexpr double fast_share = 1.5;
  return {
      .home = static_cast<std::int32_t>(std::round(home.at * scale)),
      .tolerance = whole_counts(home_tolerance(axis), scale),
      .max_step =
          whole_counts(home.fast > 0 ? fast_share * home.fast / rate_hz : place_tolerance(axis), scale) + 2,
      .timeout_ns = static_cast<std::int64_t>(home.timeout_s * static_cast<double>(ns_per_s))};
}

/// The drive must be of the make that its data sheet is of.
void add_identity_of_sheet(const RigAxis& axis, can::Cia402Setup& setup) {
  const auto& drive = std::get<Cia402Drive>(axis.drive);
  if (drive.eds.empty()) return;
  const EdsFile eds = read_eds_file(drive.eds, drive.node);
  const auto take = [&](std::uint8_t sub, std::optional<std::uint32_t>& wanted) {
    const EdsObject* const object = eds.find(0x1018, sub);
    const bool is_told = object != nullptr && object->value.value_or(0) != 0;  // makers write 0 for any
    if (is_told && !wanted) wanted = object->value;
  };
  take(1, setup.vendor);
  take(2, setup.product);
}

can::HomingSetup homing_setup_of(const DriveHome& home, double scale) {
  return {.method = static_cast<std::uint8_t>(home.method),
          .fast = home.fast_speed,
          .slow = home.slow_speed,
          .acceleration = home.acceleration_rate,
          .offset = static_cast<std::int32_t>(std::round(home.at * scale))};
}

}  // namespace

// --- what a rig file says

can::NodeId host_node() {
  return *can::NodeId::make(127);
}

can::NodeId node_of(const RigAxis& axis) {
  return value_or_refuse(can::NodeId::make(std::get<Cia402Drive>(axis.drive).node), axis.place, named(axis));
}

can::Cia402Settings settings_of(const RigAxis& axis, std::int32_t rate_hz) {
  const Cia402Drive& drive = std::get<Cia402Drive>(axis.drive);
  const double scale = drive.counts_per_unit;
  const std::int64_t timeout_ms = heartbeats_waited_for * heartbeat_period_ns(rate_hz) / ns_per_ms;
  const std::int64_t setpoint_ms =
      std::max(min_setpoint_wait_ms, setpoints_waited_for * tick_ns(rate_hz) / ns_per_ms);
  can::Cia402Settings settings{
      .setup = {
          .node = node_of(axis),
          .host = host_node(),
          .rate_hz = rate_hz,
          .mode =
              drive.interpolates ? can::Cia402Mode::interpolated_position : can::Cia402Mode::cyclic_position,
          .host_timeout_ms = static_cast<std::uint16_t>(std::min<std::int64_t>(timeout_ms, 65'535)),
          .is_guarded = drive.is_guarded,
          .setpoint_timeout_ms = static_cast<std::uint16_t>(std::min<std::int64_t>(setpoint_ms, 65'535)),
          .position_limits = count_range_of(axis, 0),
          .place_window_counts = whole_counts(place_tolerance(axis), scale),
          .quick_stop_deceleration = drive.stop_deceleration,
          .coasts = axis.coasts,
          .stops_without_host = axis.stops_without_host,
          .watches_following_error = drive.watches_following_error,
          .vendor = drive.vendor,
          .product = drive.product,
          .serial = drive.serial}};
  // Where the drive's own count is not the axis' position, it would hold limits that lie elsewhere, or those
  // of another rig that it has kept.
  if (axis.reference != Reference::by_drive) settings.setup.position_limits = whole_range;
  if (drive.resets_node) settings.reset = can::NmtCommand::reset_node;
  settings.enable_timeout_ns =
      static_cast<std::int64_t>(drive.enable_timeout_s * static_cast<double>(ns_per_s));
  settings.hold_tolerance_counts = whole_counts(place_tolerance(axis), scale);
  settings.max_following_error_counts = whole_counts(drive.follow.max_following_error, scale);
  if (drive.homing) {
    settings.setup.homing = homing_setup_of(*drive.homing, scale);
    settings.homing = homing_spec_of(axis, *drive.homing, scale, rate_hz);
  }
  const double tick_s = 1.0 / rate_hz;
  settings.first_step_counts = whole_counts(0.5 * axis.max_acceleration * tick_s * tick_s, scale);
  // The ramp of the drive is not known; that of the axis, twice, is long enough.
  settings.disable_timeout_ns += static_cast<std::int64_t>(2 * axis.max_velocity / axis.max_acceleration *
                                                           static_cast<double>(ns_per_s));
  // A thousandth of max_velocity is rest, and a count to either side.
  const double rest_s = static_cast<double>(settings.rest_ns) / static_cast<double>(ns_per_s);
  settings.rest_counts = static_cast<std::int32_t>(std::ceil(
                             std::min(0.001 * std::fabs(scale) * axis.max_velocity * rest_s, 1e9))) +
                         1;
  settings.max_step_counts =
      static_cast<std::int32_t>(std::ceil(step_share * std::fabs(scale) * axis.max_velocity / rate_hz)) + 1;
  return settings;
}

std::string words_of(const can::SetupRefusal& refusal) {
  std::string text = fmt::format("object {:04X}h:{}", refusal.object.index, refusal.object.sub);
  const unsigned group = refusal.object.index & 0xFE00U;
  const bool is_mapping = (group == 0x1600 || group == 0x1A00) && refusal.object.sub != 0;
  if (is_mapping && !refusal.found) {
    const can::ObjectAddress mapped = can::read_mapping_value(refusal.expected).object;
    text += fmt::format(" for {:04X}h:{}", mapped.index, mapped.sub);
  }
  if (refusal.found) {
    text += fmt::format(" is {} ({:X}h)", *refusal.found, *refusal.found);
    const bool is_forbidden = *refusal.found == refusal.expected;
    if (!is_forbidden) text += fmt::format(", not {} ({:X}h)", refusal.expected, refusal.expected);
  }
  if (refusal.abort_code != 0) {
    text += fmt::format("; {:04X} {:04X}h: {}", refusal.abort_code >> 16, refusal.abort_code & 0xFFFF,
                        can::words_of_abort(refusal.abort_code));
  }
  return text;
}

std::vector<std::string> words_of_lacks(const can::Cia402Drive& host) {
  const auto& absent = host.setup().absent();
  const auto is_absent = [&](std::uint16_t index) {
    return std::ranges::find(absent, index) != absent.end();
  };
  std::vector<std::string> words;
  for (const Lack& lack : lacks) {
    if (!is_absent(lack.index)) continue;
    const bool has_no_period = lack.index == can::interpolation_time.index && is_absent(0x1006);
    words.emplace_back(has_no_period
                           ? "the drive is not told how long a tick is (neither 60C2 nor 1006); set that in "
                             "the drive"
                           : lack.words);
  }
  if (host.rpdo() != 1) {
    words.push_back(
        fmt::format("its controlword and target go in RPDO {0} (160{1}h), because RPDO 1 cannot have them",
                    host.rpdo(), host.rpdo() - 1));
  }
  for (std::uint16_t number = 1; number <= 4; ++number) {
    for (const bool is_sent : {false, true}) {
      const auto pdo = static_cast<std::uint16_t>((is_sent ? 0x1800 : 0x1400) + number - 1);
      if (!host.setup().has_kept(pdo)) continue;
      words.push_back(fmt::format("the drive keeps its {} {} (object {:04X}h:1 is fixed), which nobody {}",
                                  is_sent ? "TPDO" : "RPDO", number, pdo, is_sent ? "hears" : "sends to"));
    }
  }
  return words;
}

// --- the protocol

void Cia402Kind::count_from(can::Cia402Drive& host, const RigAxis& axis, std::int64_t zero) {
  value_or_refuse(host.set_position_limits(count_range_of(axis, zero)), axis.place, named(axis));
}

can::Cia402Drive Cia402Kind::host_of(const RigAxis& axis, std::int32_t rate_hz) {
  can::Cia402Settings settings = settings_of(axis, rate_hz);
  add_identity_of_sheet(axis, settings.setup);
  return value_or_refuse(can::Cia402Drive::make(settings), axis.place, named(axis));
}

can::Cia402Bus Cia402Kind::bus_of(std::span<can::Cia402Drive> hosts, std::int32_t rate_hz,
                                  const RigAxis& first) {
  return value_or_refuse(
      can::Cia402Bus::make(hosts, {.host = host_node(), .heartbeat_period_ns = heartbeat_period_ns(rate_hz)}),
      first.place, named(first));
}

std::string Cia402Kind::detail_of(const can::Cia402Drive& host, can::DriveFinding finding) {
  std::string text;
  if (host.last_emergency().code != 0) {
    text += fmt::format(" (EMCY {:04X}, {})", host.last_emergency().code,
                        can::words_of_emergency(host.last_emergency().code));
  } else if (host.setup().error_code() != 0) {
    text += fmt::format(" (error {:04X}h, {})", host.setup().error_code(),
                        can::words_of_emergency(host.setup().error_code()));
  }
  const bool is_of_setup = host.setup().state() == can::SetupState::refused;
  if (is_of_setup && finding == host.refusal().finding)
    text += fmt::format(" ({})", words_of(host.refusal()));
  return text;
}

std::string Cia402Kind::fitness_of(const can::Cia402Drive& host, std::int32_t rate_hz) {
  const std::uint32_t of_host = host.setup().host_timeout_ms();
  const std::uint32_t of_setpoint = host.setup().setpoint_timeout_ms();
  const std::uint32_t watchdog = of_host == 0       ? of_setpoint
                                 : of_setpoint == 0 ? of_host
                                                    : std::min(of_host, of_setpoint);
  return fmt::format("node {} has mode {}, the period of {} Hz and a watchdog of {} ms", host.node().value(),
                     static_cast<int>(host.mode()), rate_hz, watchdog);
}

std::vector<can::CanFilter> Cia402Kind::heard_by_host(const RigAxis& axis) {
  const can::NodeId node = node_of(axis);
  std::vector<can::CanFilter> filters;
  for (const can::FrameId id :
       {can::nmt_id, can::sync_id, can::heartbeat_id(host_node()), can::tpdo1_id(node), can::rpdo1_id(node),
        can::heartbeat_id(node), can::emergency_id(node), can::sdo_answer_id(node),
        can::sdo_request_id(node)}) {
    filters.push_back({.id = id});
  }
  return filters;
}

std::vector<can::CanFilter> Cia402Kind::heard_by_drive(const RigAxis& axis) {
  const can::NodeId node = node_of(axis);
  return {{.id = can::nmt_id},
          {.id = can::sync_id},
          {.id = can::heartbeat_id(host_node())},
          {.id = can::rpdo1_id(node)},
          {.id = can::sdo_request_id(node)},
          {.id = can::heartbeat_id(node), .is_remote = true}};
}

BusShare Cia402Kind::share_of(const RigFile& rig, std::span<const std::size_t> axes) {
  const auto drives = static_cast<std::int64_t>(axes.size());
  const auto guarded = std::ranges::count_if(
      axes, [&](std::size_t a) { return std::get<Cia402Drive>(rig.axes[a].drive).is_guarded; });
  return {.drives = drives,
          .frames = frames_of_bus_per_tick + drives + guarded,
          .bits = can::cyclic_bits_per_second({.rate_hz = 1, .drives = drives}),
          .bits_of_bus = can::cyclic_bits_per_second({.rate_hz = 1, .drives = 0}),
          .because = guarded > 0 ? fmt::format(", {} of them guarded,", guarded) : ""};
}

std::unique_ptr<SimulatedCanDrive> Cia402Kind::simulate(const RigAxis& axis, const SimulatedPower& power) {
  SimulatedCia402Settings settings = simulated_settings_of(axis, power.position);
  settings.keeps_record = power.keeps_record;
  return std::make_unique<SimulatedCia402Drive>(settings, power.now_ns);
}

SimulatedCia402Settings simulated_settings_of(const RigAxis& axis, double position) {
  const auto& drive = std::get<Cia402Drive>(axis.drive);
  SimulatedCia402Settings settings{
      .node = node_of(axis),
      .position = static_cast<std::int32_t>(std::floor(position * drive.counts_per_unit + 0.5))};
  if (!drive.eds.empty()) {
    const EdsFile eds = read_eds_file(drive.eds, drive.node);
    settings.objects = dictionary_of(eds, settings.node);
    const EdsObject* const window = eds.find(can::window_index, 0);
    if (window != nullptr && !window->value) {
      constexpr double window_s = 0.1;  // the distance at max_velocity
      settings.objects->set(
          can::window_index, 0,
          static_cast<std::uint32_t>(whole_counts(window_s * axis.max_velocity, drive.counts_per_unit)));
    }
  }
  if (axis.drive_home) settings.home_switch = axis.drive_home->at * drive.counts_per_unit;
  settings.counts_from_power_on = drive.homing.has_value();
  settings.motor.max_acceleration =
      std::max(settings.motor.max_acceleration, 4 * std::fabs(drive.counts_per_unit) * axis.max_acceleration);
  return settings;
}

}  // namespace inbetween
