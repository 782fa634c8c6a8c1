// The steps in which a host counts an axis.
#pragma once

#include <cmath>
#include <cstdint>

namespace inbetween {

struct StepScale {
  double steps_per_unit = 1;  ///< below 0: the host counts the other way
  std::int64_t offset = 0;    ///< what the host calls the position 0 of the axis

  [[nodiscard]] double units(double steps) const {
    return (steps - static_cast<double>(offset)) / steps_per_unit;
  }
  [[nodiscard]] double steps(double units) const {
    return units * steps_per_unit + static_cast<double>(offset);
  }
  [[nodiscard]] std::int32_t whole_steps(double units) const {
    return static_cast<std::int32_t>(std::llround(steps(units)));
  }
};

}  // namespace inbetween
