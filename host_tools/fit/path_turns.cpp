#include "host_tools/fit/path_turns.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

namespace inbetween {

bool PathTurns::find(const Path& path, const PathPoint& point) {
  const std::span<const Cubic> cubics = path.segment(point.segment);
  const std::span<const double> weights = path.weights();
  const double t = point.t;
  double q = 0;  // |W P'|^2 and its derivatives by t
  double q1 = 0;
  double q2 = 0;
  double q3 = 0;
  for (std::size_t d = 0; d < cubics.size(); ++d) {
    const double first = weights[d] * cubics[d].derivative(t);
    const double second = weights[d] * cubics[d].second(t);
    const double third = weights[d] * cubics[d].third();
    q += first * first;
    q1 += 2 * first * second;
    q2 += 2 * (second * second + first * third);
    q3 += 6 * second * third;
  }
  if (!(std::isnormal(q) && std::isnormal(q * q * q))) return false;
  // Derivatives of t by L, from t' = q^(-1/2).
  const double t1 = 1 / std::sqrt(q);
  const double t2 = -q1 / (2 * q * q);
  const double t3 = t1 * (q1 * q1 / q - q2 / 2) / (q * q);
  const double t4 = ((13 * q1 * q2 / 4 - 7 * q1 * q1 * q1 / (2 * q)) / q - q3 / 2) / (q * q * q);
  curvature = 0;
  double third_derivative = 0;
  axes.clear();
  for (std::size_t d = 0; d < cubics.size(); ++d) {
    const double first = cubics[d].derivative(t);
    const double second = cubics[d].second(t);
    const double third = cubics[d].third();
    const std::array<double, 4> turn = {
        first * t1, second * t1 * t1 + first * t2, third * t1 * t1 * t1 + 3 * second * t1 * t2 + first * t3,
        6 * third * t1 * t1 * t2 + 3 * second * t2 * t2 + 4 * second * t1 * t3 + first * t4};
    axes.push_back(turn);
    curvature = std::hypot(curvature, weights[d] * turn[1]);
    third_derivative = std::hypot(third_derivative, weights[d] * turn[2]);
  }
  scale = 1 / std::max(curvature, std::sqrt(third_derivative));
  return true;
}

}  // namespace inbetween
