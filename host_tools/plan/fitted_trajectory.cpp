#include "host_tools/plan/fitted_trajectory.hpp"

#include <algorithm>

#include "host_tools/plan/solved_track.hpp"

namespace inbetween {
namespace {

/// Pieces between two joints at first: most stretches take less.
constexpr std::size_t usual_pieces = 8;

template <class T>
void grow(std::vector<T>& memory, std::size_t size) {
  if (memory.size() < size) memory.resize(size);
}

}  // namespace

Trajectory TrajectoryFitter::fit(const TrackSampler& sampler, const FitTolerances& tolerances) {
  make_room_for(sampler);
  while (true) {
    const Result<Trajectory> fitted = fit_trajectory(
        sampler, tolerances, {pieces_, values_, buckets_, breaks_, unbounded_, samples_, numbers_});
    if (fitted) return *fitted;
    // What it needed when it gave up is not yet all: at least twice as much, so that few tries are made.
    const bool may_grow =
        fitted.error().code == ErrorCode::capacity && sampler.axis_count() <= max_trajectory_axes;
    if (!may_grow) throw SolverError(fitted.error());
    pieces_.resize(2 * pieces_.size());
    values_.resize(2 * values_.size());
    buckets_.resize(pieces_.size());
  }
}

void TrajectoryFitter::make_room_for(const TrackSampler& sampler) {
  const std::size_t joints = sampler.joints().size();
  const std::size_t axes = sampler.axis_count();
  grow(pieces_, usual_pieces * joints);
  grow(values_, usual_pieces * joints * 4 * axes);
  grow(buckets_, pieces_.size());
  grow(breaks_, joints);
  grow(unbounded_, 3 * joints * axes);  // either side, and between two joints
  grow(samples_, 3 * axes);
  grow(numbers_, 5 * axes);
}

SampledTrack::SampledTrack(const Track<double>& track)
    : joints_(max_joints(track)), sampler_(value_or_throw(TrackSampler::make(track, joints_))) {}

std::size_t FittedTrajectory::bytes() const {
  return trajectory_.pieces().size_bytes() + trajectory_.values().size_bytes() +
         trajectory_.breaks().size_bytes() + trajectory_.unbounded().size_bytes() +
         trajectory_.pieces().size() * sizeof(std::uint32_t);
}

}  // namespace inbetween
