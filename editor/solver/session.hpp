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

/// The functions of abi.cpp, which says what each reads and writes, on data instead of on static memory.
class Session {
 public:
  Status solve_track(std::int32_t index, const Exchange& arguments);
  Status assemble(const Exchange& arguments);

  [[nodiscard]] const TrackSlot* solved(std::int32_t index) const;
  /// The move; false while there is none, or after an error.
  [[nodiscard]] bool is_assembled() const { return assembled_; }
  [[nodiscard]] const Certificate& certificate() const { return certificate_; }

 private:
  [[nodiscard]] std::span<const Track> tracks() const;
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
