// Reading the GPIO lines of a rig, each of which is used once.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/files/gpio_line.hpp"
#include "host_tools/files/toml_value.hpp"

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

/// The field `chip`. Throws InputError where it is a number, "gpiochip0" included.
std::string read_chip(const TomlTable& table);

/// A line of `chip` that is given by a field of its own, such as `step`.
GpioLine read_line_of(const std::string& chip, const TomlValue& value, TakenLines& taken);

/// "low" or "high".
Level read_level(const TomlValue& value);

/// Which way an input shall fall when its wire breaks.
enum class BrokenWire {
  reads_active,    // emergency stop: the other way is refused
  reads_inactive,  // what starts something: the other way is refused
  preferably_active
};

/// The fields `chip`, `line` and `bias` of an input. Without a `bias` the chip pulls the way that `broken`
/// says. Throws InputError where a bias would pull the way that is refused.
InputLine read_input(const TomlTable& table, Level active, BrokenWire broken, TakenLines& taken);

/// The same with the field `active`, "high" if it is not there.
InputLine read_input(const TomlTable& table, BrokenWire broken, TakenLines& taken);

/// The fields `chip`, `line` and `idle` of an output.
OutputLine read_output(const TomlTable& table, TakenLines& taken);

}  // namespace inbetween
