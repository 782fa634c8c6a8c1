// Linear equations with a symmetric positive definite matrix.
#pragma once

#include <vector>

namespace inbetween {

/// The x with A x = b, for a symmetric positive definite A of as many rows as b has numbers, row after row:
/// Cholesky's decomposition. O(n^3). Not finite where A is not positive definite.
std::vector<double> solved(std::vector<double> a, std::vector<double> b);

}  // namespace inbetween
