// A part of a cubic, as a cubic of its own.
#pragma once

#include "inbetween/path/path.hpp"

namespace inbetween {

/// c(begin + size t) as a cubic in t.
inline Cubic cut(const Cubic& c, double begin, double size) {
  return {c.value(begin), size * c.derivative(begin), size * size * c.second(begin) / 2,
          size * size * size * c.c3};
}

}  // namespace inbetween
