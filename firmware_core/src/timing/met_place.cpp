#include "timing/met_place.hpp"

namespace inbetween {

double frame_of_segment(const Track& track, std::int32_t segment) {
  const std::int32_t segments = track.path().segment_count();
  if (segment >= segments) return static_cast<double>(segments == 0 ? 0 : track.frames());
  if (!track.has_profile()) {
    const FrameTime begin = track.key_intervals()[static_cast<std::size_t>(segment)].begin_time();
    return static_cast<double>(begin.frame) + begin.fraction;
  }
  std::int32_t next = segment;
  while (next < segments && !has_length(track, next)) ++next;
  if (segment == 0) return 0;
  if (next >= segments) return static_cast<double>(track.frames());
  return frame_of(track, find_distance(track, track.arc_length().segment_begin(segment)).place);
}

}  // namespace inbetween
