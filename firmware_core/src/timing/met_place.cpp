#include "timing/met_place.hpp"

namespace inbetween {

template <Precise Real>
Real frame_of_segment(const Track<Real>& track, std::int32_t segment) {
  const std::int32_t segments = track.path().segment_count();
  if (segment >= segments) return static_cast<Real>(segments == 0 ? 0 : track.frames());
  if (!track.has_profile()) return track.key_intervals()[static_cast<std::size_t>(segment)].begin();
  std::int32_t next = segment;
  while (next < segments && !has_length(track, next)) ++next;
  if (segment == 0) return 0;
  if (next >= segments) return static_cast<Real>(track.frames());
  return frame_of(track, find_distance(track, track.arc_length().segment_begin(segment)).place);
}

template double frame_of_segment(const Track<double>&, std::int32_t);
template float frame_of_segment(const Track<float>&, std::int32_t);

}  // namespace inbetween
