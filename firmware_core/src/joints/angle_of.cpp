#include "inbetween/joints/angle_of.hpp"

#include <algorithm>
#include <cmath>

#include "inbetween/joints/sine_cosine.hpp"

namespace inbetween {
namespace {

constexpr double pi = 3.14159265358979323846;

/// Within 0.005 of the angle of (x, y), 0 <= y <= x.
double rough_angle(double x, double y) {
  const double ratio = y / x;
  return ratio * (pi / 4 + 0.273 * (1 - ratio));
}

}  // namespace

double angle_of(double x, double y) {
  const double largest = std::max(std::fabs(x), std::fabs(y));
  if (largest == 0) return 0;
  // In the first eighth of a turn; the squares neither overflow nor vanish.
  const double a = std::fabs(x) / largest;
  const double b = std::fabs(y) / largest;
  const double longer = std::max(a, b);
  const double shorter = std::min(a, b);
  double angle = rough_angle(longer, shorter);
  for (int step = 0; step < 2; ++step) {
    const SineCosine at = sine_cosine(angle);
    // The tangent of what is missing, and its arc, which is wrong by its fifth power.
    const double missing =
        (shorter * at.cosine - longer * at.sine) / (longer * at.cosine + shorter * at.sine);
    angle += missing - missing * missing * missing / 3;
  }
  if (b > a) angle = pi / 2 - angle;
  if (x < 0) angle = static_cast<double>(pi) - angle;
  return y < 0 ? -angle : angle;
}

}  // namespace inbetween
