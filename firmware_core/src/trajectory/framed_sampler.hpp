#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/trajectory/sampler.hpp"

/// What a TrackSampler knows of a track whose keys have frames.

namespace inbetween {

/// On a segment, u from 0 to 1 over its time.
SampledSpeed sample_framed(const Track<double>& track, std::int32_t segment, double u,
                           std::span<AxisMotion<double>> out);
/// Between joints.
SampledSpeed sample_framed(const Track<double>& track, const FrameTime<double>& time,
                           std::span<AxisMotion<double>> out);
/// Every axis is a cubic in time on every segment.
bool is_cubic_in_time(const Track<double>& track);

std::size_t max_framed_joints(const Track<double>& track);
/// The knots of the path; none where the memory is too small.
std::span<const SampledJoint> framed_joints(const Track<double>& track, std::span<SampledJoint> memory);

}  // namespace inbetween
