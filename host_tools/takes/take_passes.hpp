// How well several takes of one move follow it, and each other: the path accuracy and the path repeatability
// of ISO 9283.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host_tools/takes/take_measures.hpp"
#include "host_tools/takes/take_samples.hpp"

namespace inbetween {

/// At a moment, or the largest of a frame or of the whole move. In the unit of the measure.
struct PathFigures {
  /// AT: from the command to the barycentre of the passes.
  double accuracy = 0;
  /// RT: mean + 3 S of the distances l_k of the passes from their barycentre, S^2 = sum (l_k - mean)^2 /
  /// (n - 1).
  double repeatability = 0;
};

struct PathFrame {
  std::int32_t frame = 0;
  PathFigures figures;
};

/// ISO 9283:1998, 8.2 (path accuracy AT) and 8.3 (path repeatability RT), of n passes k of a path:
/// AT_p = max_i |bary_i - command_i|, RT_p = max_i (mean_i + 3 S_i).
///
/// What differs: the passes are compared at the same time of the move, and not where each crosses a plane
/// square to the path, so that being early or late along the path counts too, as it does in a picture. Their
/// number n is that of the takes, where the standard asks for 10, and load, speed and path are those of the
/// move. Angles are left out: an axis that turns has figures of its own. What the standard does not have, and
/// is computed the same way: those of single axes, in their units, and those of the picture, of the images of
/// each mark (LensView::marks of the commanded posture), the largest of the marks counting.
struct PathReport {
  struct Of {
    Measure measure;  ///< of kind axis, distance or picture
    PathFigures largest = {};
    FrameTime accuracy_at = {}, repeatability_at = {};
    /// How far a pass may be from where interpolation puts it, estimated as in TakeComparison at the place of
    /// `accuracy_at`; 0 where all takes have samples at the same times.
    double interpolation = 0;
    std::vector<PathFrame> frames = {};  ///< in their order
  };
  std::vector<std::int64_t> takes = {};  ///< their numbers
  std::int64_t places = 0;    ///< that were measured: where the first take leads on and all others were too
  std::int64_t left_out = 0;  ///< where the first leads on and another was not
  std::vector<Of> measures = {};
};

/// All takes are of one move, and `measures` of their rig. The places are those of the first take (TakeLine);
/// the others are interpolated there. A picture is infinite where a pass does not see a mark. Throws
/// std::runtime_error, one line, for fewer than two takes, for other axes, where they have no place in
/// common, and as RigMeasures::poses(). O(samples * takes * (log samples + joints + axes)).
PathReport path_report(std::span<const TakeSamples> takes, const RigMeasures& measures);

}  // namespace inbetween
