#include "host_tools/motions/rig_homing.hpp"

namespace inbetween {
namespace {

constexpr double backs_to_leave = 4;

}  // namespace

HomingSpec homing_spec_of(const RigAxis& axis, const SwitchSettings& home) {
  const Home& of = *axis.home;
  const FreeAxisLimits limits = free_limits_of(axis, 1);
  const double overrun = of.fast * (of.fast / limits.acceleration + limits.acceleration / limits.jerk);
  return {.towards_max = of.direction > 0,
          .at = of.at,
          .fast = of.fast,
          .slow = of.slow,
          .search = of.search,
          .leave = overrun + backs_to_leave * of.back_off,
          .back_off = of.back_off,
          .home = home};
}

AxisHoming axis_homing_of(const RigAxis& axis, const SwitchSettings& home, FreeAxis& free) {
  return value_or_refuse(AxisHoming::make(homing_spec_of(axis, home), free), axis.home->place,
                         named(axis) + " cannot home");
}

}  // namespace inbetween
