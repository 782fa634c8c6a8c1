#include "inbetween/can/cubemars.hpp"

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>

namespace inbetween::can {
namespace {

using enum CubemarsPacket;

constexpr double deg_per_turn = 360;
constexpr double decidegrees_per_turn = 3'600;
constexpr std::int16_t flows_no_current = 20;  // centiamperes; the offset of a current sensor is less

Frame frame_of(CubemarsMotor motor, CubemarsPacket packet, std::uint8_t length) {
  return {.id = cubemars_id(motor, packet), .length = length};
}
bool is_packet(const Frame& frame, CubemarsMotor motor, CubemarsPacket packet, std::uint8_t length) {
  return !frame.is_remote && frame.id == cubemars_id(motor, packet) && frame.length == length;
}

/// Most significant first.
template <std::signed_integral T>
void put(Frame& frame, std::size_t offset, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    const auto shift = 8 * (sizeof(T) - 1 - i);
    frame.data[offset + i] = static_cast<std::uint8_t>(static_cast<std::uint32_t>(value) >> shift);
  }
}
template <std::signed_integral T>
T get(const Frame& frame, std::size_t offset) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value = value << 8 | frame.data[offset + i];
  return static_cast<T>(value);
}

/// A packet that holds one number.
Frame number_frame(CubemarsMotor motor, CubemarsPacket packet, std::int32_t number) {
  Frame frame = frame_of(motor, packet, 4);
  put(frame, 0, number);
  return frame;
}
std::optional<std::int32_t> number_in(const Frame& frame, CubemarsMotor motor, CubemarsPacket packet) {
  if (!is_packet(frame, motor, packet, 4)) return {};
  return get<std::int32_t>(frame, 0);
}

constexpr std::array words{"no error",
                           "its motor is too hot",
                           "it takes too much current",
                           "its supply voltage is too high",
                           "its supply voltage is too low",
                           "its encoder has failed",
                           "its power stage is too hot, or lacks a phase",
                           "its motor is blocked"};

}  // namespace

Frame cubemars_position_frame(CubemarsMotor motor, const CubemarsPosition& told) {
  Frame frame = frame_of(motor, position, 8);
  put(frame, 0, told.position);
  put(frame, 4, told.max_velocity);
  put(frame, 6, told.max_acceleration);
  return frame;
}

std::optional<CubemarsPosition> read_cubemars_position(const Frame& frame, CubemarsMotor motor) {
  if (!is_packet(frame, motor, position, 8)) return {};
  return CubemarsPosition{.position = get<std::int32_t>(frame, 0),
                          .max_velocity = get<std::int16_t>(frame, 4),
                          .max_acceleration = get<std::int16_t>(frame, 6)};
}

Frame cubemars_current_frame(CubemarsMotor motor, std::int32_t milliamperes) {
  return number_frame(motor, current, milliamperes);
}

std::optional<std::int32_t> read_cubemars_current(const Frame& frame, CubemarsMotor motor) {
  return number_in(frame, motor, current);
}

Frame cubemars_speed_frame(CubemarsMotor motor, std::int32_t erpm) {
  return number_frame(motor, speed, erpm);
}

std::optional<std::int32_t> read_cubemars_speed(const Frame& frame, CubemarsMotor motor) {
  return number_in(frame, motor, speed);
}

Frame cubemars_feedback_frame(CubemarsMotor motor, const CubemarsFeedback& told) {
  Frame frame = frame_of(motor, feedback, 8);
  put(frame, 0, told.decidegrees);
  put(frame, 2, told.dekaerpm);
  put(frame, 4, told.centiamperes);
  put(frame, 6, told.celsius);
  frame.data[7] = told.error;
  return frame;
}

std::optional<CubemarsFeedback> read_cubemars_feedback(const Frame& frame, CubemarsMotor motor) {
  if (!is_packet(frame, motor, feedback, 8)) return {};
  return CubemarsFeedback{.decidegrees = get<std::int16_t>(frame, 0),
                          .dekaerpm = get<std::int16_t>(frame, 2),
                          .centiamperes = get<std::int16_t>(frame, 4),
                          .celsius = get<std::int8_t>(frame, 6),
                          .error = frame.data[7]};
}

