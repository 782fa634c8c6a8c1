// How a take differs from another.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host_tools/takes/error_figures.hpp"
#include "host_tools/takes/take_measures.hpp"
#include "host_tools/takes/take_samples.hpp"

namespace inbetween {

/// The second take less the first at the same place of the time line, at every place where the second leads
/// on (TakeLine). Where the first has no sample at that very time it is interpolated.
struct TakeComparison {
  struct Of {
    Measure measure;
    MeasuredErrors errors = {};
    /// How much interpolation may have added to the worst or hidden, estimated (TakeLine); 0 where both takes
    /// have samples at the same times. Of a tip and a picture: the sum of what each axis would do to it,
    /// moved by its own, at the worst place.
    double interpolation = 0;
  };
  std::int64_t first = 0;  ///< numbers of the takes
  std::int64_t second = 0;
  std::int64_t places = 0;        ///< that were compared
  std::int64_t only_second = 0;   ///< that the first take does not have
  std::vector<Of> measures = {};  ///< in the order of RigMeasures::all()
};

/// `measures` are those of the rig of both. The picture's marks are those of the first.
/// A place is at rest where all axes that move the measure rest in the second. Throws std::runtime_error, one
/// line, where the two have other axes, or no time in common, and as RigMeasures::poses().
/// O(samples * (log samples + joints + axes)).
TakeComparison compare_takes(const TakeSamples& first, const TakeSamples& second,
                             const RigMeasures& measures);

/// "take 4 differs from take 1 by at most 0.18 mm, 2.1 px, at frame 96". On a rig with tips the largest of
/// its distances and pictures; on any other the largest of the axes of each unit. Measures whose worst are on
/// different frames each have their own: "0.18 mm at frame 96, 2.1 px at frame 97". "take 4 was where take 1
/// was, to the last count" where nothing differs.
std::string in_one_sentence(const TakeComparison& comparison);

}  // namespace inbetween
