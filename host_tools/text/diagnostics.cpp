#include "host_tools/text/diagnostics.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <utility>

namespace inbetween {
namespace {

std::string one_line(std::string_view text) {
  std::string line;
  line.reserve(text.size());
  for (const char byte : text) {
    const auto code = static_cast<unsigned char>(byte);
    if (code < 0x20 || code == 0x7f) {
      line += fmt::format("\\x{:02x}", code);
    } else {
      line += byte;
    }
  }
  return line;
}

}  // namespace

std::string to_string(const Place& place) {
  if (place.line == 0) return place.file;
  if (place.column == 0) return fmt::format("{}:{}", place.file, place.line);
  return fmt::format("{}:{}:{}", place.file, place.line, place.column);
}

InputError::InputError(Place place, std::string message)
    : std::runtime_error(one_line(fmt::format("{}: error: {}", to_string(place), message))),
      place_(std::move(place)),
      message_(std::move(message)) {}

std::string to_string(const Warning& warning) {
  return one_line(fmt::format("{}: warning: {}", to_string(warning.place), warning.message));
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t shown = 60;
  if (text.size() <= shown) return '"' + one_line(text) + '"';
  std::size_t end = shown;
  const auto continues_a_character = [](char byte) {
    return (static_cast<unsigned char>(byte) & 0xc0U) == 0x80U;
  };
  while (end > 0 && continues_a_character(text[end])) --end;
  return '"' + one_line(text.substr(0, end)) + "...\"";
}

TwoNumbers told_apart(double first, double second, Digits kind, int at_least) {
  constexpr int most = 17;  // tell any two doubles apart
  TwoNumbers words;
  for (int digits = at_least; digits <= most; ++digits) {
    const auto shown = [&](double number) {
      return kind == Digits::decimals ? fmt::format("{:.{}f}", number, digits)
                                      : fmt::format("{:.{}g}", number, digits);
    };
    words = {shown(first), shown(second)};
    if (words.first != words.second || first == second) break;
  }
  return words;
}

std::string counted(std::int64_t count, std::string_view what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

std::string listed_with_and(const std::vector<std::string>& words) {
  std::string list;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) list += i + 1 == words.size() ? " and " : ", ";
    list += words[i];
  }
  return list;
}

}  // namespace inbetween