const char* words_of_cubemars_error(std::uint32_t error) {
  return error < words.size() ? words[error] : "an error that its maker does not explain";
}

Result<Cubemars> Cubemars::make(const CubemarsSettings& settings) {
  const CubemarsScale& scale = settings.scale;
  const bool is_sensible = settings.hold_velocity > 0 && settings.hold_velocity <= settings.max_velocity &&
                           settings.max_acceleration > 0 && scale.counts_per_deg > 0 &&
                           scale.erpm_per_count > 0 && scale.electric_turns_per_turn > 0;
  if (!is_sensible) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a limit or scale of a CubeMars motor is not positive",
                 .remedy = "give positive limits, that of holding not above the other"};
  }
  return Cubemars(settings);
}

bool Cubemars::is_concerned(const Frame& frame) const {
  const std::uint32_t packet = frame.id.number() >> 8;
  const bool is_known = packet < cubemars_commands || packet == static_cast<std::uint32_t>(feedback);
  return frame.id.is_extended() && is_known && (frame.id.number() & 0xFFU) == settings_.motor.value();
}

ServoReport Cubemars::read(const Frame& frame) {
  if (frame.id.number() >> 8 != static_cast<std::uint32_t>(feedback)) return {.is_of_a_host = true};
  const auto told = read_cubemars_feedback(frame, settings_.motor);
  if (!told) return {.is_bad = true};
  // What is more than half a round the one way is less than half a round the other.
  if (last_decidegrees_) {
    decidegrees_ += static_cast<std::int16_t>(told->decidegrees - *last_decidegrees_);
  } else {
    decidegrees_ = told->decidegrees;
  }
  last_decidegrees_ = told->decidegrees;
  const bool has_no_current =
      told->centiamperes <= flows_no_current && told->centiamperes >= -flows_no_current;
  return {.place = ServoPlace{.turns = static_cast<double>(decidegrees_) / decidegrees_per_turn},
          .status = ServoStatus{
              .is_on = may_have_power_, .is_off = !may_have_power_ && has_no_current, .errors = told->error}};
}

std::optional<Frame> Cubemars::order(ServoOrder order) {
  switch (order) {
    case ServoOrder::switch_off:
    case ServoOrder::stop_at_once:
      may_have_power_ = false;
      return cubemars_current_frame(settings_.motor, 0);
    case ServoOrder::say_what_you_are:
      last_decidegrees_.reset();  // it says where it is from now on
      return {};
    case ServoOrder::clear_errors:
    case ServoOrder::set_watchdog:
    case ServoOrder::take_positions:
    case ServoOrder::switch_on:
      return {};
  }
  return {};
}

bool Cubemars::fits(const ServoTarget& target) {
  constexpr double max_turns = 100;  // 36000 degrees
  return std::fabs(target.turns) <= max_turns;
}

std::optional<Frame> Cubemars::position(double turns, std::int16_t max_velocity) {
  const double counts = std::floor(turns * deg_per_turn * settings_.scale.counts_per_deg + 0.5);
  if (!(std::fabs(counts) <= std::numeric_limits<std::int32_t>::max())) return {};
  may_have_power_ = true;
  return cubemars_position_frame(settings_.motor, {.position = static_cast<std::int32_t>(counts),
                                                   .max_velocity = max_velocity,
                                                   .max_acceleration = settings_.max_acceleration});
}

std::optional<Frame> Cubemars::command(const ServoTarget& target) {
  return position(target.turns, settings_.max_velocity);
}

std::optional<Frame> Cubemars::hold(ServoHold how, double turns) {
  switch (how) {
    case ServoHold::off:
    case ServoHold::watched:
      return {};  // a position would switch it on
    case ServoHold::switching_on:
      return position(turns, settings_.hold_velocity);
    case ServoHold::stopping:
      // Where it stands would be said in a scale that may be the reason for the stop.
      may_have_power_ = true;
      return cubemars_speed_frame(settings_.motor, 0);
  }
  return {};
}

}  // namespace inbetween::can
