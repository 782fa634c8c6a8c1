#pragma once

#include <cstdint>

namespace inbetween::can {

/// How a servo drive is watched (ServoDrive). Times in nanoseconds, positions in turns.
struct ServoSettings {
  /// The furthest that a target may be from the last one, and the fastest that one may be meant to go. A
  /// target beyond is not sent.
  double max_step_turns = 0;
  double max_turns_per_s = 0;
  /// The furthest that the axis may be from its held target from when it is switched on until its first
  /// target, and that the first target may be from the held one.
  double hold_tolerance_turns = 0;
  double first_step_turns = 0;
  /// The furthest that the axis may be from its target: the drive does not watch that itself.
  double max_following_error_turns = 0;
  /// The axis rests where it has not been further than this from one place for rest_ns.
  double rest_turns = 0;
  std::int64_t rest_ns = 50'000'000;
  std::int64_t place_timeout_ns = 50'000'000;    ///< of what it tells of its position
  std::int64_t status_timeout_ns = 350'000'000;  ///< of what it tells of itself
  std::int64_t boot_timeout_ns = 5'000'000'000;
  std::int64_t identity_timeout_ns = 300'000'000;  ///< for its answer what it is
  /// Until it must have told that its watchdog has expired.
  std::int64_t watchdog_timeout_ns = 1'000'000'000;
  std::int64_t enable_timeout_ns = 5'000'000'000;
  std::int64_t stop_timeout_ns = 1'000'000'000;
  std::int64_t disable_timeout_ns = 2'000'000'000;
  std::int64_t repeat_ns = 100'000'000;  ///< an order that is not obeyed is given again
  /// Bad frames that are still no finding; one is forgiven in every `bad_frame_ticks`.
  std::int32_t bad_frame_limit = 8;
  std::int32_t bad_frame_ticks = 250;

  /// Every limit and time is positive, and there is time to see that it rests.
  [[nodiscard]] constexpr bool is_sensible() const {
    return max_step_turns > 0 && max_turns_per_s > 0 && hold_tolerance_turns > 0 && first_step_turns > 0 &&
           max_following_error_turns > 0 && rest_turns > 0 && rest_ns > 0 && place_timeout_ns > 0 &&
           status_timeout_ns > 0 && boot_timeout_ns > 0 && identity_timeout_ns > 0 &&
           watchdog_timeout_ns > 0 && enable_timeout_ns > 0 && stop_timeout_ns > 0 &&
           disable_timeout_ns > rest_ns && repeat_ns > 0 && bad_frame_limit >= 0 && bad_frame_ticks > 0;
  }
};

}  // namespace inbetween::can
