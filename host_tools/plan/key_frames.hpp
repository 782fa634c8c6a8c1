// When the keys of a track are met.
#pragma once

#include <cstddef>
#include <vector>

#include "host_tools/plan/plan.hpp"

namespace inbetween {

/// The frame of each key of track `index`, between whole frames too, in the order of the keys; of a closed
/// path also that of its return to key 0, which is the last. A locked key is on its own frame. O(keys log N).
std::vector<double> key_frames_of(const Plan& plan, std::size_t index);

}  // namespace inbetween
