// Small symmetric matrices: eigenvalues, and linear equations.
#pragma once

#include <cstddef>
#include <vector>

namespace inbetween {

/// matrix = sum of value[k] * vector[k] vector[k]^T; values from the largest to the smallest, vectors of
/// length 1.
struct SymmetricEigen {
  std::vector<double> values;
  std::vector<std::vector<double>> vectors;
};

/// Jacobi's rotations, O(n^3) each sweep; to the rounding of the largest value. `matrix` is symmetric, a
/// vector for each row.
SymmetricEigen eigen_of(std::vector<std::vector<double>> matrix);

/// The x with A x = b, for a symmetric positive definite A of as many rows as b has numbers, row after row:
/// Cholesky's decomposition. O(n^3). Not finite where A is not positive definite.
std::vector<double> solved(std::vector<double> a, std::vector<double> b);

}  // namespace inbetween
