// The drawn speed curve of the oracle: a uniform cubic B-spline by the Cox-de Boor recursion.
#pragma once

#include <vector>

namespace inbetween::oracle {

/// phi(a) on 0 <= a <= f, control value v_i over a = i, natural ends: phantom values v_-1 = 2 v_0 - v_1 and
/// v_f+1 = 2 v_f - v_f-1. Every function throws std::out_of_range outside [0, f].
class Profile {
 public:
  /// One value means two equal ones. Throws std::invalid_argument for none.
  explicit Profile(std::vector<long double> control_values);
  explicit Profile(const std::vector<double>& control_values);

  /// f, the right end of the curve.
  int spans() const { return static_cast<int>(values_.size()) - 3; }

  long double value(long double a) const;
  /// Derivative of order 1 or 2 with respect to a.
  long double derivative(int order, long double a) const;
  /// Integral from a0 to a1, exact: Gauss's rule of two points on every span, where phi is one cubic. Nothing
  /// is subtracted, so that a short step keeps its digits.
  long double integral(long double a0, long double a1) const;
  /// Integral from 0 to a, Phi(a).
  long double integral(long double a) const;

 private:
  /// Sum of the values times uniform B-splines of the given degree, shifted so that value k starts at knot k
  /// - 3.
  long double sum(const std::vector<long double>& values, int degree, long double a) const;

  std::vector<long double> values_;            ///< with one phantom at either end
  std::vector<long double> integral_to_knot_;  ///< from 0 to a = 0, 1, .. f
};

}  // namespace inbetween::oracle
