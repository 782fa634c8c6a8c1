#pragma once

#include <cstdint>
#include <string_view>

#include "inbetween/base/result.hpp"
#include "tests/embedded/target/console.hpp"
#include "tests/embedded/target/moves.hpp"

/// What the lines of table_report are made of.

namespace inbetween::embedded {

/// False after the first fail().
inline bool passed = true;

inline void fail(std::string_view what, const Move& move, const Error& error) {
  passed = false;
  print("FAILED ");
  print(what);
  print(" ");
  print(move.name);
  print(": ");
  print(error.what);
  print("; ");
  print(error.remedy);
  print(", needed ");
  print(error.needed);
  print("\n");
}

inline void print_hash(std::string_view name, std::uint64_t hash) {
  print(" ");
  print(name);
  print(" ");
  for (int shift = 60; shift >= 0; shift -= 4) {
    print(std::string_view("0123456789abcdef").substr((hash >> shift) & 0xFU, 1));
  }
}

}  // namespace inbetween::embedded
