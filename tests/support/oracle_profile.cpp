#include "tests/support/oracle_profile.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>

namespace inbetween::oracle {
namespace {

/// The Cox-de Boor recursion on the integer knots: N(first knot, degree) at a.
long double basis(int first_knot, int degree, long double a) {
  const auto from = static_cast<long double>(first_knot);
  if (degree == 0) return from <= a && a < from + 1 ? 1 : 0;
  const auto p = static_cast<long double>(degree);
  return (a - from) / p * basis(first_knot, degree - 1, a) +
         (from + p + 1 - a) / p * basis(first_knot + 1, degree - 1, a);
}

std::vector<long double> widened(const std::vector<double>& values) {
  return {values.begin(), values.end()};
}

std::vector<long double> differences(const std::vector<long double>& values) {
  std::vector<long double> result;
  for (std::size_t i = 1; i < values.size(); ++i) result.push_back(values[i] - values[i - 1]);
  return result;
}

[[noreturn]] void throw_beside_the_curve(long double a) {
  throw std::out_of_range("oracle: a = " + std::to_string(a) + " is not on the speed profile");
}

}  // namespace

Profile::Profile(const std::vector<double>& control_values) : Profile(widened(control_values)) {}

Profile::Profile(std::vector<long double> control_values) {
  if (control_values.empty()) throw std::invalid_argument("oracle: a speed profile needs a control value");
  if (control_values.size() == 1) control_values.push_back(control_values.front());
  const std::size_t f = control_values.size() - 1;
  values_.push_back(2 * control_values[0] - control_values[1]);
  for (const long double value : control_values) values_.push_back(value);
  values_.push_back(2 * control_values[f] - control_values[f - 1]);
  integral_to_knot_.push_back(0);
  for (int knot = 1; knot <= spans(); ++knot) {
    const auto a = static_cast<long double>(knot);
    integral_to_knot_.push_back(integral_to_knot_.back() + integral(a - 1, a));
  }
}

long double Profile::sum(const std::vector<long double>& values, int degree, long double a) const {
  if (!(a >= 0 && a <= static_cast<long double>(spans()))) throw_beside_the_curve(a);
  // Only degree + 1 of the functions differ from zero at a.
  const int span = static_cast<int>(std::floor(a));
  long double result = 0;
  for (int knot = span - degree; knot <= span; ++knot) {
    const int index = knot + degree;
    if (index < static_cast<int>(values.size()))
      result += values[static_cast<std::size_t>(index)] * basis(knot, degree, a);
  }
  return result;
}

long double Profile::value(long double a) const {
  return sum(values_, 3, a);
}

long double Profile::derivative(int order, long double a) const {
  // On knots one apart the derivative of a B-spline is the spline of the differences, one degree lower.
  switch (order) {
    case 1:
      return sum(differences(values_), 2, a);
    case 2:
      return sum(differences(differences(values_)), 1, a);
    default:
      throw std::out_of_range("oracle: no derivative of order " + std::to_string(order));
  }
}

long double Profile::integral(long double a) const {
  if (!(a >= 0 && a <= static_cast<long double>(spans()))) throw_beside_the_curve(a);
  const long double knot = std::floor(a);
  return integral_to_knot_[static_cast<std::size_t>(knot)] + integral(knot, a);
}

long double Profile::integral(long double a0, long double a1) const {
  if (a1 < a0) return -integral(a1, a0);
  const long double node = 1 / std::sqrt(3.0L);
  long double result = 0;
  for (long double from = a0; from < a1;) {
    const long double to = std::min(std::floor(from) + 1, a1);
    const long double middle = from + (to - from) / 2;
    const long double half = (to - from) / 2;
    result += half * (value(middle - half * node) + value(middle + half * node));
    from = to;
  }
  return result;
}

}  // namespace inbetween::oracle
