#include "tests/support/oracle_pace.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

#include "tests/support/oracle_least_squares.hpp"

namespace inbetween::oracle {
namespace {

using Vector = std::vector<long double>;
using Matrix = std::vector<Vector>;
using Marks = std::vector<std::uint8_t>;

/// The integrals count so much more than the bending: its square is far below the precision of an answer.
constexpr long double weight_of_integrals = 1e6L;
constexpr long double nothing = 1e-13L;

/// phi'' at each knot as a row: second differences inside, 0 at the ends. The integral of phi''^2 over a span
/// is ((s0 + s1 / 2)^2 + 3 / 4 s1^2) / 3.
Matrix bending_rows(std::size_t count) {
  const auto second = [&](std::size_t knot) {
    Vector row(count);
    if (knot > 0 && knot + 1 < count) {
      row[knot - 1] = row[knot + 1] = 1;
      row[knot] = -2;
    }
    return row;
  };
  Matrix rows;
  for (std::size_t knot = 0; knot + 1 < count; ++knot) {
    const Vector s0 = second(knot);
    const Vector s1 = second(knot + 1);
    Vector sum(count);
    Vector rest(count);
    for (std::size_t i = 0; i < count; ++i) {
      sum[i] = (s0[i] + s1[i] / 2) / std::sqrt(3.0L);
      rest[i] = s1[i] / 2;
    }
    rows.push_back(sum);
    rows.push_back(rest);
  }
  return rows;
}

/// The least squares solution of matrix * x = right in the columns that are free, by Householder reflections.
Vector least_squares(Matrix matrix, Vector right, const std::vector<std::size_t>& columns) {
  const std::size_t rows = matrix.size();
  for (std::size_t k = 0; k < columns.size(); ++k) {
    long double norm = 0;
    for (std::size_t r = k; r < rows; ++r) norm = std::hypot(norm, matrix[r][columns[k]]);
    if (norm == 0) throw std::runtime_error("oracle: a control value that nothing depends on");
    const long double alpha = matrix[k][columns[k]] > 0 ? -norm : norm;
    Vector v(rows);
    for (std::size_t r = k; r < rows; ++r) v[r] = matrix[r][columns[k]];
    v[k] -= alpha;
    long double square = 0;
    for (std::size_t r = k; r < rows; ++r) square += v[r] * v[r];
    const auto reflect = [&](auto&& at) {
      long double dot = 0;
      for (std::size_t r = k; r < rows; ++r) dot += v[r] * at(r);
      for (std::size_t r = k; r < rows; ++r) at(r) -= 2 * dot / square * v[r];
    };
    for (std::size_t c = k; c < columns.size(); ++c) {
      reflect([&](std::size_t r) -> long double& { return matrix[r][columns[c]]; });
    }
    reflect([&](std::size_t r) -> long double& { return right[r]; });
  }
  Vector x(matrix.front().size());
  for (std::size_t k = columns.size(); k-- > 0;) {
    long double sum = right[k];
    for (std::size_t c = k + 1; c < columns.size(); ++c) sum -= matrix[k][columns[c]] * x[columns[c]];
    x[columns[k]] = sum / matrix[k][columns[k]];
  }
  return x;
}

Vector product(const Matrix& matrix, const Vector& x) {
  Vector result;
  for (const Vector& row : matrix) {
    long double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i) sum += row[i] * x[i];
    result.push_back(sum);
  }
  return result;
}

std::vector<std::size_t> columns_of(const Marks& is_free) {
  std::vector<std::size_t> columns;
  for (std::size_t i = 0; i < is_free.size(); ++i) {
    if (is_free[i] != 0) columns.push_back(i);
  }
  return columns;
}

/// The values above 0 of the least squares solution without negative numbers.
Marks positive_values(const Matrix& matrix, const Vector& right, const Marks& is_zero) {
  const std::size_t count = is_zero.size();
  Marks is_free(count);
  Vector x(count);
  for (std::size_t round = 0; round < 20 * count; ++round) {
    const Vector reached = product(matrix, x);
    Vector gradient(count);
    for (std::size_t r = 0; r < matrix.size(); ++r) {
      for (std::size_t i = 0; i < count; ++i) gradient[i] += matrix[r][i] * (right[r] - reached[r]);
    }
    std::size_t best = count;
    for (std::size_t i = 0; i < count; ++i) {
      if (is_zero[i] != 0 || is_free[i] != 0 || !(gradient[i] > nothing)) continue;
      if (best == count || gradient[i] > gradient[best]) best = i;
    }
    if (best == count) return is_free;
    is_free[best] = 1;
    for (;;) {
      const Vector solution = least_squares(matrix, right, columns_of(is_free));
      long double step = 1;
      for (const std::size_t i : columns_of(is_free)) {
        if (solution[i] <= 0 && x[i] - solution[i] > 0) step = std::min(step, x[i] / (x[i] - solution[i]));
      }
      bool is_inside = true;
      for (std::size_t i = 0; i < count; ++i) {
        if (is_free[i] == 0) continue;
        if (solution[i] <= 0) is_inside = false;
        x[i] += step * (solution[i] - x[i]);
      }
      if (is_inside) break;
      for (std::size_t i = 0; i < count; ++i) {
        if (is_free[i] == 0 || x[i] > nothing) continue;
        is_free[i] = 0;
        x[i] = 0;
      }
    }
  }
  throw std::runtime_error("oracle: the values above 0 do not settle");
}

/// Gauss with pivoting.
Vector solved(Matrix system, Vector right) {
  const std::size_t n = right.size();
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t r = k + 1; r < n; ++r) {
      if (std::fabs(system[r][k]) > std::fabs(system[pivot][k])) pivot = r;
    }
    std::swap(system[k], system[pivot]);
    std::swap(right[k], right[pivot]);
    for (std::size_t r = k + 1; r < n; ++r) {
      const long double factor = system[r][k] / system[k][k];
      for (std::size_t c = k; c < n; ++c) system[r][c] -= factor * system[k][c];
      right[r] -= factor * right[k];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t c = k + 1; c < n; ++c) right[k] -= system[k][c] * right[c];
    right[k] /= system[k][k];
  }
  return right;
}

}  // namespace

