#include "inbetween/can/cia402_setup.hpp"

#include <utility>

#include "inbetween/can/pdo.hpp"

namespace inbetween::can {
namespace {

/// Adds steps until one does not fit.
class ScriptWriter {
 public:
  explicit ScriptWriter(SetupScript& script) : script_(&script) {}
  void add(const SetupStep& step) {
    if (status_) status_ = script_->push_back(step);
  }
  void write(ObjectAddress object, std::uint8_t size, std::uint32_t value) {
    add({.object = object, .size = size, .value = value});
  }
  void write_if_there(ObjectAddress object, std::uint8_t size, std::uint32_t value) {
    add({.object = object, .size = size, .may_be_absent = true, .value = value});
  }
  void compare(ObjectAddress object, std::uint8_t size, std::uint32_t value,
               std::uint32_t mask = 0xFFFFFFFF) {
    add({.action = SetupAction::compare, .object = object, .size = size, .value = value, .mask = mask});
  }
  [[nodiscard]] const Status& status() const { return status_; }

 private:
  SetupScript* script_;
  Status status_ = Done{};
};

/// A PDO of the pre-defined connection set: `number` 1 to 4.
struct Pdo {
  std::uint16_t communication;
  std::uint16_t mapping;
};
constexpr Pdo rpdo(unsigned number) {
  return {.communication = static_cast<std::uint16_t>(0x1400 + number - 1),
          .mapping = static_cast<std::uint16_t>(0x1600 + number - 1)};
}
constexpr Pdo tpdo(unsigned number) {
  return {.communication = static_cast<std::uint16_t>(0x1800 + number - 1),
          .mapping = static_cast<std::uint16_t>(0x1A00 + number - 1)};
}
constexpr ObjectAddress cob_id_of(const Pdo& pdo) {
  return {.index = pdo.communication, .sub = pdo_sub_cob_id};
}
constexpr std::uint8_t every_sync = 1;
constexpr std::uint32_t bit_of(unsigned code) {
  return std::uint32_t{1} << code;
}

/// Whether it is as map() and switch_on() make it: some drives have a PDO that cannot be changed.
void compare(ScriptWriter& writer, const Pdo& pdo, const PdoMapping& mapping, std::uint32_t cob_id) {
  writer.compare(cob_id_of(pdo), 4, cob_id, ~cob_id_without_rtr);
  writer.compare({.index = pdo.mapping}, 1, static_cast<std::uint32_t>(mapping.entries().size()));
  std::uint8_t sub = 0;
  for (const PdoEntry& entry : mapping.entries()) {
    writer.compare({.index = pdo.mapping, .sub = ++sub}, 4, mapping_value(entry));
  }
  writer.compare({.index = pdo.communication, .sub = pdo_sub_type}, 1, every_sync);
}

/// The order of a mapping: switched off, no objects, then one after the other, then how many.
void map(ScriptWriter& writer, const Pdo& pdo, const PdoMapping& mapping) {
  writer.add({.action = SetupAction::switch_off, .object = cob_id_of(pdo), .unless_so = true});
  const auto write = [&](ObjectAddress object, std::uint8_t size, std::uint32_t value) {
    writer.add({.action = SetupAction::write_at_once,
                .object = object,
                .size = size,
                .unless_so = true,
                .value = value});
  };
  write({.index = pdo.mapping}, 1, 0);
  std::uint8_t count = 0;
  for (const PdoEntry& entry : mapping.entries()) {
    write({.index = pdo.mapping, .sub = ++count}, 4, mapping_value(entry));
  }
  write({.index = pdo.mapping}, 1, count);
  write({.index = pdo.communication, .sub = pdo_sub_type}, 1, every_sync);
}

void switch_on(ScriptWriter& writer, const Pdo& pdo, std::uint32_t cob_id) {
  writer.add({.action = SetupAction::switch_on, .object = cob_id_of(pdo), .value = cob_id});
}

/// A fault from before this program was there has no emergency that it could hear.
void ask_for_error(ScriptWriter& writer) {
  writer.add({.action = SetupAction::note_error, .object = {.index = 0x603F}, .size = 2});
  writer.add({.action = SetupAction::note_error, .object = {.index = 0x1003, .sub = 1}});
}

void check_identity(ScriptWriter& writer, const Cia402Setup& setup) {
  constexpr std::uint32_t profile = 402;
  const auto expect = [&](ObjectAddress object, std::uint32_t value, std::uint32_t mask, DriveFinding finding,
                          bool may_be_absent = false) {
    writer.add({.action = SetupAction::expect,
                .finding = finding,
                .object = object,
                .may_be_absent = may_be_absent,
                .value = value,
                .mask = mask});
  };
  constexpr std::uint32_t all = 0xFFFFFFFF;
  expect({.index = 0x1000}, profile, 0xFFFF, DriveFinding::wrong_device);
  if (setup.vendor) expect({.index = 0x1018, .sub = 1}, *setup.vendor, all, DriveFinding::wrong_device);
  if (setup.product) expect({.index = 0x1018, .sub = 2}, *setup.product, all, DriveFinding::wrong_device);
  if (setup.serial) expect({.index = 0x1018, .sub = 4}, *setup.serial, all, DriveFinding::wrong_device);
  const std::uint32_t mode_bit = 1U << (static_cast<unsigned>(setup.mode_of_operation()) - 1);
  // A drive that does not say which modes it has is told to take this one, and must show it before it is
  // enabled.
  expect({.index = 0x6502}, mode_bit, mode_bit, DriveFinding::mode_not_offered, true);
  // No producer of SYNC, and the identifier that the host uses: without the object it has no other.
  expect({.index = 0x1005}, sync_id.number(), 0x40000000 | cob_id_number, DriveFinding::sync_of_another,
         true);
}

void set_pdos(ScriptWriter& writer, const Cia402Setup& setup) {
  const auto switch_off = [&](const Pdo& pdo) {
    writer.add({.action = SetupAction::switch_off,
                .object = cob_id_of(pdo),
                .may_be_absent = true,
                .may_stay = true});
  };
  for (unsigned number = 1; number <= 4; ++number) {
    if (number != setup.rpdo) switch_off(rpdo(number));
    if (number != 1) switch_off(tpdo(number));
  }
  const Pdo received = rpdo(setup.rpdo);
  const std::uint32_t id = rpdo_id(setup.node, setup.rpdo).number();
  compare(writer, received, command_mapping(setup.mode), id);
  map(writer, received, command_mapping(setup.mode));
  writer.add({.action = SetupAction::watchdog,
              .object = {.index = received.communication, .sub = pdo_sub_event_timer},
              .size = 2,
              .may_be_absent = true,
              .value = setup.setpoint_timeout_ms});
  switch_on(writer, received, id);

  compare(writer, tpdo(1), feedback_mapping(), tpdo1_id(setup.node).number());
  map(writer, tpdo(1), feedback_mapping());
  writer.write_if_there({.index = tpdo(1).communication, .sub = pdo_sub_inhibit}, 2, 0);
  writer.write_if_there({.index = tpdo(1).communication, .sub = pdo_sub_event_timer}, 2, 0);
  switch_on(writer, tpdo(1), tpdo1_id(setup.node).number());
}

void set_period(ScriptWriter& writer, const Cia402Setup& setup, const InterpolationPeriod& period) {
  // The counter may be changed while the period is 0 only.
  writer.add({.action = SetupAction::try_write, .object = {.index = 0x1006}, .may_be_absent = true});
  writer.add({.object = {.index = 0x1019},
              .size = 1,
              .may_be_absent = setup.sync_overflow == 0,
              .value = setup.sync_overflow});
  writer.write_if_there(interpolation_time, 1, period.value);
  writer.write_if_there(interpolation_exponent, 1, static_cast<std::uint8_t>(period.index));
  if (setup.mode != Cia402Mode::interpolated_position) return;
  writer.write_if_there({.index = 0x60C0}, 2, 0);  // in straight lines
  // 0 empties its buffer of set-points, and 1 lets it take some. Many drives have none, or do not tell.
  for (const std::uint32_t access : {0U, 1U}) {
    writer.add({.action = SetupAction::try_write,
                .object = {.index = 0x60C4, .sub = 6},
                .size = 1,
                .may_be_absent = true,
                .may_be_hidden = true,
                .value = access});
  }
}

void set_motion(ScriptWriter& writer, const Cia402Setup& setup) {
  if (setup.following_error_window) writer.write({.index = window_index}, 4, *setup.following_error_window);
  if (setup.following_error_timeout_ms) writer.write({.index = 0x6066}, 2, *setup.following_error_timeout_ms);
  writer.add({.action = SetupAction::forbid,
              .finding = DriveFinding::window_disabled,
              .object = {.index = window_index},
              .may_be_absent = setup.watches_following_error,
              .value = 0xFFFFFFFF});
  // Off is the whole range of counts, or 0 to 0 in drives that leave the factory so.
  for (const auto& [sub, whole] : {std::pair{1, 0x80000000U}, std::pair{2, 0x7FFFFFFFU}}) {
    writer.add({.action = SetupAction::expect_no_range,
                .finding = DriveFinding::counts_round,
                .object = {.index = range_limit_index, .sub = static_cast<std::uint8_t>(sub)},
                .may_be_absent = true,
                .value = whole});
  }
  if (!setup.position_limits) return;
  // A drive moves an axis that stands outside, as soon as it is switched on.
  writer.add({.action = SetupAction::note_place, .object = {.index = 0x6064}});
  const auto add = [&](SetupAction action, std::uint8_t sub, std::int32_t counts) {
    writer.add({.action = action,
                .object = {.index = position_limit_index, .sub = sub},
                .may_be_absent = true,
                .value = static_cast<std::uint32_t>(counts),
                .mask = static_cast<std::uint32_t>(setup.place_window_counts)});
  };
  // Drives compare the two at each write. Where max is below the old min, it is taken after the new one.
  add(SetupAction::try_limit, 2, setup.position_limits->max);
  add(SetupAction::limit, 1, setup.position_limits->min);
  add(SetupAction::limit, 2, setup.position_limits->max);
}

/// How it leaves operation, each time by a ramp. The profile does not ask for these objects, and a drive that
/// has one may know fewer codes: any that brakes is right.
void set_ramps(ScriptWriter& writer, const Cia402Setup& setup) {
  const auto choose = [&](std::uint16_t index, std::int16_t code, std::uint32_t codes) {
    writer.add({.action = SetupAction::write_code,
                .finding = DriveFinding::would_coast,
                .object = {.index = index},
                .size = 2,
                .may_be_absent = true,
                .value = static_cast<std::uint16_t>(code),
                .mask = setup.coasts ? codes | bit_of(0) : codes});
  };
  constexpr std::uint32_t one_ramp = bit_of(1);
  constexpr std::uint32_t four_ramps = bit_of(1) | bit_of(2) | bit_of(3) | bit_of(4);
  choose(0x605A, setup.quick_stop_option, four_ramps | (four_ramps << 4));  // quick stop
  choose(0x605B, 1, one_ramp);                                              // shutdown
  choose(0x605C, 1, one_ramp);                                              // disable operation
  choose(0x605D, 2, four_ramps);                                            // halt
  choose(fault_reaction_index, 2, four_ramps);
  if (!setup.quick_stop_deceleration) return;
  writer.add({.action = SetupAction::write_near,
              .finding = DriveFinding::stop_differs,
              .object = {.index = 0x6085},
              .may_be_absent = true,
              .value = *setup.quick_stop_deceleration});
}

/// How it homes by itself. A drive may round speeds and accelerations, and needs no offset that is 0.
void set_homing(ScriptWriter& writer, const HomingSetup& homing) {
  writer.write({.index = 0x6098}, 1, homing.method);
  writer.add({.object = {.index = 0x607C},
              .may_be_absent = homing.offset == 0,
              .value = static_cast<std::uint32_t>(homing.offset)});
  if (homing.fast == 0) return;
  const auto write_near = [&](ObjectAddress object, std::uint32_t value) {
    writer.add({.action = SetupAction::write_near, .object = object, .value = value});
  };
  write_near({.index = 0x6099, .sub = 1}, homing.fast);
  write_near({.index = 0x6099, .sub = 2}, homing.slow);
  write_near({.index = 0x609A}, homing.acceleration);
}

/// It makes the drive notice a dead host.
void set_host_watch(ScriptWriter& writer, const Cia402Setup& setup) {
  const auto watch = [&](ObjectAddress object, std::uint8_t size, std::uint32_t value, bool may_be_absent) {
    writer.add({.action = SetupAction::watchdog,
                .finding = DriveFinding::watchdog_unset,
                .object = object,
                .size = size,
                .may_be_absent = may_be_absent,
                .value = value});
  };
  if (setup.is_guarded) {
    // A drive that sends heartbeats answers no questions.
    writer.write_if_there(heartbeat_producer, 2, 0);
    watch(guard_time, 2, setup.host_timeout_ms / life_time_factor, false);
    watch(life_factor, 1, life_time_factor, false);
    return;
  }
  // A setpoint timeout stands in where it does not exist.
  watch(heartbeat_consumer, 4, (std::uint32_t{setup.host.value()} << 16) | setup.host_timeout_ms, true);
}

void set_watch(ScriptWriter& writer, const Cia402Setup& setup, const InterpolationPeriod& period) {
  // A drive that has no 1029 goes to pre-operational, which is what 0 asks for.
  writer.write_if_there({.index = 0x1029, .sub = 1}, 1, 0);
  // 3 is a quick stop; 1 a fault, with its reaction; 2 takes the power away.
  constexpr std::uint32_t brakes = bit_of(3) | bit_of(1);
  writer.add({.action = SetupAction::write_code,
              .finding = DriveFinding::host_loss_unbraked,
              .object = {.index = host_loss_index},
              .size = 2,
              .may_be_absent = setup.stops_without_host,
              .value = 3,
              .mask = setup.coasts ? brakes | bit_of(2) : brakes});
  set_host_watch(writer, setup);
  // The period of SYNC is exactly that or 0: drives tune their clocks by it. With it many drives are in fault
  // when SYNC is half a period late, which one late tick brings about; without, they watch SYNC no more, and
  // its loss is found by the host's heartbeat, of which one may be late. A drive that cannot watch the
  // heartbeat watches SYNC: its setpoint timer alone may stand still without.
  writer.add({.action = SetupAction::sync_watch,
              .object = {.index = 0x1006},
              .may_be_absent = true,
              .value = static_cast<std::uint32_t>(period.microseconds)});
  if (setup.is_guarded) return;
  writer.add({.action = SetupAction::watchdog,
              .object = heartbeat_producer,
              .size = 2,
              .value = setup.drive_heartbeat_ms});
}

Status check(const Cia402Setup& setup) {
  const auto refuse = [](const char* what, const char* remedy) {
    return Error{.code = ErrorCode::out_of_range, .what = what, .remedy = remedy};
  };
  if (setup.node == setup.host) return refuse("host and drive are the same node", "give each its own number");
  const bool has_no_guard_time = setup.is_guarded && setup.host_timeout_ms < life_time_factor;
  if (setup.drive_heartbeat_ms == 0 || setup.host_timeout_ms == 0 || setup.setpoint_timeout_ms == 0 ||
      has_no_guard_time) {
    return refuse("a heartbeat or timeout of 0 ms watches nothing", "give it in milliseconds");
  }
  if (setup.quick_stop_option < 1 || setup.quick_stop_option > 8) {
    return refuse("the drive would not brake in a quick stop", "use 1 to 8 for object 605A");
  }
  if (setup.quick_stop_deceleration == 0U) {
    return refuse("a deceleration of 0 stops nothing", "give it in units of the drive");
  }
  if (setup.sync_overflow == 1 || setup.sync_overflow > 240) {
    return refuse("the counter of SYNC cannot end at this number", "use 0 for no counter, or 2 to 240");
  }
  if (setup.following_error_window == 0xFFFFFFFFU) {
    return refuse("a following error window of FFFFFFFF watches nothing", "give it in counts");
  }
  if (setup.homing && !is_homing_method(setup.homing->method)) {
    return refuse("the profile has no such method of homing", "use 1 to 14, 17 to 30, 33 to 35 or 37");
  }
  if (setup.rpdo < 1 || setup.rpdo > 4) return refuse("a drive has the RPDOs 1 to 4", "use one of them");
  if (setup.place_window_counts < 0) {
    return refuse("the window around where an axis stands is negative", "give it in counts");
  }
  if (setup.position_limits && setup.position_limits->min >= setup.position_limits->max) {
    return refuse("the range of positions is empty", "give min first, below max");
  }
  return Done{};
}

}  // namespace

/// What is done to one RPDO is done to the other.
void change_rpdo(SetupScript& script, NodeId node, std::uint8_t from, std::uint8_t to) {
  const auto away = static_cast<std::uint16_t>(from - 1);
  const auto wanted = static_cast<std::uint16_t>(to - 1);
  for (SetupStep& step : script) {
    const unsigned group = step.object.index & 0xFFFCU;
    if (group != 0x1400 && group != 0x1600) continue;
    const unsigned number = step.object.index & 3U;
    if (number != away && number != wanted) continue;
    const bool has_cob_id =
        group == 0x1400 && step.object.sub == pdo_sub_cob_id && step.value == rpdo_id(node, from).number();
    if (has_cob_id) step.value = rpdo_id(node, to).number();
    step.object.index = static_cast<std::uint16_t>(group | (number == away ? wanted : away));
  }
}

// A script by value would stand on the stack of a microcontroller twice.
Status write_setup_script(const Cia402Setup& setup, SetupScript& script) {
  if (const Status valid = check(setup); !valid) return valid.error();
  const Result<InterpolationPeriod> period = interpolation_period(setup.rate_hz);
  if (!period) return period.error();
  script.clear();
  ScriptWriter writer(script);
  check_identity(writer, setup);
  set_pdos(writer, setup);
  set_period(writer, setup, *period);
  set_motion(writer, setup);
  set_ramps(writer, setup);
  set_watch(writer, setup, *period);
  if (setup.homing) set_homing(writer, *setup.homing);
  // 6061 in the process data shows whether it was taken.
  writer.add({.action = SetupAction::write_at_once,
              .object = {.index = 0x6060},
              .size = 1,
              .may_be_hidden = true,
              .value = static_cast<std::uint8_t>(setup.mode_of_operation())});
  // A drive that shows its mode only once it is enabled may be in another one until then.
  writer.add({.action = SetupAction::look, .object = {.index = 0x60FF}});
  writer.add({.action = SetupAction::look, .object = {.index = 0x6071}, .size = 2});
  ask_for_error(writer);
  return writer.status();
}

}  // namespace inbetween::can
