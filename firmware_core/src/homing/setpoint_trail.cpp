#include "inbetween/homing/setpoint_trail.hpp"

#include <algorithm>

#include "base/quintic.hpp"

namespace inbetween {

void SetpointTrail::push(std::int64_t at_ns, const Setpoint& setpoint) {
  newest_ = (newest_ + 1) % capacity;
  steps_[newest_] = {at_ns, setpoint};
  count_ = std::min(count_ + 1, capacity);
}

const typename SetpointTrail::Step& SetpointTrail::step(std::size_t age) const {
  return steps_[(newest_ + capacity - age) % capacity];
}

std::optional<double> SetpointTrail::position_at(std::int64_t at_ns) const {
  if (count_ == 0 || at_ns > step(0).at_ns) return std::nullopt;
  for (std::size_t age = 0; age < count_; ++age) {
    if (at_ns == step(age).at_ns) return step(age).setpoint.position;
    if (at_ns > step(age).at_ns) return between(step(age), step(age - 1), at_ns);
  }
  return std::nullopt;
}

/// Positions count from the start, and derivatives are by the share of the duration.
double SetpointTrail::between(const Step& from, const Step& to, std::int64_t at_ns) {
  constexpr double second = 1'000'000'000;
  const double duration = static_cast<double>(to.at_ns - from.at_ns) / second;
  const double u = static_cast<double>(at_ns - from.at_ns) / static_cast<double>(to.at_ns - from.at_ns);
  const double distance = to.setpoint.position - from.setpoint.position;
  const auto end_of = [&](const Step& step, double position) {
    return QuinticEnd{position, step.setpoint.velocity * duration,
                      step.setpoint.acceleration * duration * duration};
  };
  return from.setpoint.position + value_at(joining(end_of(from, 0), end_of(to, distance)), u);
}

}  // namespace inbetween
