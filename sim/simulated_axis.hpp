#pragma once

#include <cstdint>

namespace inbetween {

/// An axis with an ideal drive: it interpolates to each setpoint within one tick, so that it is always
/// where it was told to be a tick ago. Positions in axis units.
class SimulatedAxis {
 public:
  /// At rest at `position`, with that as its setpoint.
  explicit SimulatedAxis(double position) : commanded_(position), actual_(position) {}

  /// One tick: the drive arrives at the last setpoint and takes the next.
  void tick(double setpoint);

  [[nodiscard]] double commanded() const { return commanded_; }
  [[nodiscard]] double actual() const { return actual_; }
  /// The largest |commanded - actual| that any tick has left.
  [[nodiscard]] double following_error_peak() const { return following_error_peak_; }

 private:
  double commanded_;
  double actual_;
  double following_error_peak_ = 0;
};

}  // namespace inbetween
