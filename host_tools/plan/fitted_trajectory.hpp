#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "inbetween/trajectory/fit.hpp"

/// The core's trajectory with memory from the heap, as large as it needs to be.

namespace inbetween {

/// Memory for one trajectory at a time: it grows with the largest that is asked for.
class TrajectoryFitter {
 public:
  /// Holds until the next one is fitted. Throws SolverError where there are more axes than the core takes.
  Trajectory fit(const TrackSampler& sampler, const FitTolerances& tolerances = {});

 private:
  void make_room_for(const TrackSampler& sampler);

  std::vector<TrajectoryPiece> pieces_;
  std::vector<double> values_;
  std::vector<std::uint32_t> buckets_;
  std::vector<TrajectoryBreak> breaks_;
  std::vector<UnboundedSide> unbounded_;
  std::vector<AxisMotion<double>> samples_;
  std::vector<double> numbers_;
};

/// The joints of a track in memory from the heap.
class SampledTrack {
 public:
  explicit SampledTrack(const Track<double>& track);
  [[nodiscard]] const TrackSampler& operator*() const { return sampler_; }
  [[nodiscard]] const TrackSampler* operator->() const { return &sampler_; }

 private:
  std::vector<SampledJoint> joints_;
  TrackSampler sampler_;
};

/// The trajectory of a whole track. Its memory lives as long as this.
class FittedTrajectory {
 public:
  explicit FittedTrajectory(const Track<double>& track)
      : sampled_(track), trajectory_(fitter_.fit(*sampled_)) {}
  FittedTrajectory(const FittedTrajectory&) = delete;
  FittedTrajectory& operator=(const FittedTrajectory&) = delete;

  [[nodiscard]] const Trajectory& operator*() const { return trajectory_; }
  [[nodiscard]] const Trajectory* operator->() const { return &trajectory_; }
  [[nodiscard]] const TrackSampler& sampler() const { return *sampled_; }
  /// What it refers to, without what is only used while it is made.
  [[nodiscard]] std::size_t bytes() const;

 private:
  SampledTrack sampled_;
  TrajectoryFitter fitter_;
  Trajectory trajectory_;
};

}  // namespace inbetween
