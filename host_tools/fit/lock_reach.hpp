// Whether any motion passes from one locked key to the next as the limits of the axes ask.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "host_tools/plan/plan.hpp"

namespace inbetween {

/// Coming from one key on its frame, another cannot be met on its frame.
struct UnreachedLock {
  std::int32_t begin_key = 0;
  std::int32_t begin_frame = 0;  ///< behind its hold
  std::int32_t end_key = 0;
  std::int32_t end_frame = 0;
  std::size_t axis = 0;  ///< of the rig: the one that cannot
};

/// Follows the speeds that are possible along the path from lock to lock. Between two of them the position of
/// each axis is known at both ends, and from an interval of velocities at the first, max_acceleration leaves
/// an interval at the second. All axes have one speed along the path, which cannot be below 0. Where the
/// intervals have no speed in common, no speed curve meets the locks, however many control values it has:
/// proven, but not sharp, because the stretch between two locks is looked at axis by axis. The fewest
/// neighbouring locks that prove it are told. Nothing where a speed is left everywhere, which proves nothing.
/// The plan has a rig. O(locks * axes), and that times the locks told of.
std::optional<UnreachedLock> unreached_lock(const Plan& plan, std::size_t track);

}  // namespace inbetween
