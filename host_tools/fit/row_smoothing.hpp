// Rows of one axis that were rounded, as the smoothest motion that rounds to them.
//
// A row a frame in whole degrees or counts is a staircase: played as it is, every stair is a jolt. What was
// meant is within half a step of each row, and of all such motions the smoothest is taken.
#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace inbetween {

/// Rows that no smooth motion passes although it passes all around them: one that was read wrong, or some
/// that repeat the row before them while the axis went on.
struct RowSpike {
  std::size_t first = 0;  ///< row
  std::size_t count = 1;
  double off =
      0;  ///< the most by which one of them is off the motion of the rows around it, in the unit of the axis
  bool operator==(const RowSpike&) const = default;
};

struct SmoothRows {
  std::vector<double> rows;      ///< each within half the resolution of what it was, spikes excepted
  std::vector<RowSpike> spikes;  ///< in the order of the rows; their rows are as the motion around them wants
};

/// Two equal rows at an end of the move are a rest: there they stay as they are, and so do the inner rows of
/// a hold. No row that was within `range` leaves it.
///
/// Method: the least sum of squared third differences, as a convex program (BandProgram). A row is part of a
/// spike where that sum, among the rows around it, falls to less than a quarter without the row, and does not
/// without the smoothness there, which is how a corner differs from a spike.
///
/// `resolution` is above 0, and rows are finite. Cost: about 0.1 ms for each row.
struct RowRange {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};
SmoothRows smooth_rows(std::span<const double> rows, double resolution, const RowRange& range = {});

/// The largest second difference: the acceleration of the rows, in units per frame and frame.
double largest_second_difference(std::span<const double> rows);

}  // namespace inbetween
