#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/setpoint.hpp"

/// Tells where an axis was at a moment in the past.

namespace inbetween {

/// The last setpoints of an axis with the times at which they are reached.
class SetpointTrail {
 public:
  /// A few ticks suffice: an edge is reported on the first or second tick after it.
  static constexpr std::size_t capacity = 16;

  void clear() { count_ = 0; }
  /// Adds a setpoint; `at_ns` is later than that of the setpoint before. A full trail drops the oldest.
  void push(std::int64_t at_ns, const Setpoint& setpoint);
  /// The commanded position, on the polynomial of lowest degree that joins the two setpoints around it. None
  /// outside the trail. O(capacity).
  [[nodiscard]] std::optional<double> position_at(std::int64_t at_ns) const;

 private:
  struct Step {
    std::int64_t at_ns = 0;
    Setpoint setpoint;
  };
  [[nodiscard]] const Step& step(std::size_t age) const;
  static double between(const Step& from, const Step& to, std::int64_t at_ns);

  std::array<Step, capacity> steps_{};
  std::size_t count_ = 0;
  std::size_t newest_ = 0;
};

}  // namespace inbetween
