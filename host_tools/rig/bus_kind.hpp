// What a protocol of drives on a CAN bus brings to the host tools, and the list of all of them.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "host_tools/rig/cia402_kind.hpp"
#include "host_tools/rig/servo_kinds.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "inbetween/loop/axis_watch.hpp"

namespace inbetween {

/// Calls `look.template operator()<Kind>()` for each protocol. A protocol that is not here does not exist for
/// run, doctor, sim-drives and the simulation. docs/new-drive.md says what a Kind has.
template <class Look>
void for_each_bus_kind(Look&& look) {
  look.template operator()<Cia402Kind>();
  look.template operator()<OdriveKind>();
  look.template operator()<MoteusKind>();
  look.template operator()<RmdKind>();
  look.template operator()<CubemarsKind>();
}

/// Whether the drive of an axis speaks the protocol.
template <class Kind>
bool is_of_kind(const RigAxis& axis) {
  return std::holds_alternative<typename Kind::InRig>(axis.drive);
}
/// The axes of the rig that do, on one bus if it is named.
template <class Kind>
std::vector<std::size_t> axes_of_kind(const RigFile& rig, const std::string& bus = "") {
  std::vector<std::size_t> axes;
  for (std::size_t a = 0; a < rig.axes.size(); ++a) {
    const auto* const drive = std::get_if<typename Kind::InRig>(&rig.axes[a].drive);
    if (drive != nullptr && (bus.empty() || drive->bus == bus)) axes.push_back(a);
  }
  return axes;
}
/// Calls `use.template operator()<Kind>()` with the protocol of an axis; nothing for an axis on no CAN bus.
template <class Use>
void with_kind_of(const RigAxis& axis, Use&& use) {
  for_each_bus_kind([&]<class Kind>() {
    if (is_of_kind<Kind>(axis)) use.template operator()<Kind>();
  });
}

/// What is asked of the motor of an axis, whatever its drive makes of it.
AxisWatch watch_of(const RigAxis& axis);

/// The frames of the drives on a bus in a tick, and at worst their bits on the wire.
BusShare share_of_bus(const RigFile& rig, const Bus& bus);
/// Throws InputError at the place of a bus whose load would be above bus_load_limit_percent, or that has more
/// frames in a tick than are sent at once; and at an axis whose drive has an identifier in common with one of
/// another protocol.
void refuse_overloaded_buses(const RigFile& rig);

}  // namespace inbetween
