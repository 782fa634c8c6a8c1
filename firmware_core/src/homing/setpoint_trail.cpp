#include "inbetween/homing/setpoint_trail.hpp"

#include <algorithm>

#include "base/quintic.hpp"

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

/// Positions count from the start, and derivatives are by the share of the duration.
template <Precise Real>
Real SetpointTrail<Real>::between(const Step& from, const Step& to, std::int64_t at_ns) {
  constexpr Real second = 1'000'000'000;
  const Real duration = static_cast<Real>(to.at_ns - from.at_ns) / second;
  const Real u = static_cast<Real>(at_ns - from.at_ns) / static_cast<Real>(to.at_ns - from.at_ns);
  const Real way = to.setpoint.position - from.setpoint.position;
  const auto end_of = [&](const Step& step, Real position) {
    return QuinticEnd<Real>{position, step.setpoint.velocity * duration,
                            step.setpoint.acceleration * duration * duration};
  };
  return from.setpoint.position + value_at(joining(end_of(from, 0), end_of(to, way)), u);
}

template class SetpointTrail<double>;
template class SetpointTrail<float>;

}  // namespace inbetween
