#pragma once

#include <cstdint>
#include <span>

namespace inbetween::can {

/// What a drive tells of its errors, a code or one bit, in words.
struct Words {
  std::uint32_t code;
  const char* words;
};

/// Those of a code; `unknown` where the table does not have it. O(table).
constexpr const char* words_in(std::span<const Words> table, std::uint32_t code, const char* unknown) {
  for (const Words& row : table) {
    if (row.code == code) return row.words;
  }
  return unknown;
}

}  // namespace inbetween::can
