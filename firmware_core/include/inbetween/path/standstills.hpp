#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "inbetween/path/path.hpp"

namespace inbetween {

/// The standstills of a path, P' = 0, between the keys of a segment: there a drawn speed turns its direction
/// round. At most two.
template <Precise Real>
struct Standstills {
  std::array<Real, 2> t{};
  std::size_t count = 0;
};
/// None of a segment without length. O(axes).
template <Precise Real>
Standstills<Real> standstills_within(const Path<Real>& path, std::int32_t segment);

}  // namespace inbetween
