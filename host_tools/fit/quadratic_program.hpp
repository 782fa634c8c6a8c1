// The nearest point that keeps linear conditions: a strictly convex quadratic program.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace inbetween {

/// Finds the x with the smallest (x - target)^T G (x - target) that keeps all conditions added so far.
/// Conditions may come in any order, and the next one may depend on x: a caller with very many conditions
/// adds only those that x breaks.
///
/// Method: the dual active-set method of Goldfarb and Idnani (1983), with J = L^-T Q and R kept up to date by
/// Givens rotations. The program forgets a condition that no longer holds x back: if x breaks it later, add
/// it again.
class QuadraticProgram {
 public:
  /// G is n x n, row after row, symmetric and positive definite; otherwise this throws std::invalid_argument.
  /// n is the size of the target, 1 or more. O(n^3).
  QuadraticProgram(std::span<const double> gram, std::span<const double> target);

  [[nodiscard]] std::span<const double> x() const { return x_; }

  /// Demands row * x = bound from now on. Equations come before all inequalities. False if it contradicts an
  /// earlier equation. O(n^2).
  [[nodiscard]] bool add_equality(std::span<const double> row, double bound);

  /// Demands row * x >= bound, and moves x there. False if no x keeps it together with the conditions in
  /// force; the program is then of no further use. O(n^2) for every condition that comes or goes.
  [[nodiscard]] bool add(std::span<const double> row, double bound);

 private:
  struct Condition {
    double multiplier = 0;
    bool is_equality = false;
  };

  void find_directions(std::span<const double> row);
  [[nodiscard]] std::size_t first_to_leave(double& step) const;
  void enter(bool is_equality, double multiplier);
  void leave(std::size_t index);
  void rotate_columns(std::size_t left, double cosine, double sine);
  [[nodiscard]] double& j(std::size_t column, std::size_t row) { return j_[column * n_ + row]; }
  [[nodiscard]] double& r(std::size_t row, std::size_t column) { return r_[column * n_ + row]; }
  [[nodiscard]] double r(std::size_t row, std::size_t column) const { return r_[column * n_ + row]; }

  std::size_t n_;
  std::vector<double> x_;
  std::vector<double> j_;             ///< column after column
  std::vector<double> r_;             ///< column after column, upper triangle
  std::vector<Condition> in_force_;   ///< one for every column of r_
  std::vector<double> d_, z_, dual_;  ///< J^T row; the way of x; the way of the multipliers
};

}  // namespace inbetween
