#include "host_tools/rig_model/gpio_line_reader.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace inbetween {
namespace {

/// A line may have no chip only if it has a name by which the chip can be found.
LineAddress read_address(const TomlTable& table, TakenLines& taken) {
  const TomlValue line = table.required("line", "the line, by offset or name");
  LineAddress address;
  if (table.optional("chip")) {
    address.chip = read_chip(table);
  } else if (!line.node().is_string()) {
    line.integer(0, max_line_offset);
    line.refuse(R"(is an offset without its chip; add chip = "the label of the GPIO chip")");
  }
  address.line = read_line_of(address.chip, line, taken);
  address.place = line.place();
  return address;
}

Level pulled_to(Bias bias) {
  return bias == Bias::pull_up ? Level::high : Level::low;
}

Bias pull_towards(Level level) {
  return level == Level::high ? Bias::pull_up : Bias::pull_down;
}

Bias read_bias(const TomlTable& table, Level active, BrokenWire broken) {
  const Level wanted = broken == BrokenWire::reads_inactive ? opposite(active) : active;
  const auto value = table.optional("bias");
  if (!value) return pull_towards(wanted);
  const auto bias = static_cast<Bias>(value->choice(bias_words));
  if (bias == Bias::none || broken == BrokenWire::preferably_active || pulled_to(bias) == wanted) return bias;
  value->refuse(fmt::format(
      R"(is "{}", so that a broken wire would read {}, {}; write "{}", or "none" with such a resistor outside)",
      to_string(bias), to_string(pulled_to(bias)),
      broken == BrokenWire::reads_active ? "as if nothing were to stop" : "which would start",
      to_string(pull_towards(wanted))));
}

}  // namespace

void TakenLines::take(const TomlValue& value, const LineAddress& address) {
  const auto is_same = [&](const LineAddress& other) { return is_same_line(address, other); };
  const auto earlier = std::find_if(lines_.begin(), lines_.end(), is_same);
  if (earlier != lines_.end()) {
    value.refuse(fmt::format("is {}, which line {} has already; use each line once", to_string(address),
                             earlier->place.line));
  }
  lines_.push_back(address);
}

std::string read_chip(const TomlTable& table) {
  const TomlValue value = table.required("chip", R"(the label of the GPIO chip, chip = "pinctrl-bcm2711")");
  std::string chip = value.text();
  std::string_view number = chip;
  for (const std::string_view prefix : {"/dev/", "gpiochip"}) {
    if (number.starts_with(prefix)) number.remove_prefix(prefix.size());
  }
  if (number.find_first_not_of("0123456789") == number.npos) {
    value.refuse(fmt::format("is {}, a number that may change at every start; write the chip's label",
                             in_quotes(chip)));
  }
  return chip;
}

GpioLine read_line_of(const std::string& chip, const TomlValue& value, TakenLines& taken) {
  LineAddress address{chip, {}, value.place()};
  if (value.node().is_string()) {
    address.line = value.text();
  } else {
    address.line = static_cast<int>(value.integer(0, max_line_offset));
  }
  taken.take(value, address);
  return address.line;
}

Level read_level(const TomlValue& value) {
  return value.choice({"low", "high"}) == 0 ? Level::low : Level::high;
}

InputLine read_input(const TomlTable& table, Level active, BrokenWire broken, TakenLines& taken) {
  InputLine input;
  input.address = read_address(table, taken);
  input.active = active;
  input.bias = read_bias(table, active, broken);
  return input;
}

InputLine read_input(const TomlTable& table, BrokenWire broken, TakenLines& taken) {
  const auto active = table.optional("active");
  return read_input(table, active ? read_level(*active) : Level::high, broken, taken);
}

OutputLine read_output(const TomlTable& table, TakenLines& taken) {
  OutputLine output;
  output.address = read_address(table, taken);
  if (const auto idle = table.optional("idle")) output.idle = read_level(*idle);
  return output;
}

}  // namespace inbetween
