#include "host_tools/rig/servo_kinds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "inbetween/loop/tick_time.hpp"

namespace inbetween {

void set_noise(can::ServoSettings& settings, double turns) {
  constexpr double hold_s = 0.002;
  settings.hold_tolerance_turns = std::max(4 * turns, hold_s * settings.max_turns_per_s);
}

std::string words_of_error_bits(std::uint32_t errors, const char* (*words_of_bit)(std::uint32_t)) {
  if (errors == 0) return "";
  std::string words;
  for (unsigned bit = 0; bit < 32; ++bit) {
    if ((errors >> bit & 1U) == 0) continue;
    words += fmt::format("{}{}", words.empty() ? "" : ", ", words_of_bit(1U << bit));
  }
  return fmt::format(" (error {:X}h: {})", errors, words);
}

can::ServoSettings servo_settings_of(const RigAxis& axis, std::int32_t rate_hz) {
  const double scale = std::fabs(*turns_per_unit_of(axis.drive));
  const double max_turns_per_s = scale * axis.max_velocity;
  const double tick_s = 1.0 / rate_hz;
  can::ServoSettings settings;
  // The rates above the drawn one are certified within this share.
  constexpr double rate_share = 1.2;
  settings.max_turns_per_s = rate_share * max_turns_per_s;
  settings.max_step_turns = settings.max_turns_per_s * tick_s;
  // Float32 turns and the noise of an encoder; what the axis covers at max_velocity in two milliseconds is a
  // place that it holds.
  constexpr double noise_turns = 0.005;
  constexpr double hold_s = 0.002;
  settings.hold_tolerance_turns = std::max(noise_turns, hold_s * max_turns_per_s);
  settings.first_step_turns = std::max(1e-4, 0.5 * scale * axis.max_acceleration * tick_s * tick_s);
  settings.max_following_error_turns = scale * follow_limits_of(axis.drive)->max_following_error;
  settings.rest_turns = scale * rest_distance_of(axis);  // the estimates of velocity are not used
  settings.disable_timeout_ns += static_cast<std::int64_t>(2 * axis.max_velocity / axis.max_acceleration *
                                                           static_cast<double>(ns_per_s));
  settings.place_timeout_ns = std::max(settings.place_timeout_ns, 3 * ns_per_s / rate_hz);
  return settings;
}

}  // namespace inbetween
