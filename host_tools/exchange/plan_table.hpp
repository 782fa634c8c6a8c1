// A plan as a baked motion, for other programs.
#pragma once

#include <optional>

#include "host_tools/exchange/baked_table.hpp"
#include "host_tools/plan/plan.hpp"

namespace inbetween {

struct PlanTableOptions {
  std::optional<FrameRate> fps = {};  // rows a second; those of the move where nothing is said
  ShutterPhase phase = ShutterPhase::frame_boundary;  // half a frame later for exposure_centre
  bool has_rolls = false;                             // the pre-roll and the post-roll as well
};

/// Every axis that is in a track, with its unit; the positions are those that play (Plan::motion). Row k is
/// at k / fps seconds from the first frame that is played, and half a row later where a row is the middle of
/// an exposure; the last row is the first at or after the end, where the axes hold. `first_frame` is the
/// frame of the move where rows are frames, and 0 otherwise. Throws InputError where there would be fewer
/// than two rows or more than max_table_rows. O(rows * axes * log pieces).
BakedTable table_of_plan(const Plan& plan, const PlanTableOptions& options = {});

/// The moment of the move at which row `row` of that table is.
FrameTime time_of_plan_row(const Plan& plan, const PlanTableOptions& options, std::int64_t row);

}  // namespace inbetween
