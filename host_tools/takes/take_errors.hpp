// What a take was like against its plan.
#pragma once

#include <cstdint>
#include <vector>

#include "host_tools/takes/error_figures.hpp"
#include "host_tools/takes/take_measures.hpp"
#include "host_tools/takes/take_samples.hpp"

namespace inbetween {

/// Actual less commanded, at every sample. Of an axis that is the opposite of its following error.
struct TakeErrors {
  struct Of {
    Measure measure;
    bool is_held = false;  ///< an axis in no track: against where it was at first
    MeasuredErrors errors = {};
  };
  std::int64_t number = 0;
  std::int64_t samples = 0;
  std::vector<Of> measures = {};  ///< in the order of RigMeasures::all()
};

/// A measure is at rest where all axes that move it rest (TakeSamples::rests). The picture's marks are those
/// of the commanded posture. `measures` are those of the rig of the take. Throws as RigMeasures::poses()
/// and refuse_other_axes().
/// O(samples * (joints + axes)).
TakeErrors errors_of(const TakeSamples& samples, const RigMeasures& measures);

}  // namespace inbetween
