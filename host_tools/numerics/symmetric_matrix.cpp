#include "host_tools/numerics/symmetric_matrix.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "host_tools/numerics/hypotenuse.hpp"

namespace inbetween {
namespace {

using Matrix = std::vector<std::vector<double>>;

/// Every matrix of this size is diagonal long before; the loop ends in any case.
constexpr int max_sweeps = 50;

/// Turns rows and columns p and q so that the element (p, q) vanishes.
void rotate(Matrix& a, Matrix& vectors, std::size_t p, std::size_t q) {
  const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
  const double tangent = std::copysign(1.0, theta) / (std::fabs(theta) + hypotenuse(theta, 1.0));
  const double cosine = 1 / hypotenuse(tangent, 1.0);
  const double sine = tangent * cosine;
  const auto turn = [&](double& x, double& y) {
    const double before = x;
    x = cosine * before - sine * y;
    y = sine * before + cosine * y;
  };
  for (std::vector<double>& row : a) turn(row[p], row[q]);
  for (std::size_t k = 0; k < a.size(); ++k) turn(a[p][k], a[q][k]);
  for (std::size_t k = 0; k < a.size(); ++k) turn(vectors[p][k], vectors[q][k]);
}

}  // namespace

SymmetricEigen eigen_of(std::vector<std::vector<double>> matrix) {
  const std::size_t n = matrix.size();
  Matrix vectors(n, std::vector<double>(n));
  for (std::size_t i = 0; i < n; ++i) vectors[i][i] = 1;
  double trace = 0;
  for (std::size_t i = 0; i < n; ++i) trace += std::fabs(matrix[i][i]);
  const double nothing =
      std::numeric_limits<double>::epsilon() * std::numeric_limits<double>::epsilon() * trace;
  for (int sweep = 0; sweep < max_sweeps; ++sweep) {
    bool is_diagonal = true;
    for (std::size_t p = 0; p < n; ++p) {
      for (std::size_t q = p + 1; q < n; ++q) {
        const double size = std::sqrt(std::fabs(matrix[p][p] * matrix[q][q]));
        const double smallest = std::numeric_limits<double>::epsilon() * size;
        if (std::fabs(matrix[p][q]) <= std::max(smallest, nothing)) continue;
        rotate(matrix, vectors, p, q);
        is_diagonal = false;
      }
    }
    if (is_diagonal) break;
  }
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, [&](std::size_t i, std::size_t k) { return matrix[i][i] > matrix[k][k]; });
  SymmetricEigen result;
  for (const std::size_t i : order) {
    result.values.push_back(matrix[i][i]);
    result.vectors.push_back(vectors[i]);
  }
  return result;
}

std::vector<double> solved(std::vector<double> a, std::vector<double> b) {
  const std::size_t n = b.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = a[i * n + j];
      for (std::size_t k = 0; k < j; ++k) sum -= a[i * n + k] * a[j * n + k];
      a[i * n + j] = i == j ? std::sqrt(sum) : sum / a[j * n + j];
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < i; ++k) b[i] -= a[i * n + k] * b[k];
    b[i] /= a[i * n + i];
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) b[i] -= a[k * n + i] * b[k];
    b[i] /= a[i * n + i];
  }
  return b;
}

}  // namespace inbetween
