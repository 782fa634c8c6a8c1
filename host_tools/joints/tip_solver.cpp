#include "host_tools/joints/tip_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "host_tools/joints/branch.hpp"
#include "host_tools/joints/vector_length.hpp"
#include "host_tools/numerics/hypotenuse.hpp"
#include "host_tools/numerics/symmetric_matrix.hpp"
#include "inbetween/joints/angle_of.hpp"

namespace inbetween {
namespace {

/// Of a descent, and of the search for the solution nearest to `near`: both end by themselves where a step is
/// rounding. The bound is for what is out of reach, where the steps get smaller and smaller.
constexpr int max_iterations = 200;
/// Of the scaled axes in one step: half a radian is as far as the Jacobian is worth something. A longer step
/// may go to another solution than the one it began beside
/// (InverseProperty.DampedLeastSquaresFindsThePoseThatItBeganBesideAndGoesOnWithIt).
constexpr double max_step = 0.5;
/// Places from which a first solution is sought, besides `near`: a rig without a closed form has several
/// solutions, and of those that are found the one nearest to `near` counts. Fewer places miss some; each
/// costs a descent.
constexpr int seed_count = 24;
/// Squared singular values below this share of the largest are rounding: the products of doubles are that
/// exact.
constexpr double no_freedom = 1e-16;
/// A direction that hardly moves at any place, as a share of the largest, is none of the rig's. It is far
/// below singular_share (axes_in_space.cpp), below which a direction is lost at one place only.
constexpr double no_rank = 1e-6;
/// Axes farther from parallel than this (rad) are no arm in a plane.
constexpr double parallel = 1e-9;

double largest_of(const std::vector<double>& values) {
  double largest = 0;
  for (const double value : values) largest = std::max(largest, std::fabs(value));
  return largest;
}

/// The first whose magnitude is about the largest: what two axes do alike is told of the one nearer the root,
/// however the numbers are rounded.
std::size_t first_of_largest(const std::vector<double>& values) {
  const double enough = 0.9 * largest_of(values);
  const auto first = std::ranges::find_if(values, [&](double x) { return std::fabs(x) >= enough; });
  return static_cast<std::size_t>(first - values.begin());
}

double product(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

Vector3 across(const Vector3& v, const Vector3& direction) {
  return v - direction * dot(v, direction);
}

/// Rows times their transpose, or the transpose times the rows.
std::vector<std::vector<double>> gram(const std::vector<std::vector<double>>& rows, bool of_columns) {
  const std::size_t n = of_columns ? rows.front().size() : rows.size();
  std::vector<std::vector<double>> result(n, std::vector<double>(n));
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < n; ++k) {
      if (!of_columns) {
        result[i][k] = product(rows[i], rows[k]);
        continue;
      }
      for (const std::vector<double>& row : rows) result[i][k] += row[i] * row[k];
    }
  }
  return result;
}

int sign_of_determinant(std::vector<std::vector<double>> matrix) {
  const std::size_t n = matrix.size();
  if (n != matrix.front().size()) return 0;
  int sign = 1;
  for (std::size_t column = 0; column < n; ++column) {
    std::size_t pivot = column;
    for (std::size_t row = column; row < n; ++row) {
      if (std::fabs(matrix[row][column]) > std::fabs(matrix[pivot][column])) pivot = row;
    }
    if (matrix[pivot][column] == 0) return 0;
    if (pivot != column) {
      std::swap(matrix[pivot], matrix[column]);
      sign = -sign;
    }
    if (matrix[column][column] < 0) sign = -sign;
    for (std::size_t row = column + 1; row < n; ++row) {
      const double share = matrix[row][column] / matrix[column][column];
      for (std::size_t k = column; k < n; ++k) matrix[row][k] -= share * matrix[column][k];
    }
  }
  return sign;
}

/// A place of the sequence of Halton, whose bases are the first primes: spread evenly, the same every time.
double halton(int index, std::size_t dimension) {
  constexpr std::array bases = {2, 3, 5, 7, 11, 13, 17, 19};
  const int base = bases.at(dimension % bases.size());
  double share = 1;
  double place = 0;
  for (; index > 0; index /= base) {
    share /= base;
    place += share * (index % base);
  }
  return place;
}

}  // namespace

