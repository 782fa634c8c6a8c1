#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "inbetween/homing/line_event.hpp"
#include "sim/simulated_switch.hpp"

namespace inbetween {

/// The input lines of a rig without hardware: switches along the travel of its axes, and lines that somebody
/// sets. They tell what those of a GPIO chip tell: edges with their times, and levels.
class SimulatedInputs {
 public:
  /// Lines at their first levels, with the axes at rest at `positions`.
  SimulatedInputs(std::vector<bool> levels, std::span<const double> positions);

  /// On the line of its settings, which has nothing else.
  void add_switch(std::size_t axis, const SimulatedSwitch::Settings& settings);
  /// The axis is at `position` at `now_ns`, and went there steadily.
  void follow(std::size_t axis, double position, std::int64_t now_ns);
  /// Somebody sets a line that is no switch.
  void set(std::size_t line, bool level, std::int64_t now_ns);
  /// Gives the switch on a line a fault.
  void set_fault(std::size_t line, SimulatedSwitch::Fault fault);

  [[nodiscard]] bool level(std::size_t line) const { return levels_[line]; }
  /// Adds the edges since the last call: those of a switch are in order.
  void take(std::vector<LineEvent>& events);

 private:
  struct OnAxis {
    std::size_t axis = 0;
    std::size_t line = 0;
    SimulatedSwitch of;
  };
  struct Stand {
    double position = 0;
    std::optional<std::int64_t> at_ns;
  };

  std::vector<bool> levels_;
  std::vector<Stand> stands_;
  std::vector<OnAxis> switches_;
  std::vector<LineEvent> coming_;
};

}  // namespace inbetween
