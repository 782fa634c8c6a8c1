// Speed curves from which a fit may begin, beside the drawn one.
#pragma once

#include <span>
#include <vector>

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

}  // namespace inbetween
