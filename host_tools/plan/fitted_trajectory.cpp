#include "host_tools/plan/fitted_trajectory.hpp"

#include <algorithm>

#include "host_tools/plan/solved_track.hpp"

namespace inbetween {
namespace {

/// Pieces between two joints at first: most stretches take less.
constexpr std::size_t usual_pieces = 8;
/// Joints of a motor beside the pieces of its axis at first: most marks are passed a few times.
constexpr std::size_t usual_passings = 64;

/// The room grows until the fit has enough of it. What a fit needed when it gave up is not yet all: a room
/// grows to twice as much, so that few tries are made.
Trajectory fitted(auto& room, std::size_t axes, const auto& fit) {
  while (true) {
    const Result<Trajectory> result = fit();
    if (result) return *result;
    const bool may_grow = result.error().code == ErrorCode::capacity && axes <= max_trajectory_axes;
    if (!may_grow) throw SolverError(result.error());
    room.grow();
  }
}

}  // namespace

void TrajectoryRoom::reserve(std::size_t joints, std::size_t axes, std::size_t pieces, bool is_cubic) {
  if (joints <= joints_ && axes <= axes_ && pieces <= pieces_) return;
  joints_ = std::max(joints_, joints);
  axes_ = std::max(axes_, axes);
  pieces_ = std::max(pieces_, pieces);
  piece_memory_ = std::make_unique_for_overwrite<TrajectoryPiece[]>(pieces_);
  values_ = std::make_unique_for_overwrite<double[]>(value_count());
  buckets_ = std::make_unique_for_overwrite<std::uint32_t[]>(pieces_);
  breaks_.resize(joints_);
  if (!is_cubic) unbounded_.resize(3 * joints_ * axes_);  // either side, and between two joints
  samples_.resize(3 * axes_);
  numbers_.resize(fit_numbers * axes_);
}

TrajectoryMemory TrajectoryRoom::memory() {
  return {.pieces = {piece_memory_.get(), pieces_},
          .values = {values_.get(), value_count()},
          .buckets = {buckets_.get(), pieces_},
          .breaks = breaks_,
          .unbounded = unbounded_,
          .samples = samples_,
          .numbers = numbers_};
}

Trajectory TrajectoryFitter::fit(const TrackSampler& sampler, const FitTolerances& tolerances) {
  const std::size_t joints = sampler.joints().size();
  const bool is_cubic = sampler.is_cubic();
  room_.reserve(joints, sampler.axis_count(), is_cubic ? joints : usual_pieces * joints, is_cubic);
  return fitted(room_, sampler.axis_count(),
                [&] { return fit_trajectory(sampler, tolerances, room_.memory()); });
}

MotorRoom::MotorRoom(std::size_t joints) : joints_(joints) {
  room_.reserve(joints_.size(), 1, 2 * joints_.size());
}

void MotorRoom::grow() {
  joints_.resize(2 * joints_.size());
  room_.reserve(joints_.size(), 1, 2 * joints_.size());
}

FittedMotor::FittedMotor(const MotorSource& source)
    : room_(source.trajectory->pieces().size() + usual_passings),
      trajectory_(fitted(room_, 1, [&] { return fit_motor(source, room_.joints(), room_.memory()); })) {}

FittedMotor::FittedMotor(const RollAxis& roll, const Calibration& calibration)
    : room_(usual_passings),
      trajectory_(
          fitted(room_, 1, [&] { return fit_motor(roll, calibration, room_.joints(), room_.memory()); })) {}

SampledTrack::SampledTrack(const Track& track)
    : joints_(max_joints(track)), sampler_(value_or_throw(TrackSampler::make(track, joints_))) {}

double FittedTrajectory::travel(std::size_t axis) const {
  const std::size_t axes = sampled_->axis_count();
  std::vector<AxisMotion> samples(axes);
  std::vector<double> travel(axes);
  measure_travel(*sampled_, samples, travel);
  return travel[axis];
}

std::size_t FittedTrajectory::bytes() const {
  return trajectory_.pieces().size_bytes() + trajectory_.values().size_bytes() +
         trajectory_.breaks().size_bytes() + trajectory_.unbounded().size_bytes() +
         trajectory_.pieces().size() * sizeof(std::uint32_t);
}

}  // namespace inbetween
