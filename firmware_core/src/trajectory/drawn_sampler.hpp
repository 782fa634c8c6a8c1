#pragma once

#include <cstddef>
#include <span>

#include "inbetween/trajectory/sampler.hpp"
#include "path/segment_speed.hpp"

/// What a TrackSampler knows of a track at a drawn speed whose path has length.

namespace inbetween {

/// Where the motion is: on the curve, with the constant that holds there, and on the path (a segment below 0:
/// by the distance).
struct DrawnPlace {
  CurvePlace curve;
  double constant = 0;
  PathPoint point;
};

/// What is worked out of a segment of the path once, and holds for every moment on it.
struct SampledSegment {
  std::int32_t segment = -1;
  SegmentSpeed speed;
  bool is_line = false;
};

SampledSpeed sample_drawn(const Track& track, const FrameTime& time, const DrawnPlace& place, bool arriving,
                          SampledSegment& known, std::span<AxisMotion> out);
/// Between joints.
SampledSpeed sample_drawn(const Track& track, const FrameTime& time, SampledSegment& known,
                          std::span<AxisMotion> out);

/// How far from its position at a point every axis is within so much of the distance along the path.
void write_reach_along(const Track& track, const PathPoint& point, double offset, std::span<double> out);

/// Whether the acceleration of an axis has no bound beside a point at which the path stands still.
bool has_unbounded_turn(const Track& track, const PathPoint& point, std::size_t axis);

std::size_t max_drawn_joints(const Track& track);
/// In their order; none where the memory is too small.
std::span<const SampledJoint> drawn_joints(const Track& track, std::span<SampledJoint> memory);

}  // namespace inbetween
