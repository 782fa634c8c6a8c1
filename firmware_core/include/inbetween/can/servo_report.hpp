#pragma once

#include <cstdint>
#include <optional>

/// What passes between a host and a servo drive that knows positions in turns and no SYNC, whatever its
/// protocol.

namespace inbetween::can {

/// Where a drive is.
struct ServoPlace {
  double turns = 0;
  double turns_per_s = 0;
};

/// Where it shall be.
struct ServoTarget {
  double turns = 0;
  double turns_per_s = 0;  ///< feed-forward
};

/// How it is.
struct ServoStatus {
  bool is_on = false;            ///< it holds or follows its position
  bool is_off = false;           ///< it has no power; neither, while it is between the two or calibrates
  bool has_missed_host = false;  ///< its watchdog has expired
  std::uint32_t errors = 0;      ///< as the protocol numbers them; 0: none
};

/// What one frame says. A frame may say several things, or nothing that concerns us.
struct ServoReport {
  std::optional<ServoPlace> place{};
  std::optional<ServoStatus> status{};
  /// It says what it is, and that is or is not what the rig has there.
  std::optional<bool> is_expected_device{};
  bool is_bad = false;        ///< short, or not to be understood
  bool is_of_a_host = false;  ///< only a host sends such a frame
};

/// What a drive is told beside positions.
enum class ServoOrder : std::uint8_t {
  say_what_you_are,
  clear_errors,
  take_positions,  ///< before it is switched on
  switch_on,
  switch_off,
  stop_at_once,  ///< without power and without braking: the last resort
};

}  // namespace inbetween::can
