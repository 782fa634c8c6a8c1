#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "inbetween/path/path.hpp"

namespace inbetween {

/// The standstills of a path, P' = 0, between the keys of a segment: there a drawn speed turns its direction
/// round. At most two.
struct Standstills {
  std::array<double, 2> t{};
  std::size_t count = 0;
};
/// None of a segment without length. O(axes).
Standstills standstills_within(const Path& path, std::int32_t segment);

}  // namespace inbetween
