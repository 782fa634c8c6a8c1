// What the kinds of servo drives have in common: their settings, and words about them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "host_tools/rig_model/rig_file.hpp"
#include "inbetween/can/servo_drive.hpp"

namespace inbetween {

/// The settings of a drive that counts turns, from the limits of its axis.
can::ServoSettings servo_settings_of(const RigAxis& axis, double turns_per_unit, double max_following_error,
                                     std::int32_t rate_hz);
/// Of a drive that counts turns of its output shaft, in steps or with noise of `turns`: what counts as
/// holding a place.
void set_noise(can::ServoSettings& settings, double turns);
/// The bits of an error in words, " (error 14h: ..., ...)"; nothing for 0.
std::string words_of_error_bits(std::uint32_t errors, const char* (*words_of_bit)(std::uint32_t));
/// The note for a drive with no_watchdog = "accepted".
inline constexpr std::string_view words_without_watchdog =
    "nothing stops the motor if this program dies (no_watchdog = \"accepted\"): it goes to its last "
    "position, not "
    "faster than the limit that came with it, and holds it";

}  // namespace inbetween
