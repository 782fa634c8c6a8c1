#include "host_tools/exchange/toml_text.hpp"

#include <fmt/format.h>

namespace inbetween {
namespace {

constexpr unsigned char first_printed = 0x20;
constexpr unsigned char deleted = 0x7f;

bool is_control(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte < first_printed || byte == deleted;
}

}  // namespace

std::string toml_quoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (is_control(c)) {
      quoted += fmt::format("\\u{:04x}", static_cast<unsigned char>(c));
      continue;
    }
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

std::string toml_list(const std::vector<std::string>& texts) {
  std::string list;
  for (const std::string& text : texts) list += (list.empty() ? "" : ", ") + toml_quoted(text);
  return "[" + list + "]";
}

std::string toml_comment(std::string_view text) {
  std::string line = "# ";
  for (const char c : text) line += is_control(c) ? ' ' : c;
  return line + "\n";
}

}  // namespace inbetween
