#include "inbetween/trajectory/fit.hpp"

#include "trajectory/drawn_sampler.hpp"
#include "trajectory/trajectory_builder.hpp"

namespace inbetween {

static_assert(fit_numbers == row_numbers + SampledRows<TrackSampler>::numbers + judging::numbers);

void measure_travel(const TrackSampler& sampler, std::span<AxisMotion> samples, std::span<double> out) {
  judging::measure_travel(sampler, samples, out);
}

Result<Trajectory> fit_trajectory(const TrackSampler& sampler, const FitTolerances& tolerances,
                                  const TrajectoryMemory& memory) {
  return fit_sampled(sampler, tolerances, memory);
}

}  // namespace inbetween
