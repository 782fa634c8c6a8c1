#include "inbetween/path/standstills.hpp"

#include "segment_speed.hpp"

namespace inbetween {

Standstills standstills_within(const Path& path, std::int32_t segment) {
  Standstills found;
  const SegmentSpeed speed(path.segment(segment), path.weights());
  if (speed.is_still()) return found;
  const AnchoredIntervals split = split_where_slow(speed);
  for (std::size_t i = 0; i < split.count; ++i) {
    const AnchoredInterval& interval = split.intervals[i];
    const bool inside = interval.anchor > 0 && interval.anchor < 1;
    if (!inside || !interval.stands_still || !interval.forward) continue;
    if (found.count < found.t.size()) found.t[found.count++] = interval.anchor;
  }
  return found;
}

}  // namespace inbetween
