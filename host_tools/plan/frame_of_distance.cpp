#include "host_tools/plan/frame_of_distance.hpp"

#include <cstdint>

#include "inbetween/base/bisection.hpp"

namespace inbetween {

double frame_of_distance(const Track& track, const TwoSum& distance) {
  const auto is_before = [&](double time) {
    const auto frame = static_cast<std::int32_t>(time);
    return track.distance({frame, time - frame}).minus(distance) < 0;
  };
  return bisected({0, static_cast<double>(track.frames())}, 60, is_before).high;
}

double frame_of_place(const Track& track, const PathPoint& place) {
  if (place.segment >= track.path().segment_count()) return track.frames();
  if (track.has_profile()) {
    return frame_of_distance(track, track.arc_length().distance(track.path(), place));
  }
  const auto is_before = [&](double time) {
    const auto frame = static_cast<std::int32_t>(time);
    const PathPoint point = track.locate({frame, time - frame});
    return point.segment < place.segment || (point.segment == place.segment && point.t < place.t);
  };
  return bisected({0, static_cast<double>(track.frames())}, 60, is_before).high;
}

}  // namespace inbetween
