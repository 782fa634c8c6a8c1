#include "host_tools/motions/free_axes.hpp"

#include "host_tools/rig_model/rig_motors.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

FreeAxisLimits free_limits_of(const RigAxis& of, double share) {
  const RigAxis axis = slow_enough_everywhere(of);
  const double acceleration = share * axis.max_acceleration;
  return {.velocity = share * axis.max_velocity,
          .acceleration = acceleration,
          .jerk = axis.max_jerk ? share * *axis.max_jerk : acceleration / seconds_to_acceleration,
          .min = axis.min,
          .max = axis.max};
}

FreeAxis free_axis_of(const RigAxis& axis, const FreeAxisLimits& limits, double position,
                      double tick_seconds) {
  return value_or_refuse(FreeAxis::make(limits, position, tick_seconds), axis.place,
                         named(axis) + " cannot be moved");
}

}  // namespace inbetween
