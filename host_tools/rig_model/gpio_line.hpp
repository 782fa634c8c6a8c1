// The GPIO lines of a rig: their addresses and their wiring.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <variant>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

/// A GPIO line by its offset on the chip, or by its name.
using GpioLine = std::variant<int, std::string>;

/// The electrical level of a line.
enum class Level { low, high };
std::string_view to_string(Level level);
constexpr Level opposite(Level level) {
  return level == Level::low ? Level::high : Level::low;
}

/// The pull of the chip on an input that nothing drives.
enum class Bias { pull_up, pull_down, none };
inline constexpr std::array<std::string_view, 3> bias_words = {"pull-up", "pull-down", "none"};
std::string_view to_string(Bias bias);

/// The address of a line. An offset always has a chip. A name without a chip is the only line of that name on
/// all chips.
struct LineAddress {
  std::string chip;  // label, never "gpiochipN"; empty: to be found by the name of the line
  GpioLine line;
  Place place;  // of `line` in the rig
};

/// `line 5 of chip "expander"`, `line "ESTOP"`.
std::string to_string(const LineAddress& address);

/// Whether both addresses are the same by their words. An offset and a name may mean the same line too, which
/// only the chip knows.
bool is_same_line(const LineAddress& a, const LineAddress& b);

struct InputLine {
  LineAddress address;
  Level active = Level::high;  // the level that means pressed, stop, start, or asked
  Bias bias = Bias::none;
};

struct OutputLine {
  LineAddress address;
  Level idle = Level::low;  // outside pulses, and on every exit
};

}  // namespace inbetween
