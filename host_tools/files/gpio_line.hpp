// The GPIO lines of a rig: which they are and how they are wired.
#pragma once

#include <string>
#include <string_view>
#include <variant>

#include "host_tools/files/diagnostics.hpp"

namespace inbetween {

/// A GPIO line by its offset on the chip, or by its name.
using GpioLine = std::variant<int, std::string>;

/// The electrical level of a line.
enum class Level { low, high };
std::string_view to_string(Level level);
constexpr Level opposite(Level level) {
  return level == Level::low ? Level::high : Level::low;
}

/// What the chip itself does to an input that nothing drives.
enum class Bias { none, pull_up, pull_down };
std::string_view to_string(Bias bias);

/// Which line it is. An offset always has a chip; a name without one is the only line of that name on any
/// chip.
struct LineAddress {
  std::string chip;  // label, never "gpiochipN"; empty: to be found by the name of the line
  GpioLine line;
  Place place;  // of `line` in the rig
};

/// `line 5 of chip "expander"`, `line "ESTOP"`.
std::string to_string(const LineAddress& address);

/// Whether both say the same line. An offset and a name may do so too, which only the chip knows.
bool is_same_line(const LineAddress& a, const LineAddress& b);

struct InputLine {
  LineAddress address;
  Level active = Level::high;  // the level that means: pressed, stop, start, asked
  Bias bias = Bias::none;
};

struct OutputLine {
  LineAddress address;
  Level idle = Level::low;  // outside pulses, and on every exit
};

}  // namespace inbetween
