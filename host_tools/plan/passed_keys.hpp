// Keys that a track passes and does not meet, because its corners are rounded.
#pragma once

#include <cstddef>
#include <cstdio>
#include <string_view>
#include <vector>

#include "host_tools/plan/plan.hpp"

namespace inbetween {

/// A key beside which the path goes by.
struct PassedKey {
  std::size_t key = 0;
  double frame = 0;                 // of its own with an overlap, otherwise when the path is nearest to it
  std::vector<double> missed = {};  // of each axis, in its unit: where the path is then, less the key
  double distance = 0;              // of that, as the weights of the axes count
  double tolerance = 0;             // what `round` allows; 0 with an overlap
};

/// In the order of the keys, without those that are met. O(keys * axes).
std::vector<PassedKey> passed_keys(const Plan& plan, std::size_t track);

/// Prints them, a line each: by how much an axis or the path misses the key, and where the legs of a corner
/// are too short for its `round`, that. A long track has its worst keys alone.
void print_passed(const Plan& plan, std::size_t track, std::string_view indent, std::FILE* out);

}  // namespace inbetween
