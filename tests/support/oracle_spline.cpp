#include "tests/support/oracle_spline.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>

namespace inbetween::oracle {
namespace {

using Vector = std::vector<long double>;
using Matrix = std::vector<Vector>;  // [row][column]

/// Solves matrix * x = right for every column of right: Gaussian elimination with scaled partial pivoting.
Matrix solve(Matrix matrix, Matrix right) {
  const std::size_t size = matrix.size();
  for (std::size_t row = 0; row < size; ++row) {
    long double largest = 0;
    for (const long double entry : matrix[row]) largest = std::max(largest, std::fabs(entry));
    for (long double& entry : matrix[row]) entry /= largest;
    for (long double& entry : right[row]) entry /= largest;
  }
  for (std::size_t column = 0; column < size; ++column) {
    std::size_t pivot = column;
    for (std::size_t row = column + 1; row < size; ++row)
      if (std::fabs(matrix[row][column]) > std::fabs(matrix[pivot][column])) pivot = row;
    if (matrix[pivot][column] == 0) throw std::logic_error("oracle: the continuity conditions are singular");
    std::swap(matrix[column], matrix[pivot]);
    std::swap(right[column], right[pivot]);
    for (std::size_t row = column + 1; row < size; ++row) {
      const long double factor = matrix[row][column] / matrix[column][column];
      if (factor == 0) continue;
      for (std::size_t k = column; k < size; ++k) matrix[row][k] -= factor * matrix[column][k];
      for (std::size_t k = 0; k < right[row].size(); ++k) right[row][k] -= factor * right[column][k];
    }
  }
  for (std::size_t row = size; row-- > 0;) {
    for (std::size_t k = 0; k < right[row].size(); ++k) {
      for (std::size_t column = row + 1; column < size; ++column)
        right[row][k] -= matrix[row][column] * right[column][k];
      right[row][k] /= matrix[row][row];
    }
  }
  return right;
}

/// Neighbours on a ring of `count`.
std::size_t after(std::size_t i, std::size_t count) {
  return i + 1 == count ? 0 : i + 1;
}
std::size_t before(std::size_t i, std::size_t count) {
  return i == 0 ? count - 1 : i - 1;
}

/// The chords between successive keys; for a sole key one zero chord.
Matrix chords(const Keys& keys) {
  const std::size_t count = keys.at.size();
  const std::size_t segments = keys.closed || count == 1 ? count : count - 1;
  Matrix result(segments, Vector(keys.at.front().size()));
  for (std::size_t i = 0; i < segments; ++i)
    for (std::size_t axis = 0; axis < result[i].size(); ++axis)
      result[i][axis] = keys.at[after(i, count)][axis] - keys.at[i][axis];
  return result;
}

long double weighted_length(const Vector& chord, const Vector& weights) {
  long double sum = 0;
  for (std::size_t axis = 0; axis < chord.size(); ++axis)
    sum += weights[axis] * weights[axis] * chord[axis] * chord[axis];
  return std::sqrt(sum);
}

/// The continuity conditions of the smooth spline, one unknown c1, c2, c3 per span in this order.
struct Conditions {
  Matrix matrix;
  Matrix right;

  Conditions(std::size_t span_count, std::size_t axis_count) : unknowns(3 * span_count), axes(axis_count) {}

  Vector& add(const Vector& right_side) {
    right.push_back(right_side);
    return matrix.emplace_back(unknowns, 0.0L);
  }
  Vector& add() { return add(Vector(axes, 0.0L)); }

