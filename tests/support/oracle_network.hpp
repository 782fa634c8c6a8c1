// Networks of moving points, the slow and obvious way. An oracle: it shares no line and no method with the
// product.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "tests/support/oracle_curves.hpp"

namespace inbetween::oracle {

/// An axis of a row: its keys, and the points of its drawn curve if it has one.
struct NetworkAxis {
  long double place = 0;
  TimedKeys keys;
  std::optional<TimedKeys> drawn;
};

/// What Coons' formula says of each axis, evaluated as it is written: the curve through the keys, and the
/// residual of the row interpolated at the place of the axis.
class NetworkOracle {
 public:
  explicit NetworkOracle(std::vector<NetworkAxis> row);
  /// Derivative of order 0 to 2 per frame; at a knot that of the piece behind it.
  [[nodiscard]] long double at(std::size_t axis, long double frame, int order) const;

 private:
  [[nodiscard]] long double residual(std::size_t axis, long double frame, int order) const;

  std::vector<NetworkAxis> row_;
  std::vector<std::vector<TimedPiece>> through_keys_;
  std::vector<std::vector<TimedPiece>> drawn_;
};

}  // namespace inbetween::oracle
