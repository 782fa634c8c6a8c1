#include "host_tools/motions/transit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host_tools/motions/free_axes.hpp"
#include "host_tools/plan/move_rolls.hpp"
#include "host_tools/rig_model/rig_motors.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {
namespace {

/// The line from 0 to 1 as an axis, whose limits are the lowest that any axis leaves it.
FreeAxis line_along(const RigFile& rig, std::span<const GoTarget> targets, std::span<const double> actual,
                    double share) {
  constexpr double none = std::numeric_limits<double>::infinity();
  FreeAxisLimits along{
      .velocity = none, .acceleration = none, .jerk = none, .min = 0, .max = 1, .stop_share = none};
  for (const GoTarget& target : targets) {
    const RigAxis& axis = rig.axes[target.axis];
    const FreeAxisLimits slow = free_limits_of(axis, share);
    const AxisLimits limits = limits_of(slow_enough_everywhere(axis));
    const double distance = std::fabs(target.position - actual[target.axis]);
    along.velocity = std::min(along.velocity, slow.velocity / distance);
    along.acceleration = std::min(along.acceleration, slow.acceleration / distance);
    along.jerk = std::min(along.jerk, slow.jerk / distance);
    along.stop_share = std::min(along.stop_share, limits.stop_acceleration() / slow.acceleration);
    if (limits.stop_jerk()) along.stop_share = std::min(along.stop_share, *limits.stop_jerk() / slow.jerk);
  }
  return value_or_refuse(FreeAxis::make(along, 0, 1.0 / rig.rate_hz), {rig.path, 0, 0},
                         "the axes cannot be moved");
}

}  // namespace

std::string remedy_outside(const RigFile& rig, std::size_t axis, double position,
                           const std::string& as_arguments) {
  const RigAxis& of = rig.axes[axis];
  return fmt::format("bring it in with inbetween goto --rig {}{} {}={:.15g}", rig.path, as_arguments, of.name,
                     position < of.min ? of.min : of.max);
}

Transit::Transit(const RigFile& rig, std::span<const GoTarget> targets, std::span<const double> actual,
                 double share)
    : rig_(rig), share_(share), along_(line_along(rig, targets, actual, share)) {
  for (const GoTarget& target : targets) {
    axes_.push_back(target.axis);
    limits_.push_back(limits_of(slow_enough_everywhere(rig.axes[target.axis])));
    from_.push_back(actual[target.axis]);
    to_.push_back(target.position);
  }
  value_or_refuse(along_.go_to(1), {rig.path, 0, 0});
  for (FreeAxis tried = along_; !tried.is_resting(); ++ticks_) tried.tick();
}

void Transit::tick(std::int64_t /*now_ns*/, std::span<Setpoint> out) {
  const Setpoint along = along_.tick();
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const double distance = to_[i] - from_[i];
    out[i] = {.position = along.position == 1 ? to_[i] : from_[i] + distance * along.position,
              .velocity = distance * along.velocity,
              .acceleration = distance * along.acceleration};
  }
}

FreeSpec Transit::loop_spec() {
  return {
      .source = source_of(*this), .drive_of = axes_, .limits = limits_, .tick_seconds = 1.0 / rig_.rate_hz};
}

std::string Transit::describe(const std::string& title) const {
  std::string words = title;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const RigAxis& axis = rig_.axes[axes_[i]];
    const auto [from, to] = told_apart(from_[i], to_[i], Digits::decimals, 3);
    words += fmt::format("\n  {:<16}{:>12} -> {} {}", axis.name, from, to, to_string(axis.unit));
  }
  return words + fmt::format("\nit goes there in {:.1f} s, at {:g} % of its limits at most",
                             static_cast<double>(ticks_) / rig_.rate_hz, share_ * 100);
}

}  // namespace inbetween
