#include "host_tools/scene/base64.hpp"

#include <array>
#include <cstdint>

namespace inbetween {
namespace {

constexpr std::string_view base64_signs = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr std::size_t group_bytes = 3, group_signs = 4;

/// 64 for what is no sign.
constexpr std::array<std::uint8_t, 256> values_of_signs() {
  std::array<std::uint8_t, 256> values{};
  values.fill(64);
  for (std::size_t i = 0; i < base64_signs.size(); ++i)
    values.at(static_cast<unsigned char>(base64_signs[i])) = static_cast<std::uint8_t>(i);
  return values;
}

}  // namespace

std::string base64_of(std::string_view bytes) {
  std::string text;
  text.reserve((bytes.size() + 2) / group_bytes * group_signs);
  for (std::size_t at = 0; at < bytes.size(); at += group_bytes) {
    std::uint32_t group = 0;
    for (std::size_t i = 0; i < group_bytes; ++i) {
      const bool is_there = at + i < bytes.size();
      group = group << 8U | (is_there ? static_cast<unsigned char>(bytes[at + i]) : 0U);
    }
    for (std::size_t i = 0; i < group_signs; ++i) {
      const bool is_there = at + i <= bytes.size();
      text += is_there ? base64_signs[group >> 18U & 0x3fU] : '=';
      group <<= 6U;
    }
  }
  return text;
}

std::optional<std::string> bytes_of_base64(std::string_view text) {
  static constexpr std::array<std::uint8_t, 256> values = values_of_signs();
  if (text.size() % group_signs != 0) return std::nullopt;
  std::size_t fill = 0;
  while (fill < 2 && text.ends_with('=')) {
    text.remove_suffix(1);
    ++fill;
  }
  std::string bytes;
  bytes.reserve(text.size() / group_signs * group_bytes + group_bytes);
  std::uint32_t group = 0;
  std::size_t bits = 0;
  for (const char sign : text) {
    const std::uint8_t value = values.at(static_cast<unsigned char>(sign));
    if (value == 64) return std::nullopt;
    group = group << 6U | value;
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes += static_cast<char>(group >> bits & 0xffU);
  }
  return bytes;
}

}  // namespace inbetween
