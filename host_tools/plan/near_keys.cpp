#include "host_tools/plan/near_keys.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace inbetween {
namespace {

bool goes_by_distance(const MoveTrack& track) {
  if (track.spline == Spline::linear) return false;
  if (track.space && !track.space->has_at) return false;
  return has_speed_curve(track);
}

double distance_between(const MoveTrack& track, const MoveKey& one, const MoveKey& other) {
  double squares = 0;
  // Of a link the place in the world comes first.
  const std::size_t count = track.space ? world_coordinates : one.at.size();
  for (std::size_t d = 0; d < count; ++d) {
    const double weight = track.space || track.weights.empty() ? 1 : track.weights[d];
    squares += std::pow(weight * (other.at[d] - one.at[d]), 2);
  }
  return std::sqrt(squares);
}

}  // namespace

std::vector<NearKeys> near_keys(const MoveTrack& track) {
  std::vector<NearKeys> found;
  if (!goes_by_distance(track)) return found;
  std::vector<double> distances;
  for (std::size_t k = 0; k + 1 < track.keys.size(); ++k)
    distances.push_back(distance_between(track, track.keys[k], track.keys[k + 1]));
  for (std::size_t k = 0; k < distances.size(); ++k) {
    if (distances[k] == 0) continue;
    std::optional<double> nearest;
    for (const std::size_t beside : {k - 1, k + 1}) {
      if (beside < distances.size() && distances[beside] > 0)
        nearest = std::min(distances[beside], nearest.value_or(distances[beside]));
    }
    if (nearest && *nearest >= min_times_nearer * distances[k])
      found.push_back({k, distances[k], *nearest / distances[k]});
  }
  return found;
}

}  // namespace inbetween
