#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "piece_fit.hpp"

namespace inbetween {
namespace {

/// Degree 7 * 4 of q(t(u)) plus 2 * 6 of t'(u)^2.
inline constexpr std::size_t residual_degree = 40;

using Polynomial = std::array<double, residual_degree + 1>;

/// Multiplies a polynomial of `count` coefficients, lowest first, by another, in its place: the stack of a
/// microcontroller has no room for a copy.
void multiply(Polynomial& p, std::size_t& count, std::span<const double> by) {
  count += by.size() - 1;
  for (std::size_t k = count; k-- > 0;) {
    double sum = 0;
    for (std::size_t j = 0; j <= std::min(k, by.size() - 1); ++j) sum += p[k - j] * by[j];
    p[k] = sum;
  }
}

/// A bound of |p| over u in [0, 1]: its largest Bernstein coefficient, b_j = sum_i C(j,i)/C(n,i) p_i,
/// plus a bound of the rounding of the sums.
double bernstein_bound(const Polynomial& p) {
  constexpr std::size_t n = residual_degree;
  double bound = 0;
  double magnitude = 0;
  for (const double c : p) magnitude += std::fabs(c);
  for (std::size_t j = 0; j <= n; ++j) {
    double ordinate = p[0];
    double ratio = 1;  // C(j,i) / C(n,i)
    for (std::size_t i = 1; i <= j; ++i) {
      ratio *= static_cast<double>(j - i + 1) / static_cast<double>(n - i + 1);
      ordinate += ratio * p[i];
    }
    bound = std::max(bound, std::fabs(ordinate));
  }
  return bound + 4 * std::numeric_limits<double>::epsilon() * magnitude;
}

}  // namespace

double PieceFitter::certified_residual(const PieceEnd& near, const PieceEnd& far, double outward_step,
                                       const std::array<double, 8>& c) const {
  // tau(u), and its square of the slope per unit of y.
  std::array<double, 8> tau = c;
  if (interval_.forward) {
    tau[0] = near.tau;
  } else {
    for (double& coefficient : tau) coefficient = -coefficient;
    tau[0] = far.tau;
  }
  std::array<double, 7> slope;
  for (std::size_t i = 0; i < 7; ++i) slope[i] = static_cast<double>(i + 1) * tau[i + 1] / outward_step;

  Polynomial residual{};  // q(tau(u)) by Horner's rule in polynomials, times the slope squared
  residual[0] = interval_.speed_squared.q[4];
  std::size_t count = 1;
  for (std::size_t power = 4; power-- > 0;) {
    multiply(residual, count, tau);
    residual[0] += interval_.speed_squared.q[power];
  }
  multiply(residual, count, slope);
  multiply(residual, count, slope);
  if (!interval_.stands_still) {
    residual[0] -= 1;
    return bernstein_bound(residual);
  }
  // Compare with (2 y)^2, y linear in u, relative to its least value on the piece.
  const double y0 = interval_.forward ? near.y : far.y;
  const double step = interval_.forward ? outward_step : -outward_step;
  residual[0] -= 4 * y0 * y0;
  residual[1] -= 8 * y0 * step;
  residual[2] -= 4 * step * step;
  if (near.y > 0) return bernstein_bound(residual) / (4 * near.y * near.y);
  // On the first piece both sides vanish as y^2: divide it out where y = step * u (or step * (1 - u)).
  if (!interval_.forward) {  // reverse to v = 1 - u by Taylor shift at 1
    for (std::size_t i = 0; i <= residual_degree; ++i) {
      for (std::size_t j = residual_degree; j-- > i;) residual[j] += residual[j + 1];
    }
    for (std::size_t i = 1; i <= residual_degree; i += 2) residual[i] = -residual[i];
  }
  for (std::size_t i = 2; i <= residual_degree; ++i) residual[i - 2] = residual[i] / (4 * step * step);
  residual[residual_degree - 1] = residual[residual_degree] = 0;
  return bernstein_bound(residual);
}

}  // namespace inbetween
