#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "inbetween/limits/motor_trajectory.hpp"
#include "inbetween/trajectory/fit.hpp"

/// The core's trajectory with memory from the heap, as large as it needs to be.

namespace inbetween {

/// Room for one trajectory at a time. Most of it is not touched, so it is not set to 0.
class TrajectoryRoom {
 public:
  /// It grows to at least this: for so many joints and axes, and so many pieces. Of cubics in time, which are
  /// no more than the stretches between joints, no side is unbounded.
  void reserve(std::size_t joints, std::size_t axes, std::size_t pieces, bool is_cubic = false);
  /// Twice as many pieces.
  void grow() { reserve(joints_, axes_, 2 * pieces_); }
  [[nodiscard]] TrajectoryMemory memory();

 private:
  [[nodiscard]] std::size_t value_count() const { return 4 * axes_ * (pieces_ + joints_); }

  std::size_t joints_ = 0;
  std::size_t axes_ = 0;
  std::size_t pieces_ = 0;
  std::unique_ptr<TrajectoryPiece[]> piece_memory_;
  std::unique_ptr<double[]> values_;
  std::unique_ptr<std::uint32_t[]> buckets_;
  std::vector<TrajectoryBreak> breaks_;
  std::vector<UnboundedSide> unbounded_;
  std::vector<AxisMotion> samples_;
  std::vector<double> numbers_;
};

/// Fits one trajectory at a time: its room grows with the largest that is asked for.
class TrajectoryFitter {
 public:
  /// Holds until the next one is fitted. Throws SolverError where there are more axes than the core takes.
  Trajectory fit(const TrackSampler& sampler, const FitTolerances& tolerances = {});

 private:
  TrajectoryRoom room_;
};

/// The joints of a track in memory from the heap.
class SampledTrack {
 public:
  explicit SampledTrack(const Track& track);
  [[nodiscard]] const TrackSampler& operator*() const { return sampler_; }
  [[nodiscard]] const TrackSampler* operator->() const { return &sampler_; }

 private:
  std::vector<SampledJoint> joints_;
  TrackSampler sampler_;
};

/// The trajectory of a whole track. Its memory lives as long as this.
class FittedTrajectory {
 public:
  explicit FittedTrajectory(const Track& track) : sampled_(track), trajectory_(fitter_.fit(*sampled_)) {}
  FittedTrajectory(const FittedTrajectory&) = delete;
  FittedTrajectory& operator=(const FittedTrajectory&) = delete;

  [[nodiscard]] const Trajectory& operator*() const { return trajectory_; }
  [[nodiscard]] const Trajectory* operator->() const { return &trajectory_; }
  [[nodiscard]] const TrackSampler& sampler() const { return *sampled_; }
  /// How far an axis goes, as the fit saw it. O(joints).
  [[nodiscard]] double travel(std::size_t axis) const;
  /// What it refers to, without what is only used while it is made.
  [[nodiscard]] std::size_t bytes() const;

 private:
  SampledTrack sampled_;
  TrajectoryFitter fitter_;
  Trajectory trajectory_;
};

/// Room for the trajectory of one motor at a time.
class MotorRoom {
 public:
  /// For so many joints, and twice as many pieces.
  explicit MotorRoom(std::size_t joints);
  /// Twice as much of everything.
  void grow();
  [[nodiscard]] std::span<MotorJoint> joints() { return joints_; }
  [[nodiscard]] TrajectoryMemory memory() { return room_.memory(); }

 private:
  TrajectoryRoom room_;
  std::vector<MotorJoint> joints_;
};

/// The trajectory of a motor behind a calibration (fit_motor). Its memory lives as long as this.
class FittedMotor {
 public:
  /// Throws SolverError.
  explicit FittedMotor(const MotorSource& source);
  FittedMotor(const RollAxis& roll, const Calibration& calibration);
  FittedMotor(const FittedMotor&) = delete;
  FittedMotor& operator=(const FittedMotor&) = delete;

  [[nodiscard]] const Trajectory& operator*() const { return trajectory_; }

 private:
  MotorRoom room_;
  Trajectory trajectory_;
};

}  // namespace inbetween
