// A trajectory with memory from the heap, and its polynomials evaluated by definition in extended precision.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "host_tools/plan/solved_track.hpp"
#include "inbetween/trajectory/fit.hpp"

namespace inbetween {

/// The trajectory of a track at a drawn speed. Its memory lives as long as this.
class FittedTrajectory {
 public:
  explicit FittedTrajectory(const Track<double>& track, std::size_t pieces = 20'000)
      : joints_(max_joints(track)),
        pieces_(pieces),
        values_(pieces * 4 * static_cast<std::size_t>(track.path().axis_count())),
        buckets_(1024),
        breaks_(joints_.size()),
        unbounded_(2 * joints_.size() * static_cast<std::size_t>(track.path().axis_count())),
        samples_(3 * static_cast<std::size_t>(track.path().axis_count())),
        sampler_(DrawnSampler::make(track, joints_)),
        trajectory_(
            fit_trajectory(*sampler_, {}, {pieces_, values_, buckets_, breaks_, unbounded_, samples_})) {}
  FittedTrajectory(const FittedTrajectory&) = delete;
  FittedTrajectory& operator=(const FittedTrajectory&) = delete;

  [[nodiscard]] const Trajectory& operator*() const { return *trajectory_; }
  [[nodiscard]] const Trajectory* operator->() const { return &*trajectory_; }
  [[nodiscard]] const DrawnSampler& sampler() const { return *sampler_; }
  [[nodiscard]] const Result<Trajectory>& result() const { return trajectory_; }

 private:
  std::vector<SampledJoint> joints_;
  std::vector<TrajectoryPiece> pieces_;
  std::vector<double> values_;
  std::vector<std::uint32_t> buckets_;
  std::vector<TrajectoryBreak> breaks_;
  std::vector<UnboundedSide> unbounded_;
  std::vector<AxisMotion<double>> samples_;
  Result<DrawnSampler> sampler_;
  Result<Trajectory> trajectory_;
};

namespace oracle {

/// Position less that of the begin, velocity, acceleration and jerk of an axis on a piece, at u: the
/// coefficients of the polynomial come from the equations that the rows are, by elimination in long double.
inline std::array<long double, 4> hermite(const Trajectory& trajectory, const TrajectoryPiece& piece,
                                          std::size_t axis, long double u) {
  const std::size_t n = piece.degree + 1U;
  const std::size_t known = n / 2;
  const std::size_t axes = trajectory.axis_count();
  const long double h = piece.seconds;
  std::vector<std::vector<long double>> rows;
  const auto falling = [](std::size_t i, std::size_t k) {  // i (i - 1) ... (i - k + 1)
    long double product = 1;
    for (std::size_t m = 0; m < k; ++m) product *= i >= m ? static_cast<long double>(i - m) : 0;
    return product;
  };
  for (const bool is_end : {false, true}) {
    const std::size_t offset = is_end ? piece.end_row : piece.begin_row;
    long double scale = 1;
    for (std::size_t k = 0; k < known; ++k, scale *= h) {
      std::vector<long double> row(n + 1);
      for (std::size_t i = k; i < n; ++i) row[i] = is_end || i == k ? falling(i, k) : 0;
      row[n] = scale * trajectory.values()[offset + k * axes + axis];
      if (k == 0) row[n] -= trajectory.values()[piece.begin_row + axis];
      rows.push_back(row);
    }
  }
  for (std::size_t i = 0; i < n; ++i) {  // Gauss and Jordan, the largest pivot first
    std::size_t best = i;
    for (std::size_t r = i; r < n; ++r) {
      if (std::fabs(rows[r][i]) > std::fabs(rows[best][i])) best = r;
    }
    std::swap(rows[i], rows[best]);
    for (std::size_t r = 0; r < n; ++r) {
      if (r == i) continue;
      const long double factor = rows[r][i] / rows[i][i];
      for (std::size_t c = i; c <= n; ++c) rows[r][c] -= factor * rows[i][c];
    }
  }
  std::array<long double, 4> motion{};
  long double scale = 1;
  for (std::size_t k = 0; k < motion.size(); ++k, scale /= h) {
    for (std::size_t i = k; i < n; ++i)
      motion[k] +=
          scale * falling(i, k) * rows[i][n] / rows[i][i] * std::pow(u, static_cast<long double>(i - k));
  }
  return motion;
}

}  // namespace oracle
}  // namespace inbetween
