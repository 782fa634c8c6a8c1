#include "host_tools/plan/waypoints.hpp"

#include <cstddef>
#include <optional>

#include "host_tools/numerics/hypotenuse.hpp"
#include "inbetween/path/standstills.hpp"

namespace inbetween {
namespace {

/// Below this share of the curvature a tangent is rounding.
constexpr double still_share = 1e-9;
/// Between two unit directions: less is rounding.
constexpr double corner_size = 1e-6;

using Direction = std::vector<double>;

double length_of(const Direction& v) {
  double sum = 0;
  for (const double x : v) sum = hypotenuse(sum, x);
  return sum;
}

/// The unit direction in which a segment is left (t = 1) or entered (t = 0); nothing for one without length.
std::optional<Direction> direction_of(const Path& path, std::int32_t segment, bool leaving) {
  const double t = leaving ? 0 : 1;
  Direction first;
  Direction second;
  Direction third;
  for (std::size_t d = 0; d < path.weights().size(); ++d) {
    const Cubic& cubic = path.segment(segment)[d];
    const auto weight = static_cast<double>(path.weights()[d]);
    first.push_back(weight * cubic.derivative(t));
    second.push_back(weight * cubic.second(t) * (leaving ? 1 : -1));  // P' is about P'' (t - t0)
    third.push_back(weight * cubic.third());
  }
  const double higher = length_of(second) + length_of(third);
  Direction& shown = length_of(first) > still_share * higher              ? first
                     : length_of(second) > still_share * length_of(third) ? second
                                                                          : third;
  const double length = length_of(shown);
  if (!(length > 0)) return std::nullopt;
  for (double& x : shown) x /= length;
  return shown;
}

bool is_corner(const Direction& arriving, const Direction& leaving) {
  Direction change;
  for (std::size_t d = 0; d < leaving.size(); ++d) change.push_back(leaving[d] - arriving[d]);
  return length_of(change) > corner_size;
}

/// The key at which a segment begins, or the last before it. The end of a closed path counts on.
std::int32_t key_before(const Path& path, std::int32_t segment) {
  if (path.knots().empty()) return segment;
  if (segment == path.segment_count()) return path.knots().back().key + 1;
  return path.knots()[static_cast<std::size_t>(segment)].key;
}

}  // namespace

std::vector<Waypoint> waypoints_of(const Track& track) {
  const Path& path = track.path();
  const ArcLength& lengths = track.arc_length();
  std::vector<Waypoint> waypoints;
  std::optional<Direction> arriving;
  std::optional<Direction> first_leaving;
  std::size_t first_of_place = 0;  // of the keys in one place
  for (std::int32_t i = 0; i <= path.segment_count(); ++i) {
    const std::int32_t key = key_before(path, i);
    if (path.key_at(i)) {
      if (i == 0 || lengths.segment_begin(i).minus(lengths.segment_begin(i - 1)) > 0)
        first_of_place = waypoints.size();
      waypoints.push_back(
          {.distance = static_cast<double>(lengths.segment_begin(i).high), .key = key, .segment = i});
    }
    if (i == path.segment_count()) break;
    const std::optional<Direction> leaving = direction_of(path, i, true);
    if (!leaving) continue;
    if (!arriving) {
      first_leaving = leaving;
    } else if (path.key_at(i)) {
      const bool turns = is_corner(*arriving, *leaving);
      for (std::size_t k = first_of_place; k < waypoints.size(); ++k) waypoints[k].is_corner = turns;
    }
    const Standstills turns = standstills_within(path, i);
    for (std::size_t k = 0; k < turns.count; ++k) {
      const double distance = lengths.distance(path, {i, turns.t[k]}).high;
      // One that is a key but for rounding has been seen there.
      const double rounding = still_share * lengths.total();
      const auto begin = static_cast<double>(lengths.segment_begin(i).high);
      const auto end = static_cast<double>(lengths.segment_begin(i + 1).high);
      if (distance - begin <= rounding || end - distance <= rounding) continue;
      waypoints.push_back(
          {.distance = distance, .key = key, .segment = i, .is_key = false, .is_corner = true});
    }
    arriving = direction_of(path, i, false);
  }
  if (path.closed() && arriving) waypoints.front().is_corner = is_corner(*arriving, *first_leaving);
  return waypoints;
}

}  // namespace inbetween
