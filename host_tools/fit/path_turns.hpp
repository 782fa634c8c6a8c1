// How the path turns at one place, by the distance travelled and not by its parameter.
#pragma once

#include <array>
#include <vector>

#include "inbetween/path/path.hpp"

namespace inbetween {

/// Derivatives of P by L, the weighted arc length.
struct PathTurns {
  std::vector<std::array<double, 4>> axes;  ///< of every axis the first to the fourth derivative
  double curvature = 0;                     ///< |W d2P/dL2|, 1 / length
  double scale = 0;                         ///< the distance in which the path turns; infinity on a line

  /// False where the path stands still; the members then mean nothing. At the end of the path it finds the
  /// derivatives with which the path arrives.
  [[nodiscard]] bool find(const Path& path, const PathPoint& point);
};

}  // namespace inbetween
