// What the person at the rig's terminal is told of a host program.
#pragma once

#include <cstdint>
#include <string>

namespace inbetween::dragonframe {

struct PortNotice {
  enum class Kind : std::uint8_t {
    connected,
    disconnected,
    host_stopped,      ///< a stop from the host took the consent away
    rig_stopped,       ///< one from the rig did
    consent_missing,   ///< the host asked for a motion and nobody has agreed
    rig_refused,       ///< `value` is the RigAnswer
    jog_not_repeated,  ///< the motor is stopped
    stop_in_play,      ///< one motor was to stop in a move: all do
    half_dropped,      ///< a message that began and did not end
    frame_narrowed,    ///< a frame outside of the move: `value` is the one it goes to
    speed_raised,      ///< a velocity of 0 to 9 steps/s counts as 10
    override_ignored,  ///< of a motor that is not there
    unknown_flags,     ///< `value` has the flags of a motor that mean nothing here
    unknown_line,      ///< a line that is no command
  };
  Kind kind{};
  std::uint8_t motor = 0;  ///< 0: no one of them
  std::int64_t value = 0;

  bool operator==(const PortNotice&) const = default;
};

/// One line, without a full stop.
[[nodiscard]] std::string text_of(const PortNotice& notice);

}  // namespace inbetween::dragonframe
