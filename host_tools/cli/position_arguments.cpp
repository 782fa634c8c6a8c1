#include "host_tools/cli/position_arguments.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <system_error>

#include "host_tools/cli/command.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

std::optional<double> number_of(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(number)) return std::nullopt;
  return number;
}

std::map<std::string, double> positions_of(const std::vector<std::string>& texts,
                                           const std::string& argument) {
  std::map<std::string, double> positions;
  for (const std::string& text : texts) {
    const std::size_t sign = text.rfind('=');
    const auto position =
        sign == std::string::npos ? std::nullopt : number_of(std::string_view(text).substr(sign + 1));
    if (!position) {
      throw UsageError(fmt::format("{} {}: not a position; write AXIS=POSITION, for example pan=-20",
                                   argument, in_quotes(text)));
    }
    if (!positions.emplace(text.substr(0, sign), *position).second) {
      throw UsageError(fmt::format("{} {}: the axis has a position already", argument, in_quotes(text)));
    }
  }
  return positions;
}

}  // namespace inbetween
