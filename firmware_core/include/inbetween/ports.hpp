#pragma once

#include <concepts>
#include <span>

#include "inbetween/precision.hpp"

/// What the motion loop needs of a rig: hardware and simulation offer the same.

namespace inbetween {

/// What a drive has told until now.
template <Precise Real>
struct DriveState {
  Real actual = 0;  ///< position in axis units
  bool is_on = false;
  bool has_fault = false;
};

/// The drives of a rig, one for each axis, in its order. Nothing waits: `read` takes what has arrived,
/// `write` gives the setpoints that the drives shall have reached one tick from now.
template <class Drives, class Real>
concept DrivePort = Precise<Real> &&
    requires(Drives& drives, std::span<DriveState<Real>> states, std::span<const Real> setpoints) {
  /// false: bus off, link down, power gone. Setpoints do not arrive any more.
  { drives.is_connected() } -> std::convertible_to<bool>;
  drives.read(states);
  drives.write(setpoints);
  /// Begins to switch the drives on; DriveState::is_on tells when they are.
  drives.enable();
  drives.disable();
};

/// The lines of a rig that are no drive's.
template <class Lines>
concept LinePort = requires(Lines& lines) {
  { lines.emergency_stop() } -> std::convertible_to<bool>;
};

/// The camera of a rig that is shot frame by frame.
template <class Camera>
concept CameraPort = requires(Camera& camera, bool is_exposing) {
  /// The signal that opens its shutter, given once a tick.
  camera.signal(is_exposing);
  /// Whether it has asked for the next frame since the last call.
  { camera.has_triggered() } -> std::convertible_to<bool>;
};

}  // namespace inbetween
