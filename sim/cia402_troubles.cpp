// The faults of a simulated drive.
#include <cmath>

#include "sim/cia402_drive.hpp"

namespace inbetween {
namespace {

constexpr std::uint32_t watches_nothing = 0xFFFFFFFF;
constexpr std::uint32_t function_bits = 0x780;  // of an identifier; the others are the node

}  // namespace

void SimulatedCia402Drive::meet(const DriveTrouble& trouble) {
  switch (trouble.kind) {
    case Kind::emergency:
      return fail(static_cast<std::uint16_t>(trouble.value));
    case Kind::move_by_hand:
      return motor_.put(motor_.position() + trouble.value);
    case Kind::foreign_sender: {
      const auto target = static_cast<std::int32_t>(std::lround(here()));
      const can::Frame frame =
          can::command_frame(node(), {.controlword = can::control_enable_operation, .target = target});
      send(frame);
      return receive(frame);
    }
    case Kind::no_window:
      return add_object({.index = 0x6065}, {.value = watches_nothing});
    case Kind::no_watchdog:
      remove_object({.index = 0x1016, .sub = 1});
      return remove_object({.index = 0x1400, .sub = can::pdo_sub_event_timer});
    case Kind::no_object:
      return remove_object(trouble.object);
    case Kind::fixed_object: {
      ObjectDictionary::Object fixed = *objects_.find(trouble.object);
      fixed.access = ObjectDictionary::Access::read_only;
      fixed.value = static_cast<std::uint32_t>(trouble.value);
      return add_object(trouble.object, fixed);
    }
    case Kind::silent_object:
      return change_access(trouble.object, ObjectDictionary::Access::silent);
    case Kind::switched_off:
      return enter(can::Cia402State::switch_on_disabled);
    case Kind::put_by_hand:
    case Kind::reboot:
    case Kind::lose_feedback:
    case Kind::lose_heartbeat:
    case Kind::stick:
    case Kind::run_away:
    case Kind::blind:
    case Kind::other_scale:
    case Kind::wrong_mode:
    case Kind::ignore_target:
    case Kind::lose_sent:
    case Kind::lose_heard:
    case Kind::shorten:
    case Kind::duplicate:
    case Kind::flood:
    case Kind::stay_on:
    case Kind::sink:
    case Kind::no_home:
    case Kind::homing_error:
      return;  // while they last, something else is done where it would be
  }
}

/// A wire has every frame; the drive takes these.
bool SimulatedCia402Drive::is_meant_for_it(const can::Frame& frame) const {
  if (frame.id == can::nmt_id || frame.id == can::sync_id) return true;
  if (frame.is_remote) return true;
  const std::uint32_t host = objects_.value(0x1016, 1) >> 16;
  const std::uint32_t function = frame.id.number() & function_bits;
  if (function == (can::heartbeat_id(node()).number() & function_bits))
    return (frame.id.number() & ~function_bits) == host;
  const bool is_of_host = function == (can::sdo_request_id(node()).number() & function_bits) ||
                          function == (can::rpdo1_id(node()).number() & function_bits);
  return is_of_host && (frame.id.number() & ~function_bits) == node().value();
}

void SimulatedCia402Drive::babble() {
  if (is_booting_) return;
  for (std::int64_t due = troubles_.flood(now_ns_); due > 0; --due) {
    send(can::sdo_frame(can::sdo_answer_id(node()), {.kind = can::SdoKind::upload_value,
                                                     .object = {.index = 0x1000},
                                                     .size = 4,
                                                     .value = objects_.value(0x1000)}));
  }
}

}  // namespace inbetween
