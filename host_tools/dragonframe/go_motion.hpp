// Where a motor is before, in and behind a run and an exposure in motion: numbers alone, in steps and
// seconds. Methods: those of the maker's reference device, with the frame as index everywhere. For a run
// played backwards this has a definition of its own: time runs from the first frame to one frame behind the
// last, in the direction of playing.
#pragma once

#include <cstdint>
#include <vector>

#include "host_tools/dragonframe/rig_port.hpp"
#include "host_tools/dragonframe/uploaded_move.hpp"

namespace inbetween::dragonframe {

struct RunTimes {
  double fps = 0;
  std::int32_t start = 0;
  std::int32_t end = 0;
  double preroll_s = 0;
  double postroll_s = 0;

  [[nodiscard]] int direction() const { return end >= start ? 1 : -1; }
  /// Where time ends, in frames.
  [[nodiscard]] std::int64_t behind() const { return std::int64_t{end} + direction(); }
};

/// From rest here, with constant acceleration for the pre-roll, a motor is at the start frame at its speed.
[[nodiscard]] double preroll_position(const UploadedMove& move, std::uint8_t motor, const RunTimes& run);
/// It comes to rest here, with constant deceleration for the post-roll.
[[nodiscard]] double postroll_position(const UploadedMove& move, std::uint8_t motor, const RunTimes& run);

/// From `from` to `to` while a picture is exposed, steps.
struct BlurWay {
  double from = 0;
  double to = 0;
};

/// The part of a frame that is exposed, `blur` of it (0 to 1) around the frame, in the direction of playing.
[[nodiscard]] BlurWay blur_way(const UploadedMove& move, std::uint8_t motor, std::int32_t frame,
                               int direction, double blur);
/// The same part of a way that was given for shutter angles 0 to 360.
[[nodiscard]] BlurWay shortened(const BlurWay& way, double blur);

/// What a motor does in a shot: `start` in steps, not rounded.
struct ShotWay {
  double start = 0;
  std::vector<ShotPiece> pieces;
};
/// Where it comes to rest.
[[nodiscard]] double end_of(const ShotWay& way);

/// A second from rest to a constant speed, the way in `exposure_s`, and a second to rest.
[[nodiscard]] ShotWay constant_speed_shot(const BlurWay& way, double exposure_s);
/// To the middle in half of the exposure and to the end in the other, each at its constant speed; a second
/// before and behind.
[[nodiscard]] ShotWay two_speed_shot(double from, double middle, double to, double exposure_s);

/// A shutter that turns once, with the way from angle 0 to 360 in `turn_s`: an eighth of it to gather speed
/// and one to lose it.
struct ShutterTurn {
  double turn_s = 0;
  double wait_s = 0;  ///< the motors begin so much behind Go
  double hold_s = 0;  ///< and rest so long before the shutter closes
};
[[nodiscard]] ShotWay shutter_turn_shot(const BlurWay& way, const ShutterTurn& turn);

}  // namespace inbetween::dragonframe
