#include "sim/simulated_axis.hpp"

#include <algorithm>
#include <cmath>

namespace inbetween {

void SimulatedAxis::tick(double setpoint) {
  actual_ = commanded_;
  commanded_ = setpoint;
  following_error_peak_ = std::max(following_error_peak_, std::fabs(commanded_ - actual_));
}

}  // namespace inbetween
