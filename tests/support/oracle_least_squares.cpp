#include "tests/support/oracle_least_squares.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

#include "tests/support/oracle_profile.hpp"

namespace inbetween::oracle {
namespace {

using Vector = std::vector<long double>;

constexpr long double infinite = std::numeric_limits<long double>::infinity();
/// What is left of a vector that depends on others.
constexpr long double dependent = 1e-13L;

long double dot(const Vector& a, const Vector& b) {
  long double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

void add(Vector& to, long double factor, const Vector& what) {
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += factor * what[i];
}

/// Orthonormal directions that span the constraint rows where the values are free, by Gram and Schmidt,
/// twice.
class Basis {
 public:
  Basis(const std::vector<Vector>& rows, const std::vector<int>& side) {
    for (const Vector& row : rows) {
      Vector left = row;
      for (std::size_t i = 0; i < side.size(); ++i) {
        if (side[i] != 0) left[i] = 0;
      }
      const long double size = std::sqrt(dot(left, left));
      remove_from(left);
      remove_from(left);
      const long double rest = std::sqrt(dot(left, left));
      if (!(rest > dependent * size)) continue;
      for (long double& each : left) each /= rest;
      directions_.push_back(left);
    }
  }
  void remove_from(Vector& vector) const {
    for (const Vector& direction : directions_) add(vector, -dot(direction, vector), direction);
  }
  std::size_t size() const { return directions_.size(); }
  const Vector& operator[](std::size_t i) const { return directions_[i]; }

 private:
  std::vector<Vector> directions_;
};

/// Coefficients c for which sum c_r rows_r agrees with `wanted` where the values are free, by elimination
/// with pivoting in the coordinates of the basis.
Vector coefficients(const std::vector<Vector>& rows, const Basis& basis, const Vector& wanted) {
  const std::size_t m = rows.size();
  std::vector<Vector> table;
  for (std::size_t i = 0; i < basis.size(); ++i) {
    Vector& line = table.emplace_back();
    for (const Vector& row : rows) line.push_back(dot(basis[i], row));
    line.push_back(dot(basis[i], wanted));
  }
  Vector result(m, 0);
  std::vector<std::size_t> column_of(table.size(), m);
  std::vector<bool> used(m, false);
  for (std::size_t i = 0; i < table.size(); ++i) {
    std::size_t column = m;
    for (std::size_t c = 0; c < m; ++c) {
      if (!used[c] && (column == m || std::fabs(table[i][c]) > std::fabs(table[i][column]))) column = c;
    }
    used[column] = true;
    column_of[i] = column;
    for (std::size_t other = 0; other < table.size(); ++other) {
      if (other != i) add(table[other], -table[other][column] / table[i][column], table[i]);
    }
  }
  for (std::size_t i = 0; i < table.size(); ++i) result[column_of[i]] = table[i][m] / table[i][column_of[i]];
  return result;
}

/// The problem in y = (x - drawn) / sqrt(mobility), of which the sum of squares is to be least.
class ActiveSet {
 public:
  explicit ActiveSet(const QuadraticProgram& problem) {
    for (std::size_t i = 0; i < problem.drawn.size(); ++i) {
      if (problem.mobility[i] > 0 && problem.ceiling[i] > 0) moving_.push_back(i);
    }
    for (const std::size_t i : moving_) {
      const long double scale = std::sqrt(problem.mobility[i]);
      low_.push_back(-problem.drawn[i] / scale);
      high_.push_back((problem.ceiling[i] - problem.drawn[i]) / scale);
    }
    for (std::size_t r = 0; r < problem.rows.size(); ++r) {
      Vector row;
      long double rest = problem.targets[r];
      for (const std::size_t i : moving_) {
        row.push_back(problem.rows[r][i] * std::sqrt(problem.mobility[i]));
        rest -= problem.rows[r][i] * problem.drawn[i];
      }
      rows_.push_back(row);
      rests_.push_back(rest);
      size_ = std::max(size_, std::fabs(problem.targets[r]));
    }
    y_.assign(moving_.size(), 0);
    side_.assign(moving_.size(), 0);
    multiplier_.assign(moving_.size(), 0);
  }

  std::optional<Vector> run(const QuadraticProgram& problem) {
    if (!meet_rows()) return std::nullopt;
    for (std::size_t count = 0; count <= 20 * y_.size(); ++count) {
      const std::size_t bound = most_violated();
      if (bound == y_.size()) {
        Vector x(problem.drawn.size(), 0);
        for (std::size_t k = 0; k < moving_.size(); ++k) {
          const std::size_t i = moving_[k];
          const long double value = problem.drawn[i] + std::sqrt(problem.mobility[i]) * y_[k];
          x[i] = side_[k] < 0 ? 0 : side_[k] > 0 ? problem.ceiling[i] : value;
        }
        return x;
      }
      if (!make_active(bound)) return std::nullopt;
    }
    throw std::runtime_error("oracle: the active set does not settle");
  }

 private:
  /// The least y that meets the rows.
  bool meet_rows() {
    const Basis basis(rows_, side_);
    for (int pass = 0; pass < 3; ++pass) {
      // Every direction of the basis is met one after the other: row r only sees directions up to its own.
      for (std::size_t i = 0, r = 0; i < basis.size(); ++i, ++r) {
        while (std::fabs(dot(rows_[r], basis[i])) <= dependent * std::sqrt(dot(rows_[r], rows_[r]))) ++r;
        add(y_, (rests_[r] - dot(rows_[r], y_)) / dot(rows_[r], basis[i]), basis[i]);
      }
    }
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      if (std::fabs(rests_[r] - dot(rows_[r], y_)) > 1e-13L * size_) return false;
    }
    return true;
  }

  std::size_t most_violated() const {
    std::size_t worst = y_.size();
    long double most = 1e-15L;
    for (std::size_t i = 0; i < y_.size(); ++i) {
      if (side_[i] != 0) continue;
      const long double beyond = std::max(low_[i] - y_[i], y_[i] - high_[i]);
      if (beyond > most * (high_[i] - low_[i])) {
        most = beyond / (high_[i] - low_[i]);
        worst = i;
      }
    }
    return worst;
  }

  bool make_active(std::size_t bound) {
    const int side = y_[bound] < low_[bound] ? -1 : 1;
    const long double limit = side < 0 ? low_[bound] : high_[bound];
    long double own = 0;
    for (;;) {
      const Basis basis(rows_, side_);
      // The constraint grows along its inward normal: up at 0, down at the ceiling.
      Vector normal(y_.size(), 0);
      normal[bound] = side < 0 ? 1 : -1;
      Vector step = normal;
      basis.remove_from(step);
      basis.remove_from(step);
      const Vector weights = coefficients(rows_, basis, normal);
      const bool moves = std::sqrt(dot(step, step)) > 1e-9L;
      const long double full = moves ? (limit - y_[bound]) / step[bound] : infinite;
      std::size_t blocking = y_.size();
      long double partial = infinite;
      Vector falls(y_.size(), 0);
      for (std::size_t i = 0; i < y_.size(); ++i) {
        if (side_[i] == 0) continue;
        long double fall = 0;
        for (std::size_t r = 0; r < rows_.size(); ++r) fall -= weights[r] * rows_[r][i];
        falls[i] = side_[i] < 0 ? fall : -fall;
        if (falls[i] > 1e-15L && multiplier_[i] / falls[i] < partial) {
          partial = multiplier_[i] / falls[i];
          blocking = i;
        }
      }
      const long double length = std::min(full, partial);
      if (length == infinite) return false;
      add(multiplier_, -length, falls);
      own += length;
      if (moves) add(y_, length, step);
      if (full <= partial) {
        y_[bound] = limit;
        side_[bound] = side;
        multiplier_[bound] = own;
        return true;
      }
      side_[blocking] = 0;
      multiplier_[blocking] = 0;
    }
  }

  std::vector<std::size_t> moving_;
  Vector low_, high_;
  std::vector<Vector> rows_;
  Vector rests_;
  long double size_ = 0;
  Vector y_;
  std::vector<int> side_;  ///< -1 at 0, 1 at the ceiling, 0 free
  Vector multiplier_;
};

}  // namespace

std::optional<std::vector<long double>> solve(const QuadraticProgram& problem) {
  return ActiveSet(problem).run(problem);
}

long double change(const QuadraticProgram& problem, const std::vector<long double>& values) {
  long double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!(problem.mobility[i] > 0 && problem.ceiling[i] > 0)) continue;
    const long double difference = values[i] - problem.drawn[i];
    sum += difference * difference / problem.mobility[i];
  }
  return sum;
}

std::vector<std::vector<long double>> integral_rows(int spans, const std::vector<long double>& bounds) {
  const auto values = static_cast<std::size_t>(spans) + 1;
  std::vector<Vector> rows(bounds.size() - 1, Vector(values, 0));
  for (std::size_t i = 0; i < values; ++i) {
    Vector unit(values, 0);
    unit[i] = 1;
    const Profile profile(unit);
    for (std::size_t r = 0; r + 1 < bounds.size(); ++r) {
      rows[r][i] = profile.integral(bounds[r], bounds[r + 1]);
    }
  }
  return rows;
}

std::vector<long double> refined(const std::vector<long double>& control_values) {
  const std::size_t f = control_values.size() - 1;
  Vector fine(2 * f + 1);
  for (std::size_t i = 0; i <= f; ++i) {
    const long double here = control_values[i];
    const bool end = i == 0 || i == f;
    fine[2 * i] = end ? here : (control_values[i - 1] + 6 * here + control_values[i + 1]) / 8;
    if (i < f) fine[2 * i + 1] = (here + control_values[i + 1]) / 2;
  }
  return fine;
}

}  // namespace inbetween::oracle
