// Reads the GPIO lines of a rig. A rig uses each line once.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host_tools/rig_model/gpio_line.hpp"
#include "host_tools/text/toml_value.hpp"

namespace inbetween {

inline constexpr std::int64_t max_line_offset = 65'535;

/// The lines that the rig uses so far.
class TakenLines {
 public:
  /// Throws InputError at `value`, which names `address`, if the line is in use already.
  void take(const TomlValue& value, const LineAddress& address);

 private:
  std::vector<LineAddress> lines_;
};

/// Reads the field `chip`. Throws InputError if it is a number, or "gpiochip0", which is a number too.
std::string read_chip(const TomlTable& table);

/// Reads a line of `chip` from a field of its own, such as `step`.
GpioLine read_line_of(const std::string& chip, const TomlValue& value, TakenLines& taken);

/// "low" or "high".
Level read_level(const TomlValue& value);

/// The level that an input shall show when its wire breaks.
enum class BrokenWire {
  reads_active,    // emergency stop: the other bias is refused
  reads_inactive,  // an input that starts something: the other bias is refused
  preferably_active
};

/// Reads the fields `chip`, `line` and `bias` of an input. Without a `bias` the chip pulls as `broken` says.
/// Throws InputError if the bias pulls the other way and `broken` does not allow it.
InputLine read_input(const TomlTable& table, Level active, BrokenWire broken, TakenLines& taken);

/// Reads the field `active` as well; "high" without it.
InputLine read_input(const TomlTable& table, BrokenWire broken, TakenLines& taken);

/// Reads the fields `chip`, `line` and `idle` of an output.
OutputLine read_output(const TomlTable& table, TakenLines& taken);

}  // namespace inbetween
