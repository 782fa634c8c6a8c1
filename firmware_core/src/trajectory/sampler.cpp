#include "inbetween/trajectory/sampler.hpp"

#include <algorithm>

#include "trajectory/drawn_sampler.hpp"
#include "trajectory/framed_sampler.hpp"

namespace inbetween {
namespace {

/// A drawn curve on a path without length: nothing moves, whatever is drawn.
bool stands(const Track& track) {
  return track.has_profile() && !(track.arc_length().total() > 0);
}

SampledSpeed sample_standing(const Track& track, std::span<AxisMotion> out) {
  for (std::size_t d = 0; d < out.size(); ++d) out[d] = {.position = track.path().segment(0)[d].c0};
  return {};
}

std::span<const SampledJoint> ends_of(const Track& track, std::span<SampledJoint> memory) {
  if (memory.size() < 2) return {};
  memory[0] = {};
  memory[0].key = 0;
  memory[1] = {};
  memory[1].time = {track.frames(), 0};
  memory[1].key = track.path().key_at(track.path().segment_count()).value_or(-1);
  return memory.first(2);
}

SampledSpeed at_joint(const Track& track, const SampledJoint& joint, const DrawnPlace& place, bool arriving,
                      std::span<AxisMotion> out) {
  SampledSegment known;
  SampledSpeed result = sample_drawn(track, joint.time, place, arriving, known, out);
  result.off = std::max(result.off, joint.passed_by);
  return result;
}

bool is_constant(std::span<const Cubic> cubics) {
  return std::all_of(cubics.begin(), cubics.end(),
                     [](const Cubic& cubic) { return cubic.c1 == 0 && cubic.c2 == 0 && cubic.c3 == 0; });
}

}  // namespace

std::size_t max_joints(const Track& track) {
  if (!track.has_profile()) return max_framed_joints(track);
  return stands(track) ? 2 : max_drawn_joints(track);
}

Result<TrackSampler> TrackSampler::make(const Track& track, std::span<SampledJoint> joints) {
  const std::span<const SampledJoint> settled = !track.has_profile() ? framed_joints(track, joints)
                                                : stands(track)      ? ends_of(track, joints)
                                                                     : drawn_joints(track, joints);
  if (settled.empty()) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the motion has more joints than its memory",
                 .remedy = "give it a larger capacity",
                 .needed = static_cast<std::int64_t>(max_joints(track))};
  }
  return TrackSampler(track, settled);
}

bool TrackSampler::is_cubic() const {
  return !track_->has_profile() && is_cubic_in_time(*track_);
}

bool TrackSampler::rests_behind(const SampledJoint& joint) const {
  if (!track_->has_profile()) {
    const std::size_t axes = axis_count();
    return is_constant(track_->path().segment(joint.point_after.segment).first(axes));
  }
  if (stands(*track_)) return true;
  const SpeedSpan& span = track_->profile().span(joint.curve_after.span);
  return span.b0 == 0 && span.b1 == 0 && span.b2 == 0 && span.b3 == 0;
}

SampledSpeed TrackSampler::sample(const FrameTime& time, std::span<AxisMotion> out) const {
  SampledSegment known;
  return sample(time, known, out);
}

SampledSpeed TrackSampler::sample(const FrameTime& time, SampledSegment& known,
                                  std::span<AxisMotion> out) const {
  if (!track_->has_profile()) return sample_framed(*track_, time, out);
  if (stands(*track_)) return sample_standing(*track_, out);
  return sample_drawn(*track_, time, known, out);
}

SampledSpeed TrackSampler::arriving(const SampledJoint& joint, std::span<AxisMotion> out) const {
  if (!track_->has_profile()) return sample_framed(*track_, joint.point_before.segment, 1, out);
  if (stands(*track_)) return sample_standing(*track_, out);
  const DrawnPlace place{joint.curve_before, joint.constant_before, joint.point_before};
  return at_joint(*track_, joint, place, true, out);
}

SampledSpeed TrackSampler::leaving(const SampledJoint& joint, std::span<AxisMotion> out) const {
  if (!track_->has_profile()) return sample_framed(*track_, joint.point_after.segment, 0, out);
  if (stands(*track_)) return sample_standing(*track_, out);
  const DrawnPlace place{joint.curve_after, joint.constant_after, joint.point_after};
  return at_joint(*track_, joint, place, false, out);
}

void TrackSampler::write_reach(const PathPoint& point, double offset, std::span<double> out) const {
  write_reach_along(*track_, point, offset, out);
}

std::uint8_t TrackSampler::unbounded_order(const SampledJoint&, const SampledSpeed& known,
                                           std::size_t axis) const {
  // At rest what comes to a standstill has bounds.
  if (known.order >= 3 || known.speed == 0) return 0;
  // Where the path stands still, an axis that does not count along it may have a distance to go.
  if (known.order == 0 && !(weight(axis) > 0)) return 1;
  return track_->has_profile() && has_unbounded_turn(*track_, known.point, axis) ? 2 : 0;
}

}  // namespace inbetween