  std::size_t unknowns;
  std::size_t axes;
};

Matrix solve_smooth(const Matrix& span_chords, const Vector& knot_steps, bool closed) {
  const std::size_t spans = span_chords.size();
  Conditions conditions(spans, span_chords.front().size());
  for (std::size_t i = 0; i < spans; ++i) {
    Vector& reaches_next_key = conditions.add(span_chords[i]);
    for (std::size_t k = 0; k < 3; ++k) reaches_next_key[3 * i + k] = 1;
  }
  for (std::size_t i = 0; i < (closed ? spans : spans - 1); ++i) {
    const std::size_t next = after(i, spans);
    const long double ratio = knot_steps[next] / knot_steps[i];
    Vector& same_first = conditions.add();
    same_first[3 * i] += ratio;
    same_first[3 * i + 1] += 2 * ratio;
    same_first[3 * i + 2] += 3 * ratio;
    same_first[3 * next] -= 1;
    Vector& same_second = conditions.add();
    same_second[3 * i + 1] += 2 * ratio * ratio;
    same_second[3 * i + 2] += 6 * ratio * ratio;
    same_second[3 * next + 1] -= 2;
  }
  if (!closed) {
    conditions.add()[1] = 2;
    Vector& straight_at_end = conditions.add();
    straight_at_end[3 * (spans - 1) + 1] = 2;
    straight_at_end[3 * (spans - 1) + 2] = 6;
  }
  return solve(conditions.matrix, conditions.right);
}

std::vector<std::vector<Cubic>> smooth_cubics(const Keys& keys, const Vector& weights, const Matrix& chord) {
  std::vector<std::size_t> moving;
  Matrix span_chords;
  Vector knot_steps;
  std::vector<std::vector<Cubic>> result(chord.size(), std::vector<Cubic>(weights.size(), Cubic{}));
  for (std::size_t i = 0; i < chord.size(); ++i) {
    for (std::size_t axis = 0; axis < weights.size(); ++axis) result[i][axis][0] = keys.at[i][axis];
    const long double length = weighted_length(chord[i], weights);
    if (length == 0) continue;
    moving.push_back(i);
    span_chords.push_back(chord[i]);
    knot_steps.push_back(std::sqrt(length));
  }
  if (moving.empty()) return result;
  const Matrix solved = solve_smooth(span_chords, knot_steps, keys.closed);
  for (std::size_t span = 0; span < moving.size(); ++span)
    for (std::size_t axis = 0; axis < weights.size(); ++axis)
      for (std::size_t k = 0; k < 3; ++k) result[moving[span]][axis][k + 1] = solved[3 * span + k][axis];
  return result;
}

std::vector<std::vector<Cubic>> tcb_cubics(const Keys& keys, const Matrix& chord) {
  const std::size_t count = keys.at.size();
  const std::size_t axes = keys.at.front().size();
  Matrix incoming(count, Vector(axes));
  Matrix outgoing(count, Vector(axes));
  for (std::size_t i = 0; i < count; ++i) {
    const std::array<long double, 3> none{};
    const bool has_parameters = keys.kind == Kind::tcb && !keys.tension_continuity_bias.empty();
    const auto [t, c, b] = has_parameters ? keys.tension_continuity_bias[i] : none;
    const bool first = i == 0 && !keys.closed;
    const bool last = i + 1 == count && !keys.closed;
    const Vector& chord_before = first ? chord.front() : chord[before(i, count)];
    const Vector& chord_after = last ? chord.back() : chord[i];
    for (std::size_t axis = 0; axis < axes; ++axis) {
      incoming[i][axis] = (1 - t) * (1 - c) * (1 + b) / 2 * chord_before[axis] +
                          (1 - t) * (1 + c) * (1 - b) / 2 * chord_after[axis];
      outgoing[i][axis] = (1 - t) * (1 + c) * (1 + b) / 2 * chord_before[axis] +
                          (1 - t) * (1 - c) * (1 - b) / 2 * chord_after[axis];
    }
  }
  std::vector<std::vector<Cubic>> result(chord.size(), std::vector<Cubic>(axes));
  for (std::size_t i = 0; i < chord.size(); ++i) {
    for (std::size_t axis = 0; axis < axes; ++axis) {
      const long double d = chord[i][axis];
      const long double from = outgoing[i][axis];
      const long double to = incoming[after(i, count)][axis];
      result[i][axis] = {keys.at[i][axis], from, 3 * d - 2 * from - to, from + to - 2 * d};
    }
  }
  return result;
}

std::vector<std::vector<Cubic>> linear_cubics(const Keys& keys, const Matrix& chord) {
  std::vector<std::vector<Cubic>> result(chord.size());
  for (std::size_t i = 0; i < chord.size(); ++i)
    for (std::size_t axis = 0; axis < chord[i].size(); ++axis)
      result[i].push_back({keys.at[i][axis], chord[i][axis], 0, 0});
  return result;
}

void require(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument("oracle: " + what);
}

void require_wellformed(const Keys& keys) {
  require(!keys.at.empty(), "no keys");
  const std::size_t axes = keys.at.front().size();
  for (const Vector& key : keys.at) require(key.size() == axes, "keys of unequal length");
  require(keys.weights.empty() || keys.weights.size() == axes, "as many weights as axes are needed");
  for (const long double weight : keys.weights) require(weight >= 0, "a weight is negative");
  require(keys.tension_continuity_bias.empty() || keys.tension_continuity_bias.size() == keys.at.size(),
          "tension, continuity and bias are needed for every key or for none");
}

/// A segment that an observer sees move, but whose measured length is zero, has no speed.
void require_measurable(const std::vector<Cubic>& segment, const Vector& weights, std::size_t index) {
  bool moves = false;
  bool measured = false;
  for (std::size_t axis = 0; axis < segment.size(); ++axis) {
    const bool axis_moves = segment[axis][1] != 0 || segment[axis][2] != 0 || segment[axis][3] != 0;
    moves = moves || axis_moves;
    measured = measured || (axis_moves && weights[axis] > 0);
  }
  require(measured || !moves,
          "an axis moves in segment " + std::to_string(index) + ", which has zero weighted length");
}

}  // namespace

std::vector<std::vector<Cubic>> segment_cubics(const Keys& keys) {
  require_wellformed(keys);
  const Vector weights = keys.weights.empty() ? Vector(keys.at.front().size(), 1.0L) : keys.weights;
  const Matrix chord = chords(keys);
  const std::vector<std::vector<Cubic>> straight = linear_cubics(keys, chord);
  // The knots of the smooth spline need it of the chords before there is a curve.
  for (std::size_t i = 0; keys.kind == Kind::smooth && i < chord.size(); ++i)
    require_measurable(straight[i], weights, i);

  std::vector<std::vector<Cubic>> result;
  switch (keys.kind) {
    case Kind::smooth:
      result = smooth_cubics(keys, weights, chord);
      break;
    case Kind::catmull_rom:
    case Kind::tcb:
      result = tcb_cubics(keys, chord);
      break;
    case Kind::linear:
      result = straight;
      break;
  }
  for (std::size_t i = 0; i < result.size(); ++i) require_measurable(result[i], weights, i);
  return result;
}

}  // namespace inbetween::oracle
