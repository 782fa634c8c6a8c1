// The move that the page edits: its tracks, solved, and its certificate. There is one, in static memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "editor/solver/certificate.hpp"
#include "editor/solver/exchange.hpp"
#include "editor/solver/track_slot.hpp"

namespace inbetween::editor {

class Session {
 public:
  /// Solves what the track request says. Behind it are these integers: key, frame, hold, whether it breaks
  /// and whether it eases of each lock; the key frames; the overlaps of the corners, if there are key frames;
  /// key, part, parts and length of each segment of a path that the program made. And these numbers: the
  /// position of every axis at each key; the lap; the weights; tension, continuity and bias of each shape;
  /// the control values; the tolerances of the corners, if there are no key frames; the cubics of every
  /// segment.
  Status solve_track(std::int32_t index, const Exchange& arguments);
  /// Makes the move that the move request says of the solved tracks. Integers: of each motor its axis and how
  /// many marks it has. Numbers: eight for each axis, and then for each motor (min, max, max_velocity,
  /// max_acceleration, max_jerk, max_acceleration_step, stop_acceleration, stop_jerk), not a number where the
  /// rig does not say; of each motor its marks, the place of the axis and that of the motor.
  Status assemble(const Exchange& arguments);

  [[nodiscard]] const TrackSlot* solved(std::int32_t index) const;
  /// The move; false while there is none, or after an error.
  [[nodiscard]] bool is_assembled() const { return assembled_; }
  [[nodiscard]] const Certificate& certificate() const { return certificate_; }

 private:
  [[nodiscard]] std::span<const Track> tracks() const;
  // The spans of what they read are in the arguments or in the members below.
  TrackInput read_track(const TrackRequest& request, Reader& reader);
  std::span<const KeyShape> read_shapes(std::int32_t count, Reader& reader);
  std::span<const KeyLock> read_locks(std::int32_t count, Reader& reader);
  CubicPathSpec read_cubics(const TrackRequest& request, const TrackInput& input, Reader& reader);
  Status read_limits(std::size_t count, Reader& reader);
  Status read_motor(std::size_t number, Reader& reader);

  std::array<TrackSlot, max_tracks> slots_;
  std::array<KeyLock, max_locks> locks_;
  std::array<KeyShape, max_keys> shapes_;
  std::array<Cubic, max_segments*(max_axes + max_guides)> cubics_;
  std::array<FrameKnot, max_segments> knots_;
  /// Tracks one after the other, as Move wants them; a Track has no value without a path.
  alignas(Track) std::array<std::byte, max_tracks * sizeof(Track)> tracks_;
  std::size_t track_count_ = 0;
  alignas(AxisLimits) std::array<std::byte, max_moved * sizeof(AxisLimits)> limits_;
  alignas(Calibration) std::array<std::byte, max_move_axes * sizeof(Calibration)> curves_;
  std::array<CalibrationPiece, max_move_axes*(Calibration::max_marks + 1)> curve_pieces_;
  std::array<CalibratedMotor, max_move_axes> motors_;
  Certificate certificate_;
  bool assembled_ = false;
};

}  // namespace inbetween::editor
