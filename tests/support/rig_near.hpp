// Rigs whose limits are near the peaks of a move.
#pragma once

#include <functional>
#include <optional>

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "tests/support/random_move.hpp"

namespace inbetween {

/// The move as a file of the program; nothing where its numbers are beyond what a file may say or a rig can
/// count in 31 bits.
std::optional<MoveFile> for_a_rig(const RandomMove& random);

struct RigNear {
  std::function<double()> share;  ///< of a limit, as a multiple of the peak of the move; called for each
  bool limits_jerk = false;
  bool allows_steps = false;  ///< of the acceleration, where the path has them
  std::int32_t rate_hz = 100;
};

/// The axes of all tracks, with room of the size of the move on either side. Nothing where an axis
/// stands still, hardly moves for its digits, or has a peak without bound.
std::optional<RigFile> rig_near(const MoveFile& move, const RigNear& request);

}  // namespace inbetween
