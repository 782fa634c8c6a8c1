// The rows of an exposure in motion.
#pragma once

#include <cstdint>
#include <span>

#include "host_tools/dragonframe/rig_port.hpp"
#include "host_tools/hosted/row_move.hpp"
#include "host_tools/hosted/step_scale.hpp"

namespace inbetween {

struct ShotRows {
  MoveRows rows;
  std::int32_t closed_at = 0;  ///< the frame of the rows at or behind the end of the exposure
};

/// A row at the end of each piece, and 50 a second in between, of shots of more than a minute fewer. Motors
/// that rest have their place in every row. Where a piece goes from one velocity to another, it does not do
/// so with a constant acceleration, which would step at both ends, but along 3u^2 - 2u^3: in the same time
/// over the same distance, with 1.5 times the acceleration in the middle.
ShotRows rows_of(const dragonframe::PrepareShot& shot, std::span<const StepScale> scales);

}  // namespace inbetween
