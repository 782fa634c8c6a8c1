// An axis moves by a stated distance, somebody measures it, and the factor of its scale follows.
#pragma once

#include <string>

#include "host_tools/cli/setup_arguments.hpp"

namespace inbetween {

struct MeasureArguments {
  std::string axis;
  double distance = 0;  ///< in the unit of the axis, not 0
  double share = 0.1;   ///< of its limits
  bool yes = false;     ///< somebody has agreed
};

/// By what the scale of an axis is wrong that was told to go `distance` and was measured to go `measured`,
/// and what to write; or that it is right.
std::string scale_in_words(const RigAxis& axis, double distance, double measured);

/// Moves the axis, asks on standard error how far it went, reads the answer from standard input, and prints
/// by what its scale is wrong. Returns the exit status. Throws InputError where the answer is no length, and
/// what go_by throws.
int measure_scale(const SetupArguments& setup, const MeasureArguments& arguments);

}  // namespace inbetween
