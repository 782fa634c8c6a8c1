#include "host_tools/rig/eds_drive.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "host_tools/rig/cia402_kind.hpp"
#include "host_tools/rig_model/rig_motors.hpp"
#include "inbetween/can/cia402_bus.hpp"
#include "inbetween/can/pdo.hpp"
#include "inbetween/loop/tick_time.hpp"
#include "sim/can_bus.hpp"
#include "sim/cia402_objects.hpp"

namespace inbetween {
namespace {

using Access = ObjectDictionary::Access;

Access access_of(const EdsObject& object) {
  if (!object.can_be_read) return Access::write_only;
  return object.can_be_written ? Access::read_write : Access::read_only;
}

/// Objects of which the program asks that somebody has set them in the drive.
struct Setting {
  can::ObjectAddress object;
  std::uint32_t value;
};
constexpr std::array set_by_somebody{Setting{{.index = 0x1005}, can::sync_id.number()},
                                     Setting{{.index = 0x6065}, 1}, Setting{{.index = 0x607B, .sub = 1}, 0},
                                     Setting{{.index = 0x607B, .sub = 2}, 0}};

SimulatedCia402Settings with_settings(SimulatedCia402Settings drive) {
  for (const Setting& setting : set_by_somebody) {
    const ObjectDictionary::Object* const object = drive.objects->find(setting.object);
    const bool can_be_set = object != nullptr && object->access == Access::read_write;
    if (can_be_set) drive.objects->set(setting.object.index, setting.object.sub, setting.value);
  }
  return drive;
}

/// Ticks until the drive is set up or refused.
void set_up(can::Cia402Bus& bus, SimulatedCia402Drive& drive, std::int32_t rate_hz) {
  SimulatedCanBus wire;
  wire.attach(drive);
  std::array<can::Frame, can::Cia402Bus::frames_per_tick(1)> frames;
  constexpr std::int64_t longest_s = 20;
  can::Cia402Drive& host = bus.drives().front();
  for (std::int64_t tick = 1; tick < longest_s * rate_hz; ++tick) {
    const std::int64_t now_ns = tick * (ns_per_s / rate_hz);
    for (const can::Frame& frame : wire.run(now_ns)) bus.receive(frame, now_ns);
    if (host.phase() == can::DrivePhase::off && now_ns > 2 * ns_per_s) host.connect(now_ns);
    if (host.phase() == can::DrivePhase::idle || host.phase() == can::DrivePhase::refused) return;
    const std::size_t count = bus.tick(now_ns, {}, frames).value();
    for (std::size_t i = 0; i < count; ++i) wire.send(frames.at(i));
  }
}

/// ", and the data sheet has HighLimit = 1": what is refused may only be a limit in a file.
std::string limits_in_words(const EdsObject* object) {
  if (object == nullptr || !(object->low || object->high)) return "";
  std::string words = ", and the data sheet has";
  if (object->low) words += fmt::format(" LowLimit = {}", *object->low);
  if (object->low && object->high) words += " and";
  if (object->high) words += fmt::format(" HighLimit = {}", *object->high);
  return words;
}

/// Some drives interpolate in one period only: the rig can go by that.
std::string remedy_of_period(const EdsFile& eds, const can::SetupRefusal& refusal) {
  const bool is_period = refusal.object == can::interpolation_time && refusal.found.value_or(0) != 0;
  if (!is_period) return "";
  const EdsObject* const exponent =
      eds.find(can::interpolation_exponent.index, can::interpolation_exponent.sub);
  constexpr std::uint32_t milliseconds = 0xFD;
  const auto index =
      static_cast<std::int8_t>(exponent == nullptr ? milliseconds : exponent->value.value_or(milliseconds));
  const double rate_hz = std::pow(10.0, -index) / *refusal.found;
  return std::fabs(rate_hz - std::round(rate_hz)) > 1e-9
             ? ""
             : fmt::format("write rate_hz = {:g} in the rig, which is the period that the drive has",
                           rate_hz);
}

/// Returns the warnings of its sheet.
std::vector<std::string> refuse_unfit_drive(const RigAxis& axis, std::int32_t rate_hz) {
  const auto& drive = std::get<Cia402Drive>(axis.drive);
  const EdsFile eds = read_eds_file(drive.eds, drive.node);
  std::vector<can::Cia402Drive> hosts{
      value_or_refuse(can::Cia402Drive::make(settings_of(axis, rate_hz)), axis.place, named(axis))};
  const std::int64_t between_ns = hosts.front().host_timeout_ns() / can::life_time_factor;
  can::Cia402Bus bus =
      value_or_refuse(can::Cia402Bus::make(hosts, {.host = host_node(), .heartbeat_period_ns = between_ns}),
                      axis.place, named(axis));
  SimulatedCia402Drive simulated(with_settings(simulated_settings_of(axis, 0)), 0);
  set_up(bus, simulated, rate_hz);
  const can::Cia402Drive& host = hosts.front();
  if (host.phase() == can::DrivePhase::idle) return eds.warnings;
  // Of a mapping that is refused, the line is that of the object which may not be in it.
  const bool is_of_mapping = host.refusal().abort_code == can::abort_not_mappable;
  const can::ObjectAddress asked =
      is_of_mapping ? can::read_mapping_value(host.refusal().expected).object : host.refusal().object;
  const EdsObject* const object = eds.find(asked.index, asked.sub);
  const can::DriveFindingWords words = can::words_of(host.first_finding().value());
  const std::string remedy = remedy_of_period(eds, host.refusal());
  throw InputError({eds.path, object == nullptr ? 0 : object->line, 0},
                   fmt::format("{}: {} ({}{}); {}", named(axis), words.what, words_of(host.refusal()),
                               limits_in_words(object), remedy.empty() ? words.remedy : remedy));
}

}  // namespace

ObjectDictionary dictionary_of(const EdsFile& eds, can::NodeId node) {
  const ObjectDictionary of_profile = factory_objects(node);
  ObjectDictionary objects;
  for (const EdsObject& object : eds.objects) {
    const can::ObjectAddress address{.index = object.index, .sub = object.sub};
    const ObjectDictionary::Object* const usual = of_profile.find(address);
    const bool is_usual_number = usual != nullptr && usual->bytes.empty();
    if (object.size == 0 && !is_usual_number) {
      // An object of no length is one of which the data sheet does not tell it.
      std::vector<std::uint8_t> bytes = object.bytes;
      if (bytes.empty()) bytes.resize(1);
      objects.add(address, {.access = access_of(object), .bytes = bytes});
      continue;
    }
    ObjectDictionary::Object number{.size = object.size == 0 ? usual->size : object.size,
                                    .access = access_of(object),
                                    .can_be_mapped = object.can_be_mapped};
    number.min = object.low.value_or(number.min);
    number.max = object.high.value_or(number.max);
    number.value =
        object.value.value_or(std::clamp(is_usual_number ? usual->value : 0, number.min, number.max));
    objects.add(address, number);
  }
  return objects;
}

std::vector<std::string> refuse_unfit_drives(const RigFile& rig) {
  std::vector<std::string> warnings;
  for (const RigAxis& axis : motors_of(rig).rig.axes) {
    const auto* const drive = std::get_if<Cia402Drive>(&axis.drive);
    if (drive == nullptr || drive->eds.empty()) continue;
    for (std::string& warning : refuse_unfit_drive(axis, rig.rate_hz)) {
      if (std::ranges::find(warnings, warning) == warnings.end()) warnings.push_back(std::move(warning));
    }
  }
  return warnings;
}

}  // namespace inbetween
