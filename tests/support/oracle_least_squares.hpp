// The least change of a drawn speed curve under integral constraints: a dense active set method in long
// double.
#pragma once

#include <optional>
#include <vector>

namespace inbetween::oracle {

/// sum (x_i - drawn_i)^2 / mobility_i least, rows x = targets, 0 <= x_i <= ceiling_i. Where the mobility or
/// the ceiling is 0, x_i = 0 and takes no part in the sum.
struct QuadraticProgram {
  std::vector<std::vector<long double>> rows;
  std::vector<long double> targets;
  std::vector<long double> drawn;
  std::vector<long double> mobility;
  std::vector<long double> ceiling;
};

/// The one solution, or nothing where no x satisfies the constraints. Goldfarb and Idnani 1983: from the
/// solution without bounds one violated bound after the other is made active, never losing optimality. Meets
/// the constraints within 1e-15 of the largest target. Throws std::runtime_error where 20 bounds per value
/// do not suffice.
std::optional<std::vector<long double>> solve(const QuadraticProgram& problem);

/// The sum that solve() makes least.
long double change(const QuadraticProgram& problem, const std::vector<long double>& values);

/// For every pair of neighbours in `bounds` (places a on a curve of that many spans) how the integral of phi
/// between them depends on each control value: the integral of the curve in which this one is 1 and the
/// others are 0.
std::vector<std::vector<long double>> integral_rows(int spans, const std::vector<long double>& bounds);

/// The control values on twice as many spans of the same curve.
std::vector<long double> refined(const std::vector<long double>& control_values);

}  // namespace inbetween::oracle