long double bending(const std::vector<long double>& values) {
  long double sum = 0;
  for (const long double part : product(bending_rows(values.size()), values)) sum += part * part;
  return sum;
}

std::vector<long double> smoothest(const PaceProblem& problem) {
  const auto count = static_cast<std::size_t>(problem.spans) + 1;
  const Matrix bends = bending_rows(count);
  const Matrix all_integrals = integral_rows(problem.spans, problem.places);
  Matrix integrals;
  Vector targets;
  for (std::size_t k = 1; k < problem.distances.size(); ++k) {
    const long double distance = problem.distances[k] - problem.distances[k - 1];
    if (distance == 0) continue;  // only values that are 0 count there
    targets.push_back(distance / problem.distances.back() * problem.spans);
    integrals.push_back(all_integrals[k - 1]);
  }
  Matrix weighted;
  Vector right;
  for (std::size_t r = 0; r < integrals.size(); ++r) {
    Vector row = integrals[r];
    for (long double& each : row) each *= weight_of_integrals;
    weighted.push_back(row);
    right.push_back(targets[r] * weight_of_integrals);
  }
  weighted.insert(weighted.end(), bends.begin(), bends.end());
  right.resize(weighted.size());
  const std::vector<std::size_t> free = columns_of(positive_values(weighted, right, problem.is_zero));

  // With the others at 0: the gradient of the bending is that of the integrals (Lagrange).
  const std::size_t n = free.size();
  Matrix system(n + integrals.size(), Vector(n + integrals.size()));
  Vector known(n + integrals.size());
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      for (const Vector& row : bends) system[i][j] += row[free[i]] * row[free[j]];
    }
    for (std::size_t r = 0; r < integrals.size(); ++r) {
      system[i][n + r] = system[n + r][i] = integrals[r][free[i]];
    }
  }
  for (std::size_t r = 0; r < integrals.size(); ++r) known[n + r] = targets[r];
  const Vector answer = solved(std::move(system), std::move(known));
  Vector values(count);
  for (std::size_t i = 0; i < n; ++i) values[free[i]] = answer[i];
  for (const long double value : values) {
    if (!(value >= -1e-9L)) throw std::runtime_error("oracle: a speed below 0");
  }
  return values;
}

}  // namespace inbetween::oracle
