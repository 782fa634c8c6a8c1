// How much a take may differ.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "host_tools/takes/take_compare.hpp"
#include "host_tools/takes/take_errors.hpp"

namespace inbetween {

struct TakeBudget {
  enum class Unit : std::uint8_t { mm, deg, px };
  double largest = 0;  ///< 0 or more
  Unit unit = Unit::mm;
};

/// "1px", "0.2 mm", "0.05deg". Throws std::runtime_error, one line, for anything else.
TakeBudget parse_budget(std::string_view text);

struct BudgetVerdict {
  bool holds = false;
  double largest = 0;        ///< of what the budget is for, in its unit, with `interpolation`
  double interpolation = 0;  ///< that is in it
  double frame = 0;          ///< where
  std::string name;          ///< of the axis or the tip
  std::string sentence;      ///< "camera is off by 2.1 px at frame 96, over the budget of 1 px"
};

/// A budget in px is for the picture. One in mm or deg is for the tips, or for the axes of a rig without
/// joints, those in m, rad and turn converted. What interpolation may have hidden counts as if it were there.
/// Throws std::runtime_error, one line, where nothing is measured in the unit.
BudgetVerdict judge(const TakeBudget& budget, const TakeComparison& comparison);
/// The same of a take against its plan.
BudgetVerdict judge(const TakeBudget& budget, const TakeErrors& errors);

}  // namespace inbetween
