// Speed curves to begin a fit with, other than the drawn one.
#pragma once

#include <span>
#include <vector>

#include "host_tools/files/rig_file.hpp"
#include "inbetween/timing/track.hpp"

namespace inbetween {

/// What a start is made for.
struct StartWishes {
  std::span<const double> values;  ///< the curve whose rests, number of values and Phi(f) are kept
  const std::vector<bool>& rests;  ///< one per value
  int refinements = 0;             ///< how often the played curve has been refined to give `values`
};

/// Rises from every rest within two spans of the drawn curve and is constant elsewhere.
std::vector<double> flat_start(const StartWishes& wishes);

/// A speed along the path that makes the acceleration across it even, proportional to 1 / sqrt(curvature)
/// (Mastin 1986, Parameterization in grid generation), nowhere above what max_velocity of the axes allows,
/// and ramped as flat_start is. Where even that speed is too slow for the frames of the move, it is the one
/// that max_velocity allows, scaled up. What falls between control values is smoothed. It does not know of
/// locked keys.
///
/// `axes` are those of the track. Cost: 64 points per segment of the path.
std::vector<double> curvature_start(const Track<double>& track, std::span<const RigAxis> axes,
                                    const StartWishes& wishes);

}  // namespace inbetween
