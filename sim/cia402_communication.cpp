// A simulated drive speaks and hears NMT, heartbeats, guarding, SYNC, EMCY and PDO.
#include <algorithm>
#include <cmath>

#include "inbetween/can/little_endian.hpp"
#include "inbetween/can/pdo.hpp"
#include "inbetween/can/sync.hpp"
#include "sim/cia402_drive.hpp"

namespace inbetween {
namespace {

using can::NmtState;

constexpr std::int64_t ms = 1'000'000;
constexpr std::uint8_t error_of_communication = 0x11;
constexpr std::uint16_t last_of_communication = 0x1FFF;

/// A data sheet may map an object that is longer than any number here.
constexpr std::uint64_t low_bits(unsigned bits) {
  return bits < 32 ? (std::uint64_t{1} << bits) - 1 : 0xFFFFFFFF;
}

/// That of a COB-ID, or of what else may be larger.
can::FrameId standard_id(std::uint32_t cob_id) {
  return can::FrameId::standard(cob_id & can::cob_id_number);
}

unsigned bits_of(const std::vector<can::PdoEntry>& objects) {
  unsigned bits = 0;
  for (const can::PdoEntry& object : objects) bits += object.bits;
  return bits;
}

}  // namespace

void SimulatedCia402Drive::boot() {
  is_booting_ = false;
  send(can::heartbeat_frame(node(), NmtState::boot_up));
  nmt_ = NmtState::pre_operational;
  heartbeat_ns_ = now_ns_;
}

/// As after power-on: it is where it is, and calls that 0.
void SimulatedCia402Drive::start_anew() {
  objects_ = defaults_;
  settings_revision_.reset();
  zero_ = motor_.position();
  last_word_ = 0;
  is_limited_ = false;
  is_following_error_ = false;
  is_home_ = false;
  has_homing_error_ = false;
  enter(can::Cia402State::switch_on_disabled);
  enter(NmtState::boot_up);
}

void SimulatedCia402Drive::enter(NmtState nmt) {
  const bool leaves_operational = nmt_ == NmtState::operational && nmt != NmtState::operational;
  nmt_ = nmt;
  if (leaves_operational) react_to_lost_communication();
  setpoint_deadline_ns_.reset();
  waiting_.fill({});
  transfer_.reset();
  // SYNC and the host's heartbeat are watched in pre-operational as well.
  if (nmt == NmtState::stopped || nmt == NmtState::boot_up) {
    host_deadline_ns_.reset();
    sync_deadline_ns_.reset();
    guard_deadline_ns_.reset();
  }
  if (nmt != NmtState::boot_up) return;
  missing_ = 0;
  guard_toggle_ = false;
  is_booting_ = true;
  boot_ns_ = now_ns_ + settings_.boot_delay_ns;
  objects_.restore(defaults_, 0, last_of_communication);
}

void SimulatedCia402Drive::obey(const can::NmtOrder& order) {
  if (order.node != 0 && order.node != node().value()) return;
  switch (order.command) {
    case can::NmtCommand::start:
      return enter(NmtState::operational);
    case can::NmtCommand::stop:
      return enter(NmtState::stopped);
    case can::NmtCommand::enter_pre_operational:
      return enter(NmtState::pre_operational);
    case can::NmtCommand::reset_node:
      return start_anew();
    case can::NmtCommand::reset_communication:
      return enter(NmtState::boot_up);
  }
}

void SimulatedCia402Drive::raise_error(std::uint16_t code, std::uint8_t error_register) {
  objects_.set(0x1001, 0, error_register);
  objects_.set(0x603F, 0, code);
  if (is_booting_ || nmt_ == NmtState::stopped) return;
  record_reported(code);
  send(can::emergency_frame(node(), {.code = code, .error_register = error_register}));
}

void SimulatedCia402Drive::watch_communication() {
  if (is_booting_) return;
  const std::int64_t period_ns = settings_now().heartbeat_period_ns;
  if (period_ns > 0 && now_ns_ >= heartbeat_ns_) {
    heartbeat_ns_ = now_ns_ + period_ns;
    if (!has_trouble(Kind::lose_heartbeat)) send(can::heartbeat_frame(node(), nmt_));
  }
  const auto is_over = [this](std::optional<std::int64_t>& deadline_ns) {
    if (!deadline_ns || now_ns_ < *deadline_ns) return false;
    deadline_ns.reset();
    return true;
  };
  const auto watch = [&](std::optional<std::int64_t>& deadline_ns, Watched what, std::uint16_t code) {
    if (!is_over(deadline_ns)) return;
    missing_ |= what;
    lose_communication(code);
  };
  watch(host_deadline_ns_, host_heartbeat, 0x8130);
  watch(guard_deadline_ns_, guarding, 0x8130);
  watch(setpoint_deadline_ns_, setpoints, 0x8250);
  watch(sync_deadline_ns_, sync, 0x8100);
}

void SimulatedCia402Drive::has_come(Watched what) {
  if ((missing_ & what) == 0) return;
  missing_ &= ~static_cast<unsigned>(what);
  if (missing_ == 0 && state_ != can::Cia402State::fault) raise_error(0, 0);
}

void SimulatedCia402Drive::lose_communication(std::uint16_t code) {
  raise_error(code, error_of_communication);
  react_to_lost_communication();
  const std::uint32_t behaviour = objects_.value(0x1029, 1);
  if (behaviour == 0 && nmt_ == NmtState::operational) enter(NmtState::pre_operational);
  if (behaviour == 2) enter(NmtState::stopped);
}

void SimulatedCia402Drive::receive(const can::Frame& frame) {
  const bool is_guard = frame.is_remote && frame.id == can::heartbeat_id(node());
  if (is_booting_ || !(is_guard || can::is_canopen(frame))) return;
  if (troubles_.has_any() && is_meant_for_it(frame) && takes_frame(Kind::lose_heard)) return;
  if (is_guard) return hear_guard();
  if (!settings_now().heard[frame.id.number()]) return;
  if (frame.id == can::nmt_id) {
    if (const auto order = can::read_nmt(frame)) obey(*order);
    return;
  }
  hear_host(frame);
  if (nmt_ == NmtState::stopped) return;
  if (frame.id == settings_now().sync_id) return hear_sync(frame);
  if (frame.id == can::sdo_request_id(node())) return serve(frame);
  if (nmt_ == NmtState::operational) hear_pdo(frame);
}

/// A drive that tells that it lives by heartbeats is not guarded. Supervised from the first request on.
void SimulatedCia402Drive::hear_guard() {
  if (settings_now().heartbeat_period_ns != 0) return;
  if (!has_trouble(Kind::lose_heartbeat)) send(can::guard_answer_frame(node(), {nmt_, guard_toggle_}));
  guard_toggle_ = !guard_toggle_;
  has_come(guarding);
  const std::int64_t life_ns = std::int64_t{objects_.value(0x100C)} * objects_.value(0x100D) * ms;
  if (life_ns > 0) guard_deadline_ns_ = now_ns_ + life_ns;
}

/// The drive supervises the host from its first heartbeat on, not from its boot-up message.
void SimulatedCia402Drive::hear_host(const can::Frame& frame) {
  const std::uint32_t host = settings_now().host;
  const std::int64_t timeout_ns = settings_now().host_timeout_ns;
  if (host == 0 || timeout_ns == 0 || frame.id.number() != 0x700 + host || frame.length != 1) return;
  if (frame.data[0] != 0) {
    has_come(host_heartbeat);
    host_deadline_ns_ = now_ns_ + timeout_ns;
  } else if (host_deadline_ns_) {
    host_deadline_ns_.reset();
    lose_communication(0x8130);
  }
}

bool SimulatedCia402Drive::is_valid(const Pdo& pdo) const {
  return (objects_.value(pdo.communication, can::pdo_sub_cob_id) & can::cob_id_is_invalid) == 0;
}

SimulatedCia402Drive::Pdo SimulatedCia402Drive::pdo(bool is_sent, std::size_t number) {
  return {.communication = static_cast<std::uint16_t>((is_sent ? 0x1800 : 0x1400) + number),
          .mapping = static_cast<std::uint16_t>((is_sent ? 0x1A00 : 0x1600) + number)};
}

std::vector<can::PdoEntry> SimulatedCia402Drive::objects_in(const Pdo& pdo, std::uint32_t count) const {
  std::vector<can::PdoEntry> objects;
  for (std::size_t sub = 1; sub <= count; ++sub) {
    const std::uint32_t value = objects_.value(pdo.mapping, static_cast<std::uint8_t>(sub));
    objects.push_back(can::read_mapping_value(value));
  }
  return objects;
}

std::optional<std::uint32_t> SimulatedCia402Drive::refuses_pdo(can::ObjectAddress object,
                                                               std::uint32_t value) const {
  const unsigned group = object.index & 0xFFFCU;  // four of each
  const bool is_sent = group == 0x1800 || group == 0x1A00;
  const Pdo asked = pdo(is_sent, object.index & 3U);
  if (group == 0x1600 || group == 0x1A00) return refuses_mapping(asked, is_sent, object.sub, value);
  if (group != 0x1400 && group != 0x1800) return {};
  if (object.sub == can::pdo_sub_cob_id) {
    const bool becomes_valid = (value & can::cob_id_is_invalid) == 0;
    if (!becomes_valid) return {};
    if (is_valid(asked) && value != objects_.value(asked.communication, can::pdo_sub_cob_id))
      return can::abort_bad_value;
    if (can::is_restricted(value & can::cob_id_number)) return can::abort_bad_value;
    if (objects_.value(asked.mapping) == 0) return can::abort_bad_value;
  }
  const bool is_reserved_type = value > 240 && value < 254;
  if (object.sub == can::pdo_sub_type && is_reserved_type) return can::abort_bad_value;
  const bool only_while_invalid = object.sub == can::pdo_sub_inhibit || object.sub == 6;
  if (only_while_invalid && is_valid(asked)) return can::abort_unsupported_access;
  return {};
}

/// The order of CiA 301: the PDO invalid, no objects, then one after the other, then how many.
std::optional<std::uint32_t> SimulatedCia402Drive::refuses_mapping(const Pdo& pdo, bool is_sent,
                                                                   std::uint8_t sub,
                                                                   std::uint32_t value) const {
  if (is_valid(pdo)) return can::abort_unsupported_access;
  if (sub != 0) {
    if (objects_.value(pdo.mapping) != 0) return can::abort_unsupported_access;
    constexpr std::array received{0x60400010U, 0x607A0020U, 0x60C10120U};
    constexpr std::array sent{0x60410010U, 0x60640020U, 0x60610008U, 0x603F0010U, 0x606C0020U, 0x60F40020U};
    const bool can_be_mapped =
        is_sent ? std::ranges::count(sent, value) != 0 : std::ranges::count(received, value) != 0;
    const auto* const object = objects_.find(can::read_mapping_value(value).object);
    if (can_be_mapped && object == nullptr) return can::abort_no_object;
    if (!can_be_mapped || !object->can_be_mapped) return can::abort_not_mappable;
    return {};
  }
  if (value > 8) return can::abort_pdo_too_long;
  if (bits_of(objects_in(pdo, value)) > 64) return can::abort_pdo_too_long;
  return {};
}

void SimulatedCia402Drive::note_written(can::ObjectAddress object) {
  if (object.index == 0x1017) heartbeat_ns_ = now_ns_;
  if (object.index == 0x1016) host_deadline_ns_.reset();
  if (object.index == 0x100C || object.index == 0x100D) guard_deadline_ns_.reset();
  if (object.index == 0x1006 && objects_.value(0x1006) == 0) sync_deadline_ns_.reset();
  if (object == can::ObjectAddress{.index = 0x1400, .sub = can::pdo_sub_event_timer}) {
    setpoint_deadline_ns_.reset();
  }
  if (object.index == 0x6040) obey_controlword(static_cast<std::uint16_t>(objects_.value(0x6040)));
}

SimulatedCia402Drive::PdoSetting SimulatedCia402Drive::setting_of(const Pdo& pdo) const {
  PdoSetting setting{
      .is_valid = is_valid(pdo),
      .id = standard_id(objects_.value(pdo.communication, can::pdo_sub_cob_id)),
      .type = objects_.value(pdo.communication, can::pdo_sub_type),
      .timer_ms = objects_.value(pdo.communication, can::pdo_sub_event_timer),
  };
  const std::vector<can::PdoEntry> mapped = objects_in(pdo, objects_.value(pdo.mapping));
  setting.bits = bits_of(mapped);
  setting.is_valid = setting.is_valid && setting.bits <= 64;
  for (const auto& [object, bits] : mapped) {
    if (bits == 0) continue;
    setting.objects.push_back({.place = objects_.place_of(object.index, object.sub), .bits = bits});
    setting.has_controlword = setting.has_controlword || object.index == 0x6040;
  }
  return setting;
}

const SimulatedCia402Drive::Settings& SimulatedCia402Drive::read_settings() const {
  for (std::size_t n = 0; n < pdos; ++n) {
    read_settings_.received.at(n) = setting_of(pdo(false, n));
    read_settings_.sent.at(n) = setting_of(pdo(true, n));
  }
  read_settings_.heartbeat_period_ns = objects_.value(0x1017) * ms;
  read_settings_.sync_id = standard_id(objects_.value(0x1005));
  read_settings_.sync_period_ns = std::int64_t{objects_.value(0x1006)} * 1000;
  read_settings_.has_sync_counter = objects_.value(0x1019) != 0;
  const std::uint32_t consumer = objects_.value(0x1016, 1);
  read_settings_.host = consumer >> 16;
  read_settings_.host_timeout_ns = (consumer & 0xFFFF) * ms;
  read_settings_.mode = objects_.value(0x6060);
  const auto exponent = static_cast<std::int8_t>(objects_.value(0x60C2, 2));
  read_settings_.interpolation_s = objects_.value(0x60C2, 1) * std::pow(10, exponent);
  read_settings_.min = static_cast<std::int32_t>(objects_.value(0x607D, 1));
  read_settings_.max = static_cast<std::int32_t>(objects_.value(0x607D, 2));
  read_settings_.following_window = objects_.value(0x6065);
  read_settings_.following_ms = objects_.value(0x6066);
  read_settings_.heard.reset();
  for (const can::FrameId id : {can::nmt_id, can::sdo_request_id(node()), read_settings_.sync_id,
                                standard_id(0x700 + read_settings_.host)}) {
    read_settings_.heard.set(id.number());
  }
  for (const PdoSetting& pdo : read_settings_.received) read_settings_.heard.set(pdo.id.number());
  read_settings_.controlword = objects_.place_of(0x6040);
  read_settings_.statusword = objects_.place_of(0x6041);
  read_settings_.mode_display = objects_.place_of(0x6061);
  read_settings_.position = objects_.place_of(0x6064);
  read_settings_.velocity = objects_.place_of(0x606C);
  read_settings_.target = objects_.place_of(0x607A);
  read_settings_.set_point = objects_.place_of(0x60C1, 1);
  read_settings_.following_error = objects_.place_of(0x60F4);
  settings_revision_ = objects_.revision();
  return read_settings_;
}

void SimulatedCia402Drive::hear_pdo(const can::Frame& frame) {
  const std::array<PdoSetting, pdos>& received = settings_now().received;
  for (std::size_t n = 0; n < pdos; ++n) {
    const PdoSetting& heard = received.at(n);
    if (!heard.is_valid || frame.id != heard.id) continue;
    if (8U * frame.length < heard.bits) return raise_error(0x8210, error_of_communication);
    if (8U * frame.length > heard.bits) raise_error(0x8220, error_of_communication);
    has_come(setpoints);
    if (heard.timer_ms > 0) setpoint_deadline_ns_ = now_ns_ + heard.timer_ms * ms;
    const bool waits_for_sync = heard.type <= 240;
    if (waits_for_sync) {
      waiting_.at(n) = frame;
    } else {
      apply_pdo(heard, frame);
    }
    return;
  }
}

void SimulatedCia402Drive::apply_pdo(const PdoSetting& pdo, const can::Frame& frame) {
  const auto all = can::load<std::uint64_t>(frame.data, 0);
  unsigned before = 0;
  for (const auto& [place, bits] : pdo.objects) {
    objects_.set(place, static_cast<std::uint32_t>((all >> before) & low_bits(bits)));
    before += bits;
  }
  if (pdo.has_controlword)
    obey_controlword(static_cast<std::uint16_t>(objects_.value(settings_now().controlword)));
}

void SimulatedCia402Drive::hear_sync(const can::Frame& frame) {
  const bool has_counter = settings_now().has_sync_counter;
  if (frame.length != (has_counter ? 1 : 0)) return raise_error(0x8240, error_of_communication);
  const std::int64_t period_ns = settings_now().sync_period_ns;
  has_come(sync);
  if (period_ns > 0) sync_deadline_ns_ = now_ns_ + period_ns + period_ns / 2;
  if (nmt_ != NmtState::operational) return;
  ++syncs_;
  show();
  // Frames received before this SYNC act now; the drive tells the state at the time of the SYNC.
  for (std::size_t n = 0; n < pdos; ++n) {
    if (!waiting_.at(n)) continue;
    apply_pdo(settings_now().received.at(n), *waiting_.at(n));
    waiting_.at(n).reset();
  }
  from_ = demand_;
  if (sync_ns_) sync_period_s_ = static_cast<double>(now_ns_ - *sync_ns_) * 1e-9;
  sync_ns_ = now_ns_;
  since_sync_s_ = 0;
  take_set_point();
  const bool is_interpolated = mode() == interpolated_position;
  if (is_interpolated ? is_interpolating_ : is_in_operation() && !is_to_home()) {
    const auto target = static_cast<std::int32_t>(
        objects_.value(is_interpolated ? settings_now().set_point : settings_now().target));
    note_target(target);
    record_applied(target);
  }
  send_pdos();
}

void SimulatedCia402Drive::send_pdos() {
  if (has_trouble(Kind::lose_feedback)) return;
  for (const PdoSetting& told : settings_now().sent) {
    if (!told.is_valid || told.type == 0 || told.type > 240 || syncs_ % told.type != 0) continue;
    can::Frame frame{.id = told.id, .length = static_cast<std::uint8_t>(told.bits / 8)};
    std::uint64_t all = 0;
    unsigned before = 0;
    for (const auto& [place, bits] : told.objects) {
      all |= (objects_.value(place) & low_bits(bits)) << before;
      before += bits;
    }
    can::store(frame.data, 0, all);
    if (takes_frame(Kind::shorten)) --frame.length;
    send(frame);
    if (takes_frame(Kind::duplicate)) send(frame);
  }
}

}  // namespace inbetween