double TipSolver::Rows::size() const {
  return std::sqrt(product(miss, miss));
}

TipSolver::TipSolver(const Kinematics& kinematics, std::int32_t link, std::vector<TipAxis> axes)
    : kinematics_(&kinematics), link_(link), axes_(std::move(axes)) {
  const auto joints = kinematics_->tree().joints();
  reach_ = branch_to(kinematics_->tree(), link_).length();
  for (const TipAxis& axis : axes_) {
    const auto joint = std::ranges::find(joints, static_cast<std::int32_t>(axis.axis), &Joint::coordinate);
    if (joint != joints.end() && joint->kind == JointKind::prismatic) {
      reach_ += std::fabs(joint->factor) * (axis.max - axis.min);
    }
  }
  reach_ = std::max(reach_, 1e-3);
  for (const TipAxis& axis : axes_) {
    const auto joint = std::ranges::find(joints, static_cast<std::int32_t>(axis.axis), &Joint::coordinate);
    const bool slides = joint != joints.end() && joint->kind == JointKind::prismatic;
    const double factor = joint != joints.end() ? std::fabs(joint->factor) : 1;
    scales_.push_back(slides ? factor / reach_ : factor);
    slides_.push_back(slides);
  }
  arm_ = find_arm();
  crane_ = CraneSolutions::find(kinematics, link_, axes_);
}

std::vector<Pose> TipSolver::poses(const std::vector<double>& positions) const {
  const JointTree& tree = kinematics_->tree();
  std::vector<double> coordinates(tree.coordinate_count());
  for (std::size_t i = 0; i < axes_.size(); ++i) coordinates[axes_[i].axis] = positions[i];
  std::vector<Pose> result(tree.joints().size());
  // Out of range only far beyond every axis: the poses are then those of the root, and no solution.
  static_cast<void>(tree.poses(coordinates, result));
  return result;
}

Pose TipSolver::pose(const std::vector<double>& positions) const {
  return poses(positions)[static_cast<std::size_t>(link_)];
}

