#include "host_tools/dragonframe/dmc_device.hpp"

#include <stdexcept>
#include <utility>

namespace inbetween::dragonframe {
namespace {

DmcCode code_of(RigAnswer answer) {
  switch (answer) {
    case RigAnswer::ok:
      return DmcCode::ok;
    case RigAnswer::moving:
      return DmcCode::moving;
    case RigAnswer::unsupported:
      return DmcCode::unsupported;
    case RigAnswer::range:
      return DmcCode::range;
    case RigAnswer::general:
      return DmcCode::general;
    case RigAnswer::not_in_position:
      return DmcCode::not_in_position;
    case RigAnswer::preroll:
      return DmcCode::preroll;
    case RigAnswer::postroll:
      return DmcCode::postroll;
    case RigAnswer::soft_upper:
      return DmcCode::soft_upper;
    case RigAnswer::soft_lower:
      return DmcCode::soft_lower;
    case RigAnswer::hard_upper:
      return DmcCode::hard_upper;
    case RigAnswer::hard_lower:
      return DmcCode::hard_lower;
  }
  return DmcCode::general;
}

const DmcFacts& checked(const DmcFacts& facts) {
  if (facts.name.size() > 31) throw std::invalid_argument("a DMC device has a name of 31 bytes at most");
  if (facts.motors < 1 || facts.motors > max_motors)
    throw std::invalid_argument("a DMC device has 1 to 32 motors");
  if (facts.outputs > 32 || facts.inputs > 32)
    throw std::invalid_argument("a DMC device has 32 lines at most");
  if (facts.frame_capacity < 1) throw std::invalid_argument("a DMC device has room for a frame");
  constexpr std::uint32_t known = dmc_can::real_time | dmc_can::shoot_frame | dmc_can::shoot_frame2 |
                                  dmc_can::couple | dmc_can::loop | dmc_can::camera;
  if ((facts.capabilities & ~known) != 0) throw std::invalid_argument("this DMC device has no virtual axes");
  return facts;
}

std::uint32_t first_bits(std::uint8_t count) {
  return count >= 32 ? 0xFFFF'FFFFU : (std::uint32_t{1} << count) - 1;
}

}  // namespace

DmcDevice::DmcDevice(const DmcFacts& facts, RigPort rig)
    : facts_(checked(facts)), rig_(std::move(rig)), move_(facts.motors, facts.frame_capacity) {}

bool DmcDevice::connect(std::int64_t now_ns) {
  if (is_connected_) return false;
  now_ns_ = now_ns;
  is_connected_ = true;
  note(PortNotice::Kind::connected);
  greet(0);
  return true;
}

void DmcDevice::disconnect(std::int64_t now_ns) {
  if (!is_connected_) return;
  now_ns_ = now_ns;
  static_cast<void>(order(StopAll{}));
  host_outputs_ = 0;
  end_bloop();
  static_cast<void>(set_camera({}));
  static_cast<void>(rig_(ForgetHost{}));
  forget();
  is_connected_ = false;
  note(PortNotice::Kind::disconnected);
}

/// As after switching on. What the decoder and the person were told stays.
void DmcDevice::forget() {
  decoder_.clear();
  jogs_.clear();
  move_.clear();
  settings_ = {};
  stage_ = DmcStage::jog;
  is_armed_ = false;
  stopped_ns_.reset();
  gated_ns_.reset();
  position_frame_.reset();
  stops_on_path_ = false;
  run_.reset();
  is_synced_ = false;
  has_ended_ = false;
  bytes_.clear();
}

bool DmcDevice::arm() {
  if (!is_connected_ || gated_ns_) return false;
  is_armed_ = true;
  return true;
}

void DmcDevice::disarm(PortNotice::Kind why) {
  if (is_armed_) note(why);
  is_armed_ = false;
}

void DmcDevice::stop(std::int64_t now_ns) {
  now_ns_ = now_ns;
  if (!is_connected_) return;
  if (moves() || state_.moving != 0) gated_ns_ = now_ns;
  static_cast<void>(order(StopAll{}));
  stop_all();
  disarm(PortNotice::Kind::rig_stopped);
  send(DmcType::hard_stop, 0, write_dmc_hard_stop(static_cast<std::uint8_t>(HardStopReason::general), 0));
}

void DmcDevice::hear(std::span<const std::uint8_t> bytes, std::int64_t now_ns) {
  now_ns_ = now_ns;
  if (!is_connected_ || bytes.empty()) return;
  heard_ns_ = now_ns;
  hear_whole(bytes);
}

void DmcDevice::hear_whole(std::span<const std::uint8_t> bytes) {
  while (const auto frame = decoder_.next(bytes)) hear_frame(*frame);
}

/// STOP and STOP_ALL pass the gate too, which they do not with the maker: a stop is never refused.
bool DmcDevice::is_gated(std::uint16_t type) const {
  constexpr auto first = static_cast<std::uint16_t>(DmcType::move);
  return gated_ns_ && type >= first && type != static_cast<std::uint16_t>(DmcType::position) &&
         type != static_cast<std::uint16_t>(DmcType::stop) &&
         type != static_cast<std::uint16_t>(DmcType::stop_all);
}

void DmcDevice::hear_frame(const DmcFrame& frame) {
  // The host acknowledges nothing that wants an answer.
  if ((frame.type & dmc_ack_bit) != 0) return;
  if (!frame.is_intact) return acknowledge(frame.type, frame.id, DmcCode::checksum);
  if (is_gated(frame.type)) return acknowledge(frame.type, frame.id, DmcCode::hard_lower);
  const DmcTypeRow* const row = dmc_type_row(frame.type);
  const bool is_offered =
      row != nullptr && row->is_request && (row->needs == 0 || (row->needs & facts_.capabilities) != 0);
  if (!is_offered) return acknowledge(frame.type, frame.id, DmcCode::unsupported);
  const auto request = read_dmc_request(*row, frame.payload);
  if (!request) return acknowledge(frame.type, frame.id, DmcCode::general);
  if (const auto* const plain = std::get_if<DmcPlain>(&*request)) {
    if (answer_question(plain->type, frame.id)) return;
  }
  const RigAnswer answer = std::visit([&](const auto& message) { return handle(message); }, *request);
  acknowledge(frame.type, frame.id, code_of(answer));
  // The sheet has the new position behind the acknowledgement.
  if (answer == RigAnswer::ok && row->type == DmcType::reset_position) push_positions();
}

bool DmcDevice::answer_question(DmcType type, std::uint32_t id) {
  switch (type) {
    case DmcType::hi:
      greet(id);
      return true;
    case DmcType::status:
      send(type, id, write_dmc_status(state_.moving));
      return true;
    case DmcType::position:
      push_positions(id);
      return true;
    case DmcType::gio_in:
      if (facts_.inputs == 0) return false;
      send(type, id, write_dmc_inputs(state_.inputs & first_bits(facts_.inputs)));
      return true;
    default:
      return false;
  }
}

void DmcDevice::send(DmcType type, std::uint32_t id, std::span<const std::uint8_t> payload) {
  append_dmc_frame({.id = id, .type = static_cast<std::uint16_t>(type), .payload = payload}, bytes_);
}

void DmcDevice::acknowledge(std::uint16_t type, std::uint32_t id, DmcCode code) {
  const auto payload = write_dmc_code(code);
  append_dmc_frame({.id = id, .type = static_cast<std::uint16_t>(type | dmc_ack_bit), .payload = payload},
                   bytes_);
}

void DmcDevice::greet(std::uint32_t id) {
  send(DmcType::hi, id,
       write_dmc_hi({.name = facts_.name,
                     .major = facts_.version[0],
                     .minor = facts_.version[1],
                     .revision = facts_.version[2],
                     .motors = facts_.motors,
                     .outputs = facts_.outputs,
                     .inputs = facts_.inputs,
                     .hardware_limit_sets = facts_.hardware_limit_sets,
                     .frame_capacity = facts_.frame_capacity,
                     .capabilities = facts_.capabilities}));
}

void DmcDevice::push_positions(std::uint32_t id) {
  pushed_ns_ = now_ns_;
  send(DmcType::position, id,
       write_dmc_positions(state_.move_time, std::span(state_.positions).first(facts_.motors)));
}

void DmcDevice::note(PortNotice::Kind kind, std::uint8_t motor, std::int64_t value) {
  notices_.push_back({.kind = kind, .motor = motor, .value = value});
}

MotorMask DmcDevice::live_motors() const {
  MotorMask live = 0;
  for (std::uint8_t motor = 1; motor <= facts_.motors; ++motor) {
    if (settings_.at(motor - 1U).is_live) live |= mask_of(motor);
  }
  return live;
}

/// Whether anything but motors that are moved by hand moves, or is about to.
bool DmcDevice::moves() const {
  return (state_.moving & ~live_motors()) != 0 || (stage_ != DmcStage::jog && stage_ != DmcStage::wait);
}

RigAnswer DmcDevice::order(const RigOrder& what, std::uint8_t motor) {
  const RigAnswer answer = rig_(what);
  if (answer != RigAnswer::ok) note(PortNotice::Kind::rig_refused, motor, static_cast<std::int64_t>(answer));
  return answer;
}

RigAnswer DmcDevice::move_by(const RigOrder& what, std::uint8_t motor) {
  if (is_armed_) return order(what, motor);
  note(PortNotice::Kind::consent_missing, motor);
  return RigAnswer::general;
}

void DmcDevice::begin_bloop(std::int64_t for_ns) {
  if (bloop_bits_ == 0) return;
  bloop_until_ns_ = now_ns_ + for_ns;
  static_cast<void>(show_outputs());
}

void DmcDevice::end_bloop() {
  bloop_until_ns_.reset();
  static_cast<void>(show_outputs());
}

RigAnswer DmcDevice::show_outputs() {
  const std::uint32_t bits = host_outputs_ | (bloop_until_ns_ ? bloop_bits_ : 0);
  if (bits == shown_outputs_) return RigAnswer::ok;
  const RigAnswer answer = order(SetOutputs{bits});
  if (answer == RigAnswer::ok) shown_outputs_ = bits;
  return answer;
}

std::uint32_t DmcDevice::output_bits() const {
  return first_bits(facts_.outputs);
}

RigAnswer DmcDevice::set_camera(const SetCamera& camera) {
  if (camera == camera_) return RigAnswer::ok;
  const RigAnswer answer = order(camera);
  if (answer == RigAnswer::ok) camera_ = camera;
  return answer;
}

void DmcDevice::tell(const RigEvent& event, std::int64_t now_ns) {
  now_ns_ = now_ns;
  if (!is_connected_) return;
  std::visit([&](const auto& what) { handle_event(what); }, event);
}

void DmcDevice::observe(const RigState& state, std::int64_t now_ns) {
  now_ns_ = now_ns;
  const bool came_to_rest = state_.moving != 0 && state.moving == 0;
  const std::uint32_t new_inputs = (state.inputs ^ state_.inputs) & first_bits(facts_.inputs);
  state_ = state;
  if (!is_connected_) return;
  if (decoder_.has_half() && now_ns - heard_ns_ >= dmc_silence_ns) {
    note(PortNotice::Kind::half_dropped);
    while (decoder_.has_half()) {
      decoder_.give_up();
      hear_whole({});
    }
  }
  while (const auto motor = jogs_.take_expired(now_ns)) {
    note(PortNotice::Kind::jog_not_repeated, *motor);
    static_cast<void>(order(StopMotor{*motor}, *motor));
  }
  jogs_.rest(state.moving);
  if (gated_ns_ && !moves() && state.moving == 0 && now_ns - *gated_ns_ >= dmc_gate_ns) gated_ns_.reset();
  if (bloop_until_ns_ && now_ns >= *bloop_until_ns_) end_bloop();
  if (new_inputs != 0) send(DmcType::gio_in, 0, write_dmc_inputs(state.inputs & first_bits(facts_.inputs)));
  if (came_to_rest || (state.moving != 0 && now_ns - pushed_ns_ >= dmc_push_ns)) push_positions();
}

std::vector<std::uint8_t> DmcDevice::take_bytes() {
  return std::exchange(bytes_, {});
}

std::vector<PortNotice> DmcDevice::take_notices() {
  return std::exchange(notices_, {});
}

}  // namespace inbetween::dragonframe
