#include "trajectory/framed_sampler.hpp"

#include <algorithm>
#include <cmath>

namespace inbetween {
namespace {

/// Linear kinetics and curves: the parameter goes in proportion to time.
bool is_even(const KeyInterval& interval) {
  return interval.c2 == 0 && interval.c3 == 0;
}

}  // namespace

SampledSpeed sample_framed(const Track& track, std::int32_t segment, double u, std::span<AxisMotion> out) {
  const KeyInterval& interval = track.key_intervals()[static_cast<std::size_t>(segment)];
  const std::span<const Cubic> cubics = track.path().segment(segment);
  const std::span<const Cubic> next = track.path().segment(segment + 1);
  const std::span<const double> weights = track.path().weights();
  const double t = u < 1 ? u * (interval.c1 + u * (interval.c2 + u * interval.c3)) : 1;
  const auto [first, second, third] = interval.rates(u, track.frame_rate());
  double squares = 0;
  for (std::size_t d = 0; d < out.size(); ++d) {
    const double by_t = cubics[d].derivative(t);
    const double by_t2 = cubics[d].second(t);
    // At its end the key itself, and not what the cubic before it is rounded to.
    out[d].position = u < 1 ? track.path().kept(cubics[d].value(t), segment, d) : next[d].c0;
    out[d].velocity = by_t * first;
    out[d].acceleration = by_t2 * first * first + by_t * second;
    out[d].jerk = cubics[d].third() * first * first * first + 3 * by_t2 * first * second + by_t * third;
    squares += weights[d] * out[d].velocity * weights[d] * out[d].velocity;
  }
  return {std::sqrt(squares), static_cast<std::uint8_t>(is_even(interval) ? 1 : 3)};
}

SampledSpeed sample_framed(const Track& track, const FrameTime& time, std::span<AxisMotion> out) {
  const std::span<const KeyInterval> intervals = track.key_intervals();
  const auto behind =
      std::partition_point(intervals.begin() + 1, intervals.end(),
                           [&](const KeyInterval& interval) { return interval.begin_time() <= time; });
  const auto segment = behind - intervals.begin() - 1;
  const double u = std::clamp(intervals[static_cast<std::size_t>(segment)].u(time), 0.0, 1.0);
  return sample_framed(track, static_cast<std::int32_t>(segment), u, out);
}

bool is_cubic_in_time(const Track& track) {
  // Curves over frames are. A long one is asked about for each of its stretches, and its intervals are many.
  if (track.path().over_frames()) return true;
  return std::all_of(track.key_intervals().begin(), track.key_intervals().end(), is_even);
}

std::size_t max_framed_joints(const Track& track) {
  return track.key_intervals().size() + 1;
}

std::span<const SampledJoint> framed_joints(const Track& track, std::span<SampledJoint> memory) {
  const std::span<const KeyInterval> intervals = track.key_intervals();
  if (memory.size() < max_framed_joints(track)) return {};
  for (std::size_t i = 0; i <= intervals.size(); ++i) {
    const auto segment = static_cast<std::int32_t>(i);
    SampledJoint joint;
    joint.time = i < intervals.size() ? intervals[i].begin_time() : FrameTime{track.frames(), 0};
    joint.key = track.path().key_at(segment).value_or(-1);
    joint.point_before = {segment - 1, 1};
    joint.point_after = {segment, 0};
    memory[i] = joint;
  }
  return memory.first(max_framed_joints(track));
}

}  // namespace inbetween
