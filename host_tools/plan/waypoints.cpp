#include "host_tools/plan/waypoints.hpp"

#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "inbetween/path/standstills.hpp"

namespace inbetween {
namespace {

/// Below this share of the curvature a tangent is rounding.
template <Precise Real>
constexpr double still_share = std::numeric_limits<Real>::digits > 30 ? 1e-9 : 1e-5;
/// Between two unit directions: less is rounding.
template <Precise Real>
constexpr double corner_size = std::numeric_limits<Real>::digits > 30 ? 1e-6 : 1e-3;

using Direction = std::vector<double>;

double length_of(const Direction& v) {
  double sum = 0;
  for (const double x : v) sum = std::hypot(sum, x);
  return sum;
}

/// The unit direction in which a segment is left (t = 1) or entered (t = 0); nothing for one without length.
template <Precise Real>
std::optional<Direction> direction_of(const Path<Real>& path, std::int32_t segment, bool leaving) {
  const Real t = leaving ? 0 : 1;
  Direction first;
  Direction second;
  Direction third;
  for (std::size_t d = 0; d < path.weights().size(); ++d) {
    const Cubic<Real>& cubic = path.segment(segment)[d];
    const auto weight = static_cast<double>(path.weights()[d]);
    first.push_back(weight * static_cast<double>(cubic.derivative(t)));
    second.push_back(weight * static_cast<double>(cubic.second(t)) *
                     (leaving ? 1 : -1));  // P' is about P'' (t - t0)
    third.push_back(weight * static_cast<double>(cubic.third()));
  }
  const double higher = length_of(second) + length_of(third);
  Direction& shown = length_of(first) > still_share<Real> * higher              ? first
                     : length_of(second) > still_share<Real> * length_of(third) ? second
                                                                                : third;
  const double length = length_of(shown);
  if (!(length > 0)) return std::nullopt;
  for (double& x : shown) x /= length;
  return shown;
}

template <Precise Real>
bool is_corner(const Direction& arriving, const Direction& leaving) {
  Direction change;
  for (std::size_t d = 0; d < leaving.size(); ++d) change.push_back(leaving[d] - arriving[d]);
  return length_of(change) > corner_size<Real>;
}

/// The key at which a segment begins, or the last before it. The end of a closed path counts on.
template <Precise Real>
std::int32_t key_before(const Path<Real>& path, std::int32_t segment) {
  if (path.knots().empty()) return segment;
  if (segment == path.segment_count()) return path.knots().back().key + 1;
  return path.knots()[static_cast<std::size_t>(segment)].key;
}

}  // namespace

template <Precise Real>
std::vector<Waypoint> waypoints_of(const Track<Real>& track) {
  const Path<Real>& path = track.path();
  const ArcLength<Real>& lengths = track.arc_length();
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
      const bool turns = is_corner<Real>(*arriving, *leaving);
      for (std::size_t k = first_of_place; k < waypoints.size(); ++k) waypoints[k].is_corner = turns;
    }
    const Standstills<Real> turns = standstills_within(path, i);
    for (std::size_t k = 0; k < turns.count; ++k) {
      const auto distance = static_cast<double>(lengths.distance(path, {i, turns.t[k]}).high);
      // One that is a key but for rounding has been seen there.
      const double rounding = still_share<Real> * static_cast<double>(lengths.total());
      const auto begin = static_cast<double>(lengths.segment_begin(i).high);
      const auto end = static_cast<double>(lengths.segment_begin(i + 1).high);
      if (distance - begin <= rounding || end - distance <= rounding) continue;
      waypoints.push_back(
          {.distance = distance, .key = key, .segment = i, .is_key = false, .is_corner = true});
    }
    arriving = direction_of(path, i, false);
  }
  if (path.closed() && arriving) waypoints.front().is_corner = is_corner<Real>(*arriving, *first_leaving);
  return waypoints;
}

template std::vector<Waypoint> waypoints_of(const Track<double>&);
template std::vector<Waypoint> waypoints_of(const Track<float>&);

}  // namespace inbetween
