#include "inbetween/joints/angle_of.hpp"

#include <algorithm>
#include <cmath>

#include "inbetween/joints/sine_cosine.hpp"

namespace inbetween {
namespace {

constexpr double pi = 3.14159265358979323846;

/// Within 0.005 of the angle of (x, y), 0 <= y <= x.
template <Precise Real>
Real rough_angle(Real x, Real y) {
  const Real ratio = y / x;
  return ratio * (static_cast<Real>(pi / 4) + static_cast<Real>(0.273) * (1 - ratio));
}

}  // namespace

template <Precise Real>
Real angle_of(Real x, Real y) {
  const Real largest = std::max(std::fabs(x), std::fabs(y));
  if (largest == 0) return 0;
  // In the first eighth of a turn; the squares neither overflow nor vanish.
  const Real a = std::fabs(x) / largest;
  const Real b = std::fabs(y) / largest;
  const Real longer = std::max(a, b);
  const Real shorter = std::min(a, b);
  Real angle = rough_angle(longer, shorter);
  for (int step = 0; step < 2; ++step) {
    const SineCosine<Real> at = sine_cosine(angle);
    // The tangent of what is missing, and its arc, which is wrong by its fifth power.
    const Real missing = (shorter * at.cosine - longer * at.sine) / (longer * at.cosine + shorter * at.sine);
    angle += missing - missing * missing * missing / 3;
  }
  if (b > a) angle = static_cast<Real>(pi / 2) - angle;
  if (x < 0) angle = static_cast<Real>(pi) - angle;
  return y < 0 ? -angle : angle;
}

template double angle_of(double x, double y);
template float angle_of(float x, float y);

}  // namespace inbetween
