#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/timing/track.hpp"

/// The steps of the motion: a corner of the path, a key at which its curvature jumps, a break in the speed, a
/// move that does not begin or end at rest. Between keys nothing steps but at a cusp, which bound_motion
/// tells.

namespace inbetween {

/// How much one axis steps, as a magnitude, in axis units and seconds.
template <Precise Real>
struct AxisStep {
  Real velocity = 0;      ///< |velocity leaving - velocity arriving|
  Real acceleration = 0;  ///< the same of the acceleration
};

/// The steps of every axis at a key, 0..segment_count (the last is the end of the move, of a closed path the
/// return to key 0), and the frame, which need not be a whole one, on which the key is met. Before key 0 and
/// behind the end the rig is at rest.
///
/// Both sides are evaluated analytically at the end of one segment and the beginning of the next. Of keys
/// that lie in one place the first has the steps and the others none. Where the path stands still at the
/// key (tension 1) and is passed at a speed, the acceleration is that along the path; across it there is no
/// bound, as bound_motion says. A key that the move comes to rest at, within what a lock promises (1e-12 of
/// the length in double, 1e-5 in single precision), is met at rest.
///
/// `out` has an entry for every axis. No allocation. Cost: a bisection in time, O(log N + axes).
template <Precise Real>
Real steps_at_key(const Track<Real>& track, std::int32_t key, std::span<AxisStep<Real>> out);

/// Bounds of the speed along the path and of its change, anywhere on a drawn curve.
template <Precise Real>
struct PaceBounds {
  Real speed = 0;         ///< unit/s
  Real acceleration = 0;  ///< unit/s^2, of the magnitude
};

/// Those of a track; infinite if it has no drawn curve, or breaks. O(f).
template <Precise Real>
PaceBounds<Real> pace_bounds(const Track<Real>& track);

/// Bounds of what steps_at_key() finds, without looking for the time: of the steps that the path alone makes,
/// taken at the fastest pace. Infinite at both ends, and where several keys lie in one place. O(axes), a
/// fifth of the cost.
template <Precise Real>
void bound_steps_at_key(const Track<Real>& track, std::int32_t key, const PaceBounds<Real>& pace,
                        std::span<AxisStep<Real>> out);

/// The motion of every axis with which a track leaves a frame or, `arriving`, comes to it: position, velocity
/// and acceleration; no jerk. The two differ where a key on which the motion steps is met on that frame,
/// within what a lock promises. Of frame 0 and N the inner side. A track that rests there has no velocity and
/// no acceleration. `out` has an entry for every axis. O(axes), no allocation.
template <Precise Real>
void motion_beside(const Track<Real>& track, std::int32_t frame, bool arriving,
                   std::span<AxisMotion<Real>> out);

/// The standstills of the path, P' = 0, between the keys of a segment: there a drawn speed turns its
/// direction round. At most two. None in a move timed by frames, whose parameter passes such a point
/// smoothly.
template <Precise Real>
struct Standstills {
  std::array<Real, 2> t{};
  std::size_t count = 0;
};
template <Precise Real>
Standstills<Real> standstills_within(const Track<Real>& track, std::int32_t segment);

/// As steps_at_key, at a standstill of standstills_within. The acceleration is that along the path.
template <Precise Real>
Real steps_at_standstill(const Track<Real>& track, const PathPoint<Real>& point,
                         std::span<AxisStep<Real>> out);

}  // namespace inbetween
