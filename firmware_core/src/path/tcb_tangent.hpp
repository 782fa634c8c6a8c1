#pragma once

#include <cstddef>

#include "inbetween/path/path.hpp"

/// Tangents at keys.

namespace inbetween {

/// The two sides of a key.
enum class KeySide { arriving, leaving };

/// Kochanek and Bartels' source (arriving) and destination (leaving) derivative at key `i` of a spec with two
/// keys or more, on the parameter that is one from key to key. At an open end both chords are the only chord
/// there is. `i` may be the number of keys: the return to key 0 of a closed path.
inline double tcb_tangent(const PathSpec& spec, std::size_t i, std::size_t d, KeySide side) {
  const auto axes = static_cast<std::size_t>(spec.axis_count);
  const std::size_t keys = spec.keys.size() / axes;
  const auto chord = [&](std::size_t from) { return spec.key(from + 1, d) - spec.key(from, d); };
  const bool has_previous = spec.closed || i > 0;
  const bool has_next = spec.closed || i + 1 < keys;
  const std::size_t k = i < keys ? i : i - keys;
  const double before = has_previous ? chord(k > 0 ? k - 1 : keys - 1) : chord(k);
  const double after = has_next ? chord(k) : before;
  const bool shaped = spec.spline == Spline::tcb && !spec.shapes.empty();
  const KeyShape shape = shaped ? spec.shapes[k] : KeyShape{};
  const double continuity = side == KeySide::leaving ? shape.continuity : -shape.continuity;
  return (1 - shape.tension) / 2 *
         ((1 + continuity) * (1 + shape.bias) * before + (1 - continuity) * (1 - shape.bias) * after);
}

}  // namespace inbetween
