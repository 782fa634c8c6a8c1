#include "host_tools/rig_model/gpio_line.hpp"

#include <fmt/format.h>

namespace inbetween {

std::string_view to_string(Level level) {
  return level == Level::low ? "low" : "high";
}

std::string_view to_string(Bias bias) {
  return bias_words.at(static_cast<std::size_t>(bias));
}

std::string to_string(const LineAddress& address) {
  const auto* name = std::get_if<std::string>(&address.line);
  const std::string line =
      name != nullptr ? in_quotes(*name) : fmt::format("{}", std::get<int>(address.line));
  return address.chip.empty() ? fmt::format("line {}", line)
                              : fmt::format("line {} of chip {}", line, in_quotes(address.chip));
}

bool is_same_line(const LineAddress& a, const LineAddress& b) {
  const bool may_be_on_one_chip = a.chip.empty() || b.chip.empty() || a.chip == b.chip;
  return a.line == b.line && may_be_on_one_chip;
}

}  // namespace inbetween
