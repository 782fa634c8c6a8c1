// The speed curve that is nearest to a wanted one and keeps the limits, for one number of control values and
// one start.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "host_tools/fit/curve_sums.hpp"
#include "host_tools/fit/speed_constraints.hpp"

namespace inbetween {

/// The part of a curve that stays while the rest changes.
struct CurveFrame {
  std::vector<double> wanted;       ///< f + 1 control values
  std::vector<bool> rests;          ///< the control values that are 0 and stay 0
  std::vector<double> fixed_areas;  ///< places a, rising, the last is f; Phi there stays that of `wanted`
  CurveEnds ends = CurveEnds::natural;
};

/// The curve that a descent has reached, and by how much it misses.
struct Descent {
  std::vector<double> values;
  Excess excess;  ///< over all moments; the limits are kept if its share is at most descent_tolerance
  double change =
      0;  ///< root mean square of phi - wanted phi over a, as a share of the mean of the wanted phi
};

/// A descent may exceed a limit by this share. check() rounds up by far more.
inline constexpr double descent_tolerance = 1e-6;

/// Minimizes the integral of (phi - wanted phi)^2 with the limits at all moments of a MotionSamples kept, 0
/// <= values <= 100. Sequential quadratic programming with an exact penalty on the largest excess, in a trust
/// region (Fletcher, Practical Methods of Optimization, ch. 14).
/// It finds a local minimum. Cost: linear in control values and moments, up to 80 times.
class SpeedDescent {
 public:
  /// Throws std::invalid_argument if the fixed areas contradict the rests.
  explicit SpeedDescent(const CurveFrame& frame);

  /// The curve with the rests and the fixed areas that is nearest to the given one. Throws
  /// std::invalid_argument where there is none from 0 to 100.
  [[nodiscard]] std::vector<double> nearest(std::span<const double> values) const;
  /// Descends from `start`, which has the rests and the fixed areas, until `is_over`, if there is one. It
  /// leaves the samples evaluated at the result.
  [[nodiscard]] Descent run(std::span<const double> start, MotionSamples& samples,
                            std::span<const Allowance> allowances,
                            const std::function<bool()>& is_over = {}) const;

 private:
  /// What a step may cost and how far it may go.
  struct Region {
    std::span<const Allowance> allowances;
    double price = 0;   ///< of an excess
    double radius = 0;  ///< the largest change of a control value, in units
  };
  /// The best curve of the region where the limits are linear, and the excess that is left there.
  struct Step {
    std::vector<double> values;
    double ease = 0;
  };

  /// Nothing where rounding leaves no solution. The samples are evaluated at `here`.
  [[nodiscard]] std::optional<Step> step_from(const Descent& here, const MotionSamples& samples,
                                              const Region& region) const;
  [[nodiscard]] Descent at(std::vector<double> values, MotionSamples& samples,
                           std::span<const Allowance> allowances) const;
  /// The curves with the rests and the fixed areas, in units of unit_, and their distance from `target`.
  [[nodiscard]] BandProgram programme(std::span<const double> target) const;
  [[nodiscard]] double distance_of(std::span<const double> one, std::span<const double> other) const;
  [[nodiscard]] double change_squared(std::span<const double> values) const;
  [[nodiscard]] std::vector<double> values_of(const BandProgram& program) const;
  [[nodiscard]] std::vector<double> in_units(std::span<const double> values) const;

  CurveFrame frame_;
  CurveSums sums_;
  double unit_;           ///< mean of the wanted curve: control values are counted in it
  BandProgram distance_;  ///< programme(wanted)
};

}  // namespace inbetween
