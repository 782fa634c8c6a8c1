#include "inbetween/path/standstills.hpp"

#include "segment_speed.hpp"

namespace inbetween {

template <Precise Real>
Standstills<Real> standstills_within(const Path<Real>& path, std::int32_t segment) {
  Standstills<Real> found;
  const SegmentSpeed<Real> speed(path.segment(segment), path.weights());
  if (speed.is_still()) return found;
  const AnchoredIntervals<Real> split = split_where_slow(speed);
  for (std::size_t i = 0; i < split.count; ++i) {
    const AnchoredInterval<Real>& interval = split.intervals[i];
    const bool inside = interval.anchor > 0 && interval.anchor < 1;
    if (!inside || !interval.stands_still || !interval.forward) continue;
    if (found.count < found.t.size()) found.t[found.count++] = interval.anchor;
  }
  return found;
}

template Standstills<double> standstills_within(const Path<double>&, std::int32_t);
template Standstills<float> standstills_within(const Path<float>&, std::int32_t);

}  // namespace inbetween
