#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/timing/track.hpp"

/// The table that people and other programs see: the point of the path at every frame.

namespace inbetween {

/// How good a table is, as its maker says.
struct Provenance {
  double constant = 0;          ///< K
  double speed_error = 0;       ///< closed form: delta
  double short_step_error = 0;  ///< of a step below 1e-6 of the length, as a share of the length
};

/// N + 1 points in the caller's memory.
class FrameTable {
 public:
  FrameTable(std::span<const PathPoint> points, const Provenance& provenance)
      : points_(points), provenance_(provenance) {}

  /// N
  [[nodiscard]] std::int32_t frames() const { return static_cast<std::int32_t>(points_.size()) - 1; }
  [[nodiscard]] const PathPoint& point(std::int32_t frame) const {
    return points_[static_cast<std::size_t>(frame)];
  }
  [[nodiscard]] std::span<const PathPoint> points() const { return points_; }
  [[nodiscard]] const Provenance& provenance() const { return provenance_; }

 private:
  std::span<const PathPoint> points_;
  Provenance provenance_;
};

/// The table in closed form. `memory` has room for N + 1 points.
/// Row j equals Track::locate at frame j, but for a rounding (a few ulp of t) by which a point would
/// fall back behind the one before it: there the row repeats the earlier point, so that s never falls.
/// Errors: capacity. Cost: about 15 ns a frame on a desktop machine.
Result<FrameTable> closed_form_table(const Track& track, std::span<PathPoint> memory);

/// One frame as the animator reads it.
struct FrameRow {
  double alpha = 0;         ///< a = j f / N, where on the speed curve
  PathPoint point;          ///< s = segment + t
  double distance = 0;      ///< arc length from the start, weighted axis units
  double speed = 0;         ///< along the path, per second
  double acceleration = 0;  ///< along the path, per second squared
};

/// The distance is measured along the path to the row's own point, whichever solver found it; speed
/// and acceleration are those of the drawn curve with the table's K.
FrameRow frame_row(const Track& track, const FrameTable& table, std::int32_t frame);

/// How far the travelled distances are from the drawn ones.
struct SpeedDeviation {
  double relative = 0;      ///< worst |travelled / drawn - 1| over the steps longer than 1e-6 of the length
  std::int32_t frame = -1;  ///< the frame on which that step ends
  double absolute = 0;      ///< worst deviation of a shorter step, as a share of the length
  std::int32_t absolute_frame = -1;
};

/// Measured by quadrature along the path, not with the inverse that made the table.
SpeedDeviation measure_speed_deviation(const Track& track, std::span<const PathPoint> points);

/// Names the first rule that a table breaks, with the frame:
/// every point is on the path; the first is its start and the last its end, exactly; s never falls;
/// the speed is as drawn within what the provenance promises. Cost: about 0.1 us a frame.
Status check_invariants(const Track& track, const FrameTable& table);

}  // namespace inbetween
