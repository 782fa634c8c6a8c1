#include "inbetween/homing/setpoint_trail.hpp"

#include <algorithm>

namespace inbetween {

template <Precise Real>
void SetpointTrail<Real>::push(std::int64_t at_ns, const Setpoint<Real>& setpoint) {
  newest_ = (newest_ + 1) % capacity;
  steps_[newest_] = {at_ns, setpoint};
  count_ = std::min(count_ + 1, capacity);
}

template <Precise Real>
const typename SetpointTrail<Real>::Step& SetpointTrail<Real>::step(std::size_t age) const {
  return steps_[(newest_ + capacity - age) % capacity];
}

template <Precise Real>
std::optional<Real> SetpointTrail<Real>::position_at(std::int64_t at_ns) const {
  if (count_ == 0 || at_ns > step(0).at_ns) return std::nullopt;
  for (std::size_t age = 0; age < count_; ++age) {
    if (at_ns == step(age).at_ns) return step(age).setpoint.position;
    if (at_ns > step(age).at_ns) return between(step(age), step(age - 1), at_ns);
  }
  return std::nullopt;
}

/// The quintic by its values, first and second derivatives at both ends, as distances from the start: what
/// the duration makes of a velocity and half of an acceleration.
template <Precise Real>
Real SetpointTrail<Real>::between(const Step& from, const Step& to, std::int64_t at_ns) {
  constexpr Real second = 1'000'000'000;
  const Real duration = static_cast<Real>(to.at_ns - from.at_ns) / second;
  const Real u = static_cast<Real>(at_ns - from.at_ns) / static_cast<Real>(to.at_ns - from.at_ns);
  const Real way = to.setpoint.position - from.setpoint.position;
  const Real v0 = from.setpoint.velocity * duration;
  const Real v1 = to.setpoint.velocity * duration;
  const Real a0 = from.setpoint.acceleration * duration * duration / 2;
  const Real a1 = to.setpoint.acceleration * duration * duration / 2;
  const Real c3 = 10 * way - 6 * v0 - 4 * v1 - 3 * a0 + a1;
  const Real c4 = -15 * way + 8 * v0 + 7 * v1 + 3 * a0 - 2 * a1;
  const Real c5 = 6 * way - 3 * v0 - 3 * v1 - a0 + a1;
  return from.setpoint.position + u * (v0 + u * (a0 + u * (c3 + u * (c4 + u * c5))));
}

template class SetpointTrail<double>;
template class SetpointTrail<float>;

}  // namespace inbetween
