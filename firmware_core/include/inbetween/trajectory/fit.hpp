#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/base/result.hpp"
#include "inbetween/trajectory/sampler.hpp"
#include "inbetween/trajectory/trajectory.hpp"

/// From a motion that can be asked at any time to the trajectory that is played.

namespace inbetween {

inline constexpr std::size_t max_trajectory_axes = 64;

/// How near what is played comes to what is asked, between joints.
struct FitTolerances {
  double position_share = 1.0 / (1 << 30);  ///< of what the axis travels
  double speed_share = 1e-6;                ///< of the drawn speed at that moment
  /// This says what each axis travels; where it is empty, the joints of the sampler say it. A stretch of a
  /// motion has the same pieces as in the whole only with what the whole travels.
  std::span<const double> travel = {};
};

/// Memory for a trajectory of up to `Axes` axes, `Pieces` pieces and `Breaks` breaks, and as many unbounded
/// sides as breaks and what lies between them have.
template <std::size_t Axes, std::size_t Pieces, std::size_t Breaks>
struct TrajectoryStorage {
  std::array<TrajectoryPiece, Pieces> pieces;
  std::array<double, (Pieces + Breaks + 1) * 4 * Axes> values;
  std::array<std::uint32_t, Pieces> buckets;
  std::array<TrajectoryBreak, Breaks> breaks;
  std::array<UnboundedSide, 3 * Breaks * Axes> unbounded;
  std::array<AxisMotion, 3 * Axes> samples;
  std::array<double, fit_numbers * Axes> numbers;

  [[nodiscard]] TrajectoryMemory memory() {
    return {pieces, values, buckets, breaks, unbounded, samples, numbers};
  }
};

/// How far each axis goes, by the joints and the middles between them. `samples` has an entry for each axis.
void measure_travel(const TrackSampler& sampler, std::span<AxisMotion> samples, std::span<double> out);

/// The trajectory of a sampled motion. Each stretch between two joints is halved until the Hermite polynomial
/// of its ends is within the tolerances: so says the error of a septic and its three derivatives in the
/// middle, from which it follows elsewhere (Hermite's remainder), and where the speed changes much, and of
/// other degrees, a look at up to four places inside. A stretch that is a cubic is taken as it is, and one at
/// rest is a constant. What turns too sharply for the shortest piece is a line there, and the acceleration of
/// that axis is noted as unbounded.
///
/// Errors: capacity (pieces, values, breaks, unbounded, samples, numbers, axes); of pieces and values what it
/// needed when it gave up, which may not be enough. Cost: about two samples a piece.
Result<Trajectory> fit_trajectory(const TrackSampler& sampler, const FitTolerances& tolerances,
                                  const TrajectoryMemory& memory);

}  // namespace inbetween
