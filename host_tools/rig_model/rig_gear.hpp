// What lies between an axis and its motors: the marks of a calibration, the play of a gear.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "host_tools/text/diagnostics.hpp"
#include "inbetween/limits/calibration.hpp"

namespace inbetween {

enum class AxisUnit { mm, m, deg, rad, turn, unit };
inline constexpr std::array<std::string_view, 6> axis_unit_names = {"mm", "m", "deg", "rad", "turn", "unit"};
std::string_view to_string(AxisUnit unit);

/// Limits of a motor, all above 0, in its unit and seconds. Those of a stop are not below the others.
struct MotorLimits {
  double max_velocity = 0;
  double max_acceleration = 0;
  std::optional<double> max_jerk = {};
  double stop_acceleration = 0;
  std::optional<double> stop_jerk = {};  // there if max_jerk is
};

/// The curve of a calibration, with its memory.
class CalibrationCurve {
 public:
  /// Nothing but `error()` where the core refuses the marks.
  explicit CalibrationCurve(std::span<const CalibrationMark> marks)
      : pieces_(marks.size() + 1), curve_(Calibration::make(marks, pieces_)) {}
  CalibrationCurve(const CalibrationCurve&) = delete;
  CalibrationCurve& operator=(const CalibrationCurve&) = delete;

  [[nodiscard]] const Result<Calibration>& curve() const { return curve_; }

 private:
  std::vector<CalibrationPiece> pieces_;
  Result<Calibration> curve_;
};

/// The marks reach from `min` to `max` of the axis at least.
struct AxisCalibration {
  AxisUnit unit = AxisUnit::deg;  // of the motor
  std::vector<CalibrationMark> marks;
  std::shared_ptr<const CalibrationCurve> curve;  // made of them; there always

  [[nodiscard]] const Calibration& motor() const { return curve->curve().value(); }
};

struct AxisBacklash {
  double play = 0;       // in the unit of the motor, above 0
  double take_up_s = 0;  // above 0
  bool approach_is_up = true;
};

}  // namespace inbetween
