// Speed curves from which a fit may begin, beside the drawn one.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "host_tools/fit/fitted_track.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "inbetween/timing/track.hpp"

namespace inbetween {

/// The properties that a start shall have.
struct StartRequest {
  std::span<const double> values;  ///< the curve whose rests, number of values and Phi(f) are kept
  const std::vector<bool>& rests;  ///< one per value
  int refinements = 0;             ///< how often the played curve has been refined to give `values`
  CurveEnds ends = CurveEnds::natural;
};

/// Rises from every rest within two spans of the drawn curve and is constant elsewhere.
std::vector<double> flat_start(const StartRequest& request);

/// A speed along the path, proportional to 1 / sqrt(curvature), that makes the acceleration across the path
/// even (Mastin 1986, Parameterization in grid generation). It is nowhere above the max_velocity of an axis,
/// and is ramped as flat_start is. If that speed is too slow for the frames of the move, it is the fastest
/// that max_velocity allows, scaled up. The curve smooths what falls between control values. It does not take
/// locked keys into account.
///
/// `axes` are those of the track. Cost: 64 points per segment of the path.
std::vector<double> curvature_start(const Track& track, std::span<const RigAxis> axes,
                                    const StartRequest& request);

/// The track with a speed curve that shares out the frames between its eased keys as the limits need them:
/// each stretch between two keys where it rests gets frames in proportion to the time that its slowest axis
/// takes from rest to rest, with the speed of the smoothest such motion (Flash and Hogan 1985, minimum jerk).
/// Keys with a frame or a hold keep their frames. Nothing if every eased key has a frame, or if the keys have
/// no such curve.
///
/// The drawn curve says only roughly when such a key is met: it does not slow down there.
std::optional<Plan> with_eases_shared_out(const FittedTrack& fitted);

}  // namespace inbetween
