#include "host_tools/free_axes.hpp"

namespace inbetween {

FreeAxisLimits<double> free_limits_of(const RigAxis& axis, double share) {
  const double acceleration = share * axis.max_acceleration;
  return {.velocity = share * axis.max_velocity,
          .acceleration = acceleration,
          .jerk = axis.max_jerk ? share * *axis.max_jerk : acceleration / seconds_to_acceleration,
          .min = axis.min,
          .max = axis.max};
}

}  // namespace inbetween
