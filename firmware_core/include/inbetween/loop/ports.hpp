#pragma once

#include <concepts>
#include <cstdint>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/setpoint.hpp"

/// The ports of a rig that the motion loop needs: hardware and simulation offer the same.

namespace inbetween {

/// The condition of a drive, by what the whole rig has to do.
enum class DriveCondition : std::uint8_t {
  fine,
  cannot_follow,  ///< the others can: all slow down together on the path
  unreachable,    ///< setpoints do not or must not arrive any more
};

/// How one drive is stopped after a following error, while the others go on.
enum class OwnStop : std::uint8_t {
  none,
  stopped,  ///< it is told to stop by its own ramp, and to stay there
  cut,      ///< its power is taken away, whether it rests or not
};

/// The state that a drive has told until now.
struct DriveState {
  double actual = 0;  ///< position in axis units
  bool is_on = false;
  bool is_leaving = false;  ///< it is being switched off, and whoever ends now would leave it half-way
  /// It is where it was told to be, or is told nothing, or does not tell where it is.
  bool is_in_position = true;
  OwnStop own_stop = OwnStop::none;
  DriveCondition condition = DriveCondition::fine;
};

/// The drives of a rig, one for each axis, in its order. Nothing waits. `now_ns` is a monotonic time.
template <class Drives>
concept DrivePort = requires(Drives& drives, std::span<DriveState> states,
                             std::span<const Setpoint> setpoints, std::int64_t now_ns) {
  /// Takes what has arrived, a bounded amount. Once a tick, before anything else.
  drives.read(states, now_ns);
  /// The setpoints that the drives shall have reached one tick from now; or none, and then nothing may be
  /// sent that keeps a drive moving. Once a tick, after everything else.
  drives.write(setpoints, now_ns);
  /// Begins to switch the drives on, after whatever has been; DriveState::is_on tells when they are.
  drives.enable();
  /// Begins to switch them off, which is over when none is leaving (DriveState). Bounded by the drives' own
  /// times; a drive that could not be switched off is not leaving either.
  drives.disable();
  /// Each drive stops by its own ramp.
  drives.quick_stop();
};

/// The lines of a rig that are no drive's. Nothing waits.
template <class Lines>
concept LinePort = requires(Lines& lines, std::int64_t now_ns) {
  /// Takes what the inputs tell, a bounded amount. Once a tick, after the drives were read.
  lines.read(now_ns);
  { lines.emergency_stop() } -> std::convertible_to<bool>;
  /// A limit switch has been reached since the last tick.
  { lines.limit_hit() } -> std::convertible_to<bool>;
  /// Somebody begins to move the rig: what stopped it before is known and over.
  lines.begin();
};

}  // namespace inbetween
