#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/trajectory/sampler.hpp"

/// What a TrackSampler knows of a track whose keys have frames.

namespace inbetween {

/// On a segment, u from 0 to 1 over its time.
SampledSpeed sample_framed(const Track& track, std::int32_t segment, double u, std::span<AxisMotion> out);
/// Between joints.
SampledSpeed sample_framed(const Track& track, const FrameTime& time, std::span<AxisMotion> out);
/// Every axis is a cubic in time on every segment.
bool is_cubic_in_time(const Track& track);

std::size_t max_framed_joints(const Track& track);
/// The knots of the path; none where the memory is too small.
std::span<const SampledJoint> framed_joints(const Track& track, std::span<SampledJoint> memory);

}  // namespace inbetween
