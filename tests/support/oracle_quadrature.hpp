// Definite integrals for the oracle: Gauss and Legendre's rule, with intervals halved until it agrees with
// itself.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <vector>

namespace inbetween::oracle {

/// Points of the rule on one interval. With 12 of them a whole frame step of an ordinary move passes at the
/// first comparison, and a long interval beside a cusp costs no more than with 8 or 20.
inline constexpr std::size_t gauss_points = 12;

struct GaussLegendreRule {
  std::array<long double, gauss_points> node{};  ///< in (-1, 1)
  std::array<long double, gauss_points> weight{};
};

/// Computed once, by Newton's method on the Legendre polynomial: no table of digits to mistype.
const GaussLegendreRule& gauss_legendre_rule();

template <typename Function>
long double gauss_legendre(const Function& integrand, long double from, long double to) {
  const GaussLegendreRule& rule = gauss_legendre_rule();
  const long double middle = from + (to - from) / 2;
  const long double half = (to - from) / 2;
  long double sum = 0;
  for (std::size_t i = 0; i < gauss_points; ++i)
    sum += rule.weight[i] * integrand(middle + half * rule.node[i]);
  return half * sum;
}

/// Integral of a function that is smooth inside [from, to]; from > to gives the negative. An interval is
/// accepted when the rule on it and the rule on its halves differ by at most error_density times its width,
/// and the halves are what is summed: their true error is mostly far smaller, and beside a near-kink up to
/// fifty times larger. Throws std::runtime_error where 10 000 halvings do not suffice.
template <typename Function>
long double integral(const Function& integrand, long double from, long double to, long double error_density) {
  struct Interval {
    long double from, to, whole;
  };
  if (from == to) return 0;
  std::vector<Interval> open = {{from, to, gauss_legendre(integrand, from, to)}};
  long double sum = 0;
  for (int halvings = 0; !open.empty(); ++halvings) {
    if (halvings == 10'000) throw std::runtime_error("oracle: the integral does not converge");
    const Interval interval = open.back();
    open.pop_back();
    const long double middle = interval.from + (interval.to - interval.from) / 2;
    const long double left = gauss_legendre(integrand, interval.from, middle);
    const long double right = gauss_legendre(integrand, middle, interval.to);
    if (std::fabs(left + right - interval.whole) <= error_density * std::fabs(interval.to - interval.from)) {
      sum += left + right;
    } else {
      open.push_back({middle, interval.to, right});
      open.push_back({interval.from, middle, left});
    }
  }
  return sum;
}

}  // namespace inbetween::oracle
