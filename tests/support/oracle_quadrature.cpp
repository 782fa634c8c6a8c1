#include "tests/support/oracle_quadrature.hpp"

#include <numbers>

namespace inbetween::oracle {
namespace {

struct Legendre {
  long double value;
  long double slope;
};

/// The Legendre polynomial of degree gauss_points, by its three-term recurrence.
Legendre legendre(long double x) {
  long double before = 1;
  long double value = x;
  for (std::size_t n = 1; n < gauss_points; ++n) {
    const auto k = static_cast<long double>(n);
    const long double next = ((2 * k + 1) * x * value - k * before) / (k + 1);
    before = value;
    value = next;
  }
  const auto degree = static_cast<long double>(gauss_points);
  return {value, degree * (x * value - before) / (x * x - 1)};
}

GaussLegendreRule computed_rule() {
  GaussLegendreRule rule;
  for (std::size_t i = 0; i < gauss_points; ++i) {
    // Chebyshev's angles lie so near the roots that Newton's method is at its limit after a few steps.
    long double x = std::cos(std::numbers::pi_v<long double> * (static_cast<long double>(i) + 0.75L) /
                             (static_cast<long double>(gauss_points) + 0.5L));
    for (int step = 0; step < 20; ++step) {
      const Legendre p = legendre(x);
      x -= p.value / p.slope;
    }
    const Legendre p = legendre(x);
    rule.node[i] = x;
    rule.weight[i] = 2 / ((1 - x) * (1 + x) * p.slope * p.slope);
  }
  return rule;
}

}  // namespace

const GaussLegendreRule& gauss_legendre_rule() {
  static const GaussLegendreRule rule = computed_rule();
  return rule;
}

}  // namespace inbetween::oracle
