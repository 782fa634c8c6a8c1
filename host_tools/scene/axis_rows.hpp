// Where the axes of a rig are on the rows of a scene, and how far they leave a straight line between two.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/exchange/plan_table.hpp"
#include "host_tools/plan/plan.hpp"

namespace inbetween {

/// In the unit of the axis.
struct AxisRow {
  std::string name;
  std::vector<double> positions;  ///< on each row
  /// Between each two rows a bound of how far the axis is from the straight line between them.
  std::vector<double> off;
};

struct AxisRows {
  std::string name;              ///< of the move or the take
  FrameRate fps;                 ///< rows a second
  std::int64_t first_frame = 0;  ///< the number of the first row
  std::size_t rows = 0;
  std::vector<AxisRow> axes;  ///< those that are in a track
};

/// Those of table_of_plan, without rolls. Between two rows an axis is within h^2/8 of the largest
/// acceleration there, which bound_trajectory proves, and h/4 of each step of its velocity. Throws what
/// table_of_plan throws, SolverError, and InputError with `has_rolls`. O(rows * axes * log pieces).
AxisRows rows_of_plan(const Plan& plan, const PlanTableOptions& options = {});

}  // namespace inbetween