TipSolver::Rows TipSolver::rows(const TipTarget& target, const std::vector<double>& positions) const {
  const std::vector<Pose> all = poses(positions);
  const Pose& tip = all[static_cast<std::size_t>(link_)];
  std::vector<JacobianColumn> columns(kinematics_->tree().coordinate_count());
  kinematics_->tree().jacobian(link_, all, columns);
  Rows rows;
  const auto add = [&](double miss, const auto& slope) {
    rows.miss.push_back(miss);
    std::vector<double>& row = rows.slopes.emplace_back();
    for (std::size_t i = 0; i < axes_.size(); ++i) row.push_back(slope(columns[axes_[i].axis]) / scales_[i]);
  };
  if (target.position) {
    const Vector3 gap = tip.position - *target.position;
    rows.miss_m = length(gap);
    for (const Vector3& e : {Vector3{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
      add(dot(gap, e) / reach_, [&](const auto& column) { return dot(column.linear, e) / reach_; });
    }
  }
  const Rotation3& turned = tip.rotation;
  if (target.aim) {
    const Vector3 to_aim = *target.aim - tip.position;
    const double distance = std::max(length(to_aim), std::numeric_limits<double>::min());
    const Vector3 sight = to_aim * (1 / distance);
    for (const Vector3& side : {turned.y, turned.z}) {
      add(dot(side, sight), [&](const auto& column) {
        return dot(cross(column.angular, side), sight) - dot(side, across(column.linear, sight)) / distance;
      });
    }
    rows.miss_rad = length(across(sight, turned.x));
    if (dot(sight, turned.x) < 0) rows.miss_rad = std::numbers::pi - rows.miss_rad;
  }
  if (target.roll) {
    const SineCosine roll = sine_cosine(*target.roll);
    const double miss = roll.cosine * turned.y.z - roll.sine * turned.z.z;
    add(miss, [&](const auto& column) {
      return roll.cosine * cross(column.angular, turned.y).z - roll.sine * cross(column.angular, turned.z).z;
    });
    const bool is_upside_down = roll.sine * turned.y.z + roll.cosine * turned.z.z < 0;
    rows.miss_rad = std::max(rows.miss_rad, is_upside_down ? std::numbers::pi : std::fabs(miss));
  }
  return rows;
}

std::vector<double> TipSolver::step(const Rows& rows, const std::vector<double>& wanted, double damping) {
  const SymmetricEigen eigen = eigen_of(gram(rows.slopes, false));
  std::vector<double> result(rows.slopes.front().size());
  for (std::size_t k = 0; k < eigen.values.size(); ++k) {
    if (!(eigen.values[k] > no_freedom * eigen.values.front())) continue;
    const double share = product(eigen.vectors[k], wanted) / (eigen.values[k] + damping);
    for (std::size_t row = 0; row < rows.slopes.size(); ++row) {
      for (std::size_t i = 0; i < result.size(); ++i) {
        result[i] += rows.slopes[row][i] * (eigen.vectors[k][row] * share);
      }
    }
  }
  return result;
}

std::vector<double> TipSolver::idle_part(const Rows& rows, std::vector<double> motion) {
  std::vector<double> moved;
  for (const std::vector<double>& row : rows.slopes) moved.push_back(product(row, motion));
  const std::vector<double> busy = step(rows, moved, 0);
  for (std::size_t i = 0; i < motion.size(); ++i) motion[i] -= busy[i];
  return motion;
}

void TipSolver::descend(const TipTarget& target, std::vector<double>& positions) const {
  Rows here = rows(target, positions);
  double weight = 1e-3;
  for (int i = 0; i < max_iterations && here.size() > 0; ++i) {
    std::vector<double> wanted;
    for (const double miss : here.miss) wanted.push_back(-miss);
    const std::vector<double> change = step(here, wanted, weight * here.size() * here.size());
    const double shortened = std::min(1.0, max_step / std::max(largest_of(change), max_step));
    std::vector<double> next = positions;
    for (std::size_t k = 0; k < next.size(); ++k) next[k] += shortened * change[k] / scales_[k];
    Rows there = rows(target, next);
    if (there.size() < here.size()) {
      positions = std::move(next);
      here = std::move(there);
      weight = std::max(weight / 4, 1e-6);
      continue;
    }
    // As near as rounding lets it come, or nowhere to go.
    if (largest_of(change) < 1e-13 || weight > 1e12) return;
    weight *= 10;
  }
}

void TipSolver::stay_near(const TipTarget& target, std::vector<double>& positions) const {
  for (int i = 0; i < max_iterations; ++i) {
    std::vector<double> home;
    for (std::size_t k = 0; k < axes_.size(); ++k)
      home.push_back((axes_[k].near - positions[k]) * scales_[k]);
    const std::vector<double> change = idle_part(rows(target, positions), home);
    const double shortened = 0.8 * std::min(1.0, max_step / std::max(largest_of(change), max_step));
    for (std::size_t k = 0; k < axes_.size(); ++k) positions[k] += shortened * change[k] / scales_[k];
    descend(target, positions);
    if (largest_of(change) < 1e-12) return;
  }
}

TipSolution TipSolver::solve(const TipTarget& target, const std::vector<double>& seed) const {
  if (arm_ && target.position && !target.aim && !target.roll) return solve_arm(*target.position, seed);
  if (const auto found = solve_crane(target, seed, false)) return *found;
  TipSolution solution{.positions = seed};
  descend(target, solution.positions);
  const Rows found = rows(target, solution.positions);
  solution.miss_m = found.miss_m;
  solution.miss_rad = found.miss_rad;
  if (solution.is_exact() && freedom(target, solution.positions, found.miss.size()).rank < axes_.size()) {
    stay_near(target, solution.positions);
  }
  return solution;
}

TipSolution TipSolver::solve_from_ranges(const TipTarget& target) const {
  std::vector<double> seed;
  for (const TipAxis& axis : axes_) seed.push_back(axis.near);
  if (const auto found = solve_crane(target, seed, true)) return *found;
  TipSolution best = solve(target, seed);
  if (arm_) return best;
  const std::vector<double> near = seed;
  const auto is_better = [&](const TipSolution& one, const TipSolution& other) {
    if (one.is_exact() != other.is_exact()) return one.is_exact();
    if (!one.is_exact()) return one.miss_m / reach_ + one.miss_rad < other.miss_m / reach_ + other.miss_rad;
    if (in_ranges(one.positions) != in_ranges(other.positions)) return in_ranges(one.positions);
    return distance(one.positions, near) < distance(other.positions, near);
  };
  for (int i = 1; i <= seed_count; ++i) {
    for (std::size_t d = 0; d < axes_.size(); ++d) {
      seed[d] = axes_[d].min + halton(i, d) * (axes_[d].max - axes_[d].min);
    }
    TipSolution found = solve(target, seed);
    if (is_better(found, best)) best = std::move(found);
  }
  return best;
}

std::vector<double> TipSolver::rates(const TipTarget& target, const TipTargetRate& rate,
                                     const std::vector<double>& positions) const {
  std::vector<double> result = step(rows(target, positions), wanted(target, rate, positions), 0);
  for (std::size_t i = 0; i < result.size(); ++i) result[i] /= scales_[i];
  return result;
}

std::vector<double> TipSolver::wanted(const TipTarget& target, const TipTargetRate& rate,
                                      const std::vector<double>& positions) const {
  const Pose tip = pose(positions);
  std::vector<double> result;
  if (target.position) {
    const Vector3 v = rate.position.value_or(Vector3{});
    result = {v.x / reach_, v.y / reach_, v.z / reach_};
  }
  if (target.aim) {
    const Vector3 to_aim = *target.aim - tip.position;
    const double distance = std::max(length(to_aim), std::numeric_limits<double>::min());
    const Vector3 moved = across(rate.aim.value_or(Vector3{}), to_aim * (1 / distance));
    for (const Vector3& side : {tip.rotation.y, tip.rotation.z}) {
      result.push_back(-dot(side, moved) / distance);
    }
  }
  if (target.roll) {
    const SineCosine roll = sine_cosine(*target.roll);
    result.push_back((roll.sine * tip.rotation.y.z + roll.cosine * tip.rotation.z.z) * rate.roll.value_or(0));
  }
  return result;
}

TipSolver::Freedom TipSolver::freedom(const TipTarget& target, const std::vector<double>& positions,
                                      std::size_t rank) const {
  const std::vector<std::vector<double>> slopes = rows(target, positions).slopes;
  const SymmetricEigen eigen = eigen_of(gram(slopes, true));
  Freedom result;
  result.sign = sign_of_determinant(slopes);
  const double largest = eigen.values.front();
  // How much each axis has of the weakest direction, or of all that are lost.
  std::vector<double> weak;
  for (std::size_t k = 0; k < eigen.values.size() && k < rank; ++k) {
    const double share = largest > 0 ? std::sqrt(std::max(eigen.values[k], 0.0) / largest) : 0;
    if (k == 0 || result.smallest > no_rank) weak.assign(axes_.size(), 0);
    for (std::size_t i = 0; i < weak.size(); ++i) weak[i] = hypotenuse(weak[i], eigen.vectors[k][i]);
    result.smallest = share;
    if (share > no_rank) result.rank = k + 1;
  }
  if (!weak.empty()) result.weak_axis = first_of_largest(weak);
  return result;
}

std::size_t TipSolver::usual_rank(const TipTarget& target) const {
  std::size_t rank = 0;
  std::vector<double> place(axes_.size());
  for (int i = 1; i <= 8; ++i) {
    for (std::size_t d = 0; d < axes_.size(); ++d) {
      place[d] = axes_[d].min + halton(i, d) * (axes_[d].max - axes_[d].min);
    }
    rank = std::max(rank, freedom(target, place, axes_.size()).rank);
  }
  return rank;
}

std::optional<TipSolver::Arm> TipSolver::find_arm() const {
  const auto joints = kinematics_->tree().joints();
  std::vector<std::size_t> moving;  // from the link to the root
  for (std::int32_t i = link_; i >= 0; i = joints[static_cast<std::size_t>(i)].parent) {
    const auto link = static_cast<std::size_t>(i);
    if (joints[link].kind == JointKind::prismatic) return std::nullopt;
    if (joints[link].kind == JointKind::revolute) moving.push_back(link);
  }
  if (axes_.size() != 2 || moving.size() != 2) return std::nullopt;
  const std::size_t elbow = moving[0];
  const std::size_t shoulder = moving[1];
  const auto is_axis = [&](std::size_t link, const TipAxis& axis) {
    return joints[link].coordinate == static_cast<std::int32_t>(axis.axis);
  };
  const bool is_in_order = is_axis(shoulder, axes_[0]) && is_axis(elbow, axes_[1]);
  if (!is_in_order || joints[shoulder].offset != 0 || joints[elbow].offset != 0) return std::nullopt;
  const std::vector<Pose> at_zero = poses({0, 0});
  const Vector3 z = at_zero[shoulder].rotation * joints[shoulder].axis;
  const Vector3 other = at_zero[elbow].rotation * joints[elbow].axis;
  if (length(cross(z, other)) > parallel) return std::nullopt;
  const Vector3 upper = across(at_zero[elbow].position - at_zero[shoulder].position, z);
  const Vector3 forearm =
      across(at_zero[static_cast<std::size_t>(link_)].position - at_zero[elbow].position, z);
  if (!(length(upper) > 0) || !(length(forearm) > 0)) return std::nullopt;
  const Vector3 x = upper * (1 / length(upper));
  const Vector3 y = cross(z, x);
  return Arm{
      .links = {length(upper), length(forearm)},
      .shoulder = {{x, y, z}, at_zero[shoulder].position},
      .forearm_angle = angle_of(dot(forearm, x), dot(forearm, y)),
      .slopes = {joints[shoulder].factor, dot(z, other) > 0 ? joints[elbow].factor : -joints[elbow].factor}};
}

TipSolution TipSolver::solve_arm(const Vector3& position, const std::vector<double>& seed) const {
  const Vector3 hand = position - arm_->shoulder.position;
  const double x = dot(hand, arm_->shoulder.rotation.x);
  const double y = dot(hand, arm_->shoulder.rotation.y);
  TipSolution solution{.positions = seed};
  const auto angles = arm_angles(arm_->links, x, y, elbow_);
  if (!angles) {
    solution.miss_m = std::fabs(beyond_reach(arm_->links, hypotenuse(x, y)));
    if (solution.miss_m == 0) solution.miss_rad = std::numbers::pi;  // any direction of the shoulder is one
    return solution;
  }
  const std::array turns{angles->shoulder, angles->elbow - arm_->forearm_angle};
  for (std::size_t i = 0; i < 2; ++i) {
    const double turn = 2 * std::numbers::pi / std::fabs(arm_->slopes[i]);
    const double position_of_axis = turns[i] / arm_->slopes[i];
    solution.positions[i] = position_of_axis + turn * std::round((seed[i] - position_of_axis) / turn);
  }
  solution.miss_m = length(pose(solution.positions).position - position);
  return solution;
}

std::optional<TipSolution> TipSolver::solve_crane(const TipTarget& target, const std::vector<double>& seed,
                                                  bool in_ranges_first) const {
  if (!crane_) return std::nullopt;
  std::optional<TipSolution> best;
  for (std::vector<double>& positions : crane_->of(target)) {
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      if (slides_[i]) continue;
      const double turn = 2 * std::numbers::pi / scales_[i];
      const auto nearest_to = [&](double place) {
        return positions[i] + turn * std::round((place - positions[i]) / turn);
      };
      const double near_middle = nearest_to((axes_[i].min + axes_[i].max) / 2);
      positions[i] = nearest_to(seed[i]);
      if (in_ranges_first && !in_range(i, positions[i]) && in_range(i, near_middle))
        positions[i] = near_middle;
    }
    const Rows found = rows(target, positions);
    TipSolution solution{positions, found.miss_m, found.miss_rad};
    if (!solution.is_exact()) continue;
    const auto rank = [&](const TipSolution& one) {
      return std::pair(in_ranges_first && !in_ranges(one.positions), distance(one.positions, seed));
    };
    if (!best || rank(solution) < rank(*best)) best = std::move(solution);
  }
  return best;
}

double TipSolver::distance(const std::vector<double>& a, const std::vector<double>& b) const {
  double sum = 0;
  for (std::size_t i = 0; i < axes_.size(); ++i) sum = hypotenuse(sum, (a[i] - b[i]) * scales_[i]);
  return sum;
}

bool TipSolver::in_range(std::size_t i, double position) const {
  return position >= axes_[i].min && position <= axes_[i].max;
}

bool TipSolver::in_ranges(const std::vector<double>& positions) const {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (!in_range(i, positions[i])) return false;
  }
  return true;
}

}  // namespace inbetween
