#include "inbetween/can/odrive.hpp"

#include <bit>
#include <cmath>
#include <limits>

#include "inbetween/can/little_endian.hpp"
#include "words.hpp"

namespace inbetween::can {
namespace {

using enum OdriveMessage;

constexpr double raw_per_unit = 1000;  // of both feed-forwards

Frame frame_of(OdriveNode node, OdriveMessage message, std::uint8_t length) {
  return {.id = odrive_id(node, message), .length = length};
}
bool is_message(const Frame& frame, OdriveNode node, OdriveMessage message) {
  return !frame.is_remote && frame.id == odrive_id(node, message) && frame.length == 8;
}

void store_float(Frame& frame, std::size_t offset, float value) {
  store(frame.data, offset, std::bit_cast<std::uint32_t>(value));
}
float load_float(const Frame& frame, std::size_t offset) {
  return std::bit_cast<float>(load<std::uint32_t>(frame.data, offset));
}

std::optional<std::int16_t> raw_of(double feed_forward) {
  const double raw = std::floor(feed_forward * raw_per_unit + 0.5);
  if (!(std::fabs(raw) <= std::numeric_limits<std::int16_t>::max())) return {};
  return static_cast<std::int16_t>(raw);
}
double feed_forward_at(const Frame& frame, std::size_t offset) {
  return static_cast<std::int16_t>(load<std::uint16_t>(frame.data, offset)) / raw_per_unit;
}

constexpr std::array words_05{Words{0x1, "it was asked for a state in which it cannot be"},
                              Words{0x40, "its motor has failed"},
                              Words{0x80, "its estimate without an encoder has failed"},
                              Words{0x100, "its encoder has failed"},
                              Words{0x200, "its controller has failed"},
                              Words{0x800, "its watchdog has expired"},
                              Words{0x1000, "it has reached its end switch at the lower end"},
                              Words{0x2000, "it has reached its end switch at the upper end"},
                              Words{0x4000, "somebody has sent it an emergency stop"},
                              Words{0x2'0000, "it was to look for an end switch that it does not have"},
                              Words{0x4'0000, "it is too hot"},
                              Words{0x8'0000, "it does not know its position"}};
constexpr std::array words_06{Words{0x1, "it is still starting"},
                              Words{0x2, "its own program has failed"},
                              Words{0x4, "its timing has failed"},
                              Words{0x8, "it has no estimate of its position"},
                              Words{0x10, "its settings are not valid"},
                              Words{0x20, "its gate driver has failed"},
                              Words{0x40, "an input is missing"},
                              Words{0x100, "its supply voltage is too high"},
                              Words{0x200, "its supply voltage is too low"},
                              Words{0x400, "its supply takes too much current"},
                              Words{0x800, "it has fed back too much current"},
                              Words{0x1000, "its motor current has left its limits"},
                              Words{0x2000, "its motor is too hot"},
                              Words{0x4000, "its power stage is too hot"},
                              Words{0x8000, "it was faster than its velocity limit"},
                              Words{0x1'0000, "it has left its position limits"},
                              Words{0x100'0000, "its watchdog has expired"},
                              Words{0x200'0000, "somebody has sent it an emergency stop"},
                              Words{0x400'0000, "its motor turns against its encoder (spinout)"},
                              Words{0x800'0000, "its brake resistor is not armed"},
                              Words{0x1000'0000, "its thermistor is not connected"},
                              Words{0x4000'0000, "it could not be calibrated"}};

/// Of the parts of 0.5, as its sources name them.
constexpr std::array words_of_motor{Words{0x1, "the resistance of its phases is out of range"},
                                    Words{0x2, "the inductance of its phases is out of range"},
                                    Words{0x8, "its gate driver has failed"},
                                    Words{0x10, "its control was too late"},
                                    Words{0x80, "its modulation was too high"},
                                    Words{0x400, "its current sensors are saturated"},
                                    Words{0x1000, "its current has left its limits"},
                                    Words{0x2'0000, "its motor is too hot"},
                                    Words{0x4'0000, "its power stage is too hot"}};
constexpr std::array words_of_encoder{Words{0x1, "the bandwidth is too high for the gain"},
                                      Words{0x2, "its counts a turn do not go with the pole pairs"},
                                      Words{0x4, "it does not answer"},
                                      Words{0x8, "its mode is not known"},
                                      Words{0x10, "its Hall signals are not possible"},
                                      Words{0x20, "its index has not been found"},
                                      Words{0x40, "its SPI does not answer in time"},
                                      Words{0x80, "its SPI tells nonsense"},
                                      Words{0x100, "its SPI is not ready"},
                                      Words{0x200, "its Hall signals are not calibrated"}};
constexpr std::array words_of_controller{
    Words{0x1, "it was too fast"}, Words{0x2, "its input mode is not known"},
    Words{0x4, "the bandwidth is too high for the gain"}, Words{0x20, "its estimate is not valid"}};

constexpr const char* unknown = "an error that this program does not know";

/// 0.5 does not say its version, which is waited for.
constexpr std::size_t questions_of_version = 3;

}  // namespace

std::optional<Frame> odrive_position_frame(OdriveNode node, const OdrivePosition& position) {
  const auto velocity = raw_of(position.turns_per_s);
  const auto torque = raw_of(position.torque_nm);
  if (!std::isfinite(position.turns) || !velocity || !torque) return {};
  Frame frame = frame_of(node, input_position, 8);
  store_float(frame, 0, position.turns);
  store(frame.data, 4, static_cast<std::uint16_t>(*velocity));
  store(frame.data, 6, static_cast<std::uint16_t>(*torque));
  return frame;
}

std::optional<OdrivePosition> read_odrive_position(const Frame& frame, OdriveNode node) {
  if (!is_message(frame, node, input_position)) return {};
  return OdrivePosition{.turns = load_float(frame, 0),
                        .turns_per_s = feed_forward_at(frame, 4),
                        .torque_nm = feed_forward_at(frame, 6)};
}

Frame odrive_state_frame(OdriveNode node, std::uint8_t state) {
  Frame frame = frame_of(node, axis_state, 4);
  store(frame.data, 0, std::uint32_t{state});
  return frame;
}

Frame odrive_position_mode_frame(OdriveNode node) {
  constexpr std::uint32_t position_control = 3;
  constexpr std::uint32_t passthrough = 1;
  Frame frame = frame_of(node, controller_mode, 8);
  store(frame.data, 0, position_control);
  store(frame.data, 4, passthrough);
  return frame;
}

Frame odrive_clear_frame(OdriveNode node, OdriveFamily family) {
  // 0.6 reads a byte: whether the drive shall show which one it is.
  return frame_of(node, clear_errors, family == OdriveFamily::firmware_06 ? 1 : 0);
}

Frame odrive_emergency_stop_frame(OdriveNode node) {
  return frame_of(node, emergency_stop, 0);
}

Frame odrive_question(OdriveNode node, OdriveMessage message) {
  Frame frame = frame_of(node, message, 0);
  frame.is_remote = true;
  return frame;
}

std::optional<OdriveHeartbeat> read_odrive_heartbeat(const Frame& frame, OdriveNode node,
                                                     OdriveFamily family) {
  if (!is_message(frame, node, heartbeat)) return {};
  OdriveHeartbeat read{.errors = load<std::uint32_t>(frame.data, 0), .state = frame.data[4]};
  if (family == OdriveFamily::firmware_06) {
    read.result = frame.data[5];
    read.is_trajectory_done = (frame.data[6] & 1U) != 0;
    return read;
  }
  for (std::uint8_t i = 0; i < 3; ++i) {
    if ((frame.data[5U + i] & 1U) != 0) read.sub_errors |= static_cast<std::uint8_t>(1U << i);
  }
  read.is_trajectory_done = (frame.data[7] & 0x80U) != 0;
  return read;
}

Frame odrive_heartbeat_frame(OdriveNode node, OdriveFamily family, const OdriveHeartbeat& told) {
  Frame frame = frame_of(node, heartbeat, 8);
  store(frame.data, 0, told.errors);
  frame.data[4] = told.state;
  if (family == OdriveFamily::firmware_06) {
    frame.data[5] = told.result;
    frame.data[6] = told.is_trajectory_done ? 1 : 0;
    return frame;
  }
  for (std::uint8_t i = 0; i < 3; ++i)
    frame.data[5U + i] = static_cast<std::uint8_t>(told.sub_errors >> i & 1U);
  if (told.is_trajectory_done) frame.data[7] |= 0x80U;
  return frame;
}

std::optional<ServoPlace> read_odrive_estimates(const Frame& frame, OdriveNode node) {
  if (!is_message(frame, node, estimates)) return {};
  const float turns = load_float(frame, 0);
  const float turns_per_s = load_float(frame, 4);
  if (!std::isfinite(turns) || !std::isfinite(turns_per_s)) return {};
  return ServoPlace{.turns = static_cast<double>(turns), .turns_per_s = static_cast<double>(turns_per_s)};
}

Frame odrive_estimates_frame(OdriveNode node, float turns, float turns_per_s) {
  Frame frame = frame_of(node, estimates, 8);
  store_float(frame, 0, turns);
  store_float(frame, 4, turns_per_s);
  return frame;
}

std::optional<OdriveVersion> read_odrive_version(const Frame& frame, OdriveNode node) {
  if (!is_message(frame, node, version)) return {};
  const auto& d = frame.data;
  return OdriveVersion{.protocol = d[0],
                       .hardware = {d[1], d[2], d[3]},
                       .firmware = {d[4], d[5], d[6]},
                       .is_unreleased = d[7] != 0};
}

Frame odrive_version_frame(OdriveNode node, const OdriveVersion& told) {
  Frame frame = frame_of(node, version, 8);
  frame.data = {told.protocol,    told.hardware[0], told.hardware[1], told.hardware[2],
                told.firmware[0], told.firmware[1], told.firmware[2], std::uint8_t{told.is_unreleased}};
  return frame;
}

std::optional<OdriveError> read_odrive_error(const Frame& frame, OdriveNode node) {
  if (!is_message(frame, node, error)) return {};
  return OdriveError{.active = load<std::uint32_t>(frame.data, 0),
                     .disarm_reason = load<std::uint32_t>(frame.data, 4)};
}

Frame odrive_error_frame(OdriveNode node, const OdriveError& told) {
  Frame frame = frame_of(node, error, 8);
  store(frame.data, 0, told.active);
  store(frame.data, 4, told.disarm_reason);
  return frame;
}

std::optional<std::uint32_t> read_odrive_part(const Frame& frame, OdriveNode node, OdrivePart part) {
  const bool is_it =
      !frame.is_remote && frame.id == odrive_id(node, static_cast<OdriveMessage>(part)) && frame.length >= 4;
  if (!is_it) return {};
  return load<std::uint32_t>(frame.data, 0);
}

Frame odrive_part_frame(OdriveNode node, OdrivePart part, std::uint32_t errors) {
  Frame frame = frame_of(node, static_cast<OdriveMessage>(part), part == OdrivePart::motor ? 8 : 4);
  store(frame.data, 0, errors);
  return frame;
}

const char* words_of_odrive_part(OdrivePart part, std::uint32_t bit) {
  switch (part) {
    case OdrivePart::motor:
      return words_in(words_of_motor, bit, unknown);
    case OdrivePart::encoder:
      return words_in(words_of_encoder, bit, unknown);
    case OdrivePart::controller:
      break;
  }
  return words_in(words_of_controller, bit, unknown);
}

std::optional<std::uint64_t> read_odrive_serial(const Frame& frame, OdriveNode node) {
  constexpr std::uint8_t min_length = 7;
  const bool is_it = !frame.is_remote && frame.id == odrive_id(node, address) && frame.length >= min_length &&
                     frame.data[0] == node.value();
  if (!is_it) return {};
  std::uint64_t serial = 0;
  for (std::size_t i = 0; i < 6; ++i) serial |= std::uint64_t{frame.data[1 + i]} << (8 * i);
  return serial;
}

Frame odrive_address_frame(OdriveNode node, std::uint64_t serial) {
  Frame frame = frame_of(node, address, 8);
  frame.data[0] = node.value();
  for (std::size_t i = 0; i < 6; ++i) frame.data[1 + i] = static_cast<std::uint8_t>(serial >> (8 * i));
  return frame;
}

const char* words_of_odrive_error(OdriveFamily family, std::uint32_t bit) {
  return family == OdriveFamily::firmware_05 ? words_in(words_05, bit, unknown)
                                             : words_in(words_06, bit, unknown);
}

ServoReport Odrive::read(const Frame& frame) {
  if (frame.is_remote) return {};
  if (family_ == OdriveFamily::firmware_05) {
    for (std::size_t i = 0; i < odrive_parts.size(); ++i) {
      if (const auto told = read_odrive_part(frame, node_, odrive_parts[i])) part_errors_[i] = *told;
    }
  }
  switch (static_cast<OdriveMessage>(frame.id.number() & odrive_message_bits)) {
    case heartbeat: {
      const auto told = read_odrive_heartbeat(frame, node_, family_);
      if (!told) return {.is_bad = true};
      // 0.6 has accepted an order before it has carried it out: the last result then is "busy".
      const bool is_changing = told->result == 1;
      return {.status = ServoStatus{.is_on = told->state == odrive_closed_loop && !is_changing,
                                    .is_off = told->state == odrive_idle && !is_changing,
                                    .has_missed_host = (told->errors & odrive_watchdog_error(family_)) != 0,
                                    .errors = told->errors}};
    }
    case estimates: {
      const auto place = read_odrive_estimates(frame, node_);
      return {.place = place, .is_bad = !place};
    }
    case version: {
      const auto told = read_odrive_version(frame, node_);
      if (!told) return {.is_bad = true};
      const bool is_06 = told->firmware[0] == 0 && told->firmware[1] == 6;
      is_06_ = is_06 && family_ == OdriveFamily::firmware_06;
      return {.is_expected_device = is_06_};
    }
    case error:
      if (const auto told = read_odrive_error(frame, node_); told && is_06_)
        disarm_reason_ = told->disarm_reason;
      return {};
    case address: {
      const auto told = read_odrive_serial(frame, node_);
      if (!told || !is_06_) return {};
      const bool is_another = serial_ && *serial_ != *told;
      serial_ = told;
      return {.is_another_device = is_another};
    }
    case parameter_order:
      return {.is_of_a_host = family_ == OdriveFamily::firmware_06};
    case emergency_stop:
    case axis_state:
    case controller_mode:
    case input_position:
    case input_velocity:
    case input_torque:
      return {.is_of_a_host = true};
    default:
      return {};
  }
}

/// What is asked of 0.6 means something else to 0.5, and the other way round: each family is known first. Two
/// questions for its number, so that a second device has answered as well.
std::optional<Frame> Odrive::next_question() {
  constexpr std::array of_06{address, error, address};
  const std::size_t step = asked_;
  if (asked_ < 0xFF) ++asked_;
  if (family_ == OdriveFamily::firmware_06) {
    if (!is_06_) {
      asked_ = 0;
      return odrive_question(node_, version);
    }
    return step < of_06.size() ? std::optional(odrive_question(node_, of_06[step])) : std::nullopt;
  }
  if (step < questions_of_version) return odrive_question(node_, version);
  const std::size_t part = step - questions_of_version;
  if (part >= odrive_parts.size()) return {};
  return odrive_question(node_, static_cast<OdriveMessage>(odrive_parts[part]));
}

bool Odrive::has_more_to_ask(std::uint32_t errors) const {
  constexpr std::size_t of_06 = 3;
  if (family_ == OdriveFamily::firmware_06) return is_06_ && asked_ < of_06;
  return errors != 0 && asked_ < questions_of_version + odrive_parts.size();
}

std::optional<Frame> Odrive::order(ServoOrder order) {
  switch (order) {
    case ServoOrder::say_what_you_are:
      return next_question();
    case ServoOrder::set_watchdog:
      return {};  // it is a setting of the drive
    case ServoOrder::clear_errors:
      return odrive_clear_frame(node_, family_);
    case ServoOrder::take_positions:
      return odrive_position_mode_frame(node_);
    case ServoOrder::switch_on:
      return odrive_state_frame(node_, odrive_closed_loop);
    case ServoOrder::switch_off:
      return odrive_state_frame(node_, odrive_idle);
    case ServoOrder::stop_at_once:
      return odrive_emergency_stop_frame(node_);
  }
  return {};
}

std::optional<Frame> Odrive::command(const ServoTarget& target) const {
  return odrive_position_frame(
      node_, {.turns = static_cast<float>(target.turns), .turns_per_s = target.turns_per_s});
}

}  // namespace inbetween::can
