#include "host_tools/scene/pose_descent.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace inbetween {
namespace {

constexpr std::size_t rows_of_pose = 6;
using PoseRows = std::array<double, rows_of_pose>;
using PoseSquare = std::array<PoseRows, rows_of_pose>;

/// By Gauss' elimination with pivots. `a` is positive definite.
PoseRows solved(PoseSquare a, PoseRows b) {
  for (std::size_t i = 0; i < rows_of_pose; ++i) {
    std::size_t pivot = i;
    for (std::size_t r = i + 1; r < rows_of_pose; ++r)
      if (std::fabs(a[r][i]) > std::fabs(a[pivot][i])) pivot = r;
    std::swap(a[i], a[pivot]);
    std::swap(b[i], b[pivot]);
    for (std::size_t r = i + 1; r < rows_of_pose; ++r) {
      const double factor = a[r][i] / a[i][i];
      for (std::size_t c = i; c < rows_of_pose; ++c) a[r][c] -= factor * a[i][c];
      b[r] -= factor * b[i];
    }
  }
  for (std::size_t i = rows_of_pose; i-- > 0;) {
    for (std::size_t c = i + 1; c < rows_of_pose; ++c) b[i] -= a[i][c] * b[c];
    b[i] /= a[i][i];
  }
  return b;
}

/// Metres, and the vector about which to turn (rad).
PoseRows missing(const Pose& found, const Pose& wanted) {
  const Vector3 place = wanted.position - found.position;
  const auto [x, y, z] = wanted.rotation * inverse(found.rotation);
  const Vector3 turn = Vector3{y.z - z.y, z.x - x.z, x.y - y.x} * 0.5;
  const double sine = std::hypot(turn.x, turn.y, turn.z);
  const double angle = std::atan2(sine, (x.x + y.y + z.z - 1) / 2);
  const Vector3 about = sine > 0 ? turn * (angle / sine) : turn;
  return {place.x, place.y, place.z, about.x, about.y, about.z};
}

double size_of(const PoseRows& rows) {
  double squares = 0;
  for (const double row : rows) squares += row * row;
  return std::sqrt(squares);
}

}  // namespace

PoseDescent::PoseDescent(const Kinematics& kinematics, std::int32_t link, std::vector<std::size_t> axes)
    : kinematics_(kinematics),
      link_(link),
      axes_(std::move(axes)),
      coordinates_(kinematics.tree().coordinate_count(), 0),
      poses_(kinematics.tree().joints().size()),
      columns_(coordinates_.size()) {}

const Pose& PoseDescent::pose(const std::vector<double>& positions) {
  for (std::size_t i = 0; i < axes_.size(); ++i) coordinates_[axes_[i]] = positions[i];
  // Beyond what can be computed the poses are those before, and the step was none.
  static_cast<void>(kinematics_.tree().poses(coordinates_, poses_));
  return poses_[static_cast<std::size_t>(link_)];
}

void PoseDescent::descend(const Pose& wanted, std::vector<double>& positions) {
  constexpr int max_steps = 100;
  // Rounding of rigs of some metres; a damping that is no part of 1 any more, and one that lets nothing move.
  constexpr double near_enough = 1e-13, least_damping = 1e-18, most_damping = 1e3;
  PoseRows miss = missing(pose(positions), wanted);
  double damping = 1e-3;  // of a radian or a metre; less where it is nearer
  for (int step = 0; step < max_steps && size_of(miss) > near_enough && damping < most_damping; ++step) {
    std::vector<double> next =
        stepped(positions, miss, damping * std::min(1.0, size_of(miss)) + least_damping);
    const PoseRows next_miss = missing(pose(next), wanted);
    const bool is_nearer = size_of(next_miss) < size_of(miss);
    damping *= is_nearer ? 0.1 : 10;
    if (!is_nearer) continue;
    positions = std::move(next);
    miss = next_miss;
  }
}

/// Of axes that are scaled so that each moves the tip by 1.
std::vector<double> PoseDescent::stepped(std::vector<double> positions, const PoseRows& miss,
                                         double damping) {
  pose(positions);
  kinematics_.tree().jacobian(link_, poses_, columns_);
  std::vector<PoseRows> slopes;
  std::vector<double> scales;
  for (const std::size_t axis : axes_) {
    const JacobianColumn& column = columns_[axis];
    PoseRows slope = {column.linear.x,  column.linear.y,  column.linear.z,
                      column.angular.x, column.angular.y, column.angular.z};
    scales.push_back(size_of(slope) > 0 ? 1 / size_of(slope) : 0);
    for (double& row : slope) row *= scales.back();
    slopes.push_back(slope);
  }
  PoseSquare sums{};
  for (std::size_t r = 0; r < rows_of_pose; ++r) {
    for (std::size_t c = 0; c < rows_of_pose; ++c)
      for (const PoseRows& slope : slopes) sums[r][c] += slope[r] * slope[c];
    sums[r][r] += damping;
  }
  const PoseRows weights = solved(sums, miss);
  for (std::size_t i = 0; i < positions.size(); ++i)
    for (std::size_t r = 0; r < rows_of_pose; ++r) positions[i] += scales[i] * slopes[i][r] * weights[r];
  return positions;
}

}  // namespace inbetween
