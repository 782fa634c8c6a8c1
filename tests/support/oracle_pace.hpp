// The smoothest speed curve through keys on frames, as the quadratic program that it is by definition. An
// oracle: dense, in long double, and by another method than the product's.
#pragma once

#include <cstdint>
#include <vector>

namespace inbetween::oracle {

struct PaceProblem {
  int spans = 1;                       ///< f: there are f + 1 control values
  std::vector<long double> places;     ///< a of each key, rising: the first 0, the last f
  std::vector<long double> distances;  ///< of each key along the path, rising, from 0
  std::vector<std::uint8_t> is_zero;   ///< 1 for each control value that rests or touches there
};

/// v >= 0 with the least integral of phi''^2 and with integrals between the keys in proportion to their
/// distances, the whole integral being f. Lawson and Hanson's least squares without negative numbers (1974,
/// ch. 23), the integrals weighted far above the rest, tell which values are 0; with those the others follow
/// from one system of equations. Throws std::runtime_error where the answer does not satisfy its conditions.
std::vector<long double> smoothest(const PaceProblem& problem);

/// The integral of phi''^2.
long double bending(const std::vector<long double>& values);

}  // namespace inbetween::oracle
