#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "host_tools/plan/bounded_move.hpp"
#include "host_tools/plan/solved_track.hpp"
#include "inbetween/limits/stop_bounds.hpp"

/// What is proven of moves that are no plan.

namespace inbetween {

/// Of one track, or a part of it, without rolls.
inline BoundedMove bounds_of_track(const Track& track,
                                   const std::optional<WholeFrames>& part = std::nullopt) {
  const std::span<const Track> alone(&track, 1);
  return {value_or_throw(Move::make(alone, {}, part)), alone};
}

/// Its motion in cells, as stop bounds for these limits need it.
inline BoundedMove bounded_cells(const Move& move, std::span<const Track> tracks,
                                 std::span<const AxisLimits> limits, std::size_t cells, double rate,
                                 double tick_seconds) {
  std::vector<MotionTriple> room(limits.size());
  write_room(limits, rate, tick_seconds, room);
  return BoundedMove(move, tracks, {.limits = {}, .motors = {}, .cells = cells, .room = room});
}

}  // namespace inbetween
