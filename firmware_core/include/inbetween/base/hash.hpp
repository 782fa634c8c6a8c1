#pragma once

#include <bit>
#include <concepts>
#include <cstdint>
#include <span>

#include "inbetween/base/precision.hpp"

namespace inbetween {

/// FNV-1a, 64 bits (Fowler, Noll and Vo), over the bits of numbers, lowest byte first on every target. It
/// tells whether two tables are the same. It does not protect against somebody who forges a table.
class Fnv1a {
 public:
  constexpr void add(std::uint64_t bits, int bytes) {
    for (int i = 0; i < bytes; ++i) {
      state_ = (state_ ^ ((bits >> (8 * i)) & 0xFFU)) * 0x100000001B3U;
    }
  }
  constexpr void add(std::int32_t number) { add(static_cast<std::uint32_t>(number), 4); }
  constexpr void add(double number) { add(std::bit_cast<std::uint64_t>(number), 8); }

  [[nodiscard]] constexpr std::uint64_t value() const { return state_; }

 private:
  std::uint64_t state_ = 0xCBF29CE484222325U;
};

/// The hash of every (segment, t) of a table. It is equal on x86-64, arm64 and Cortex-M7 for the same move in
/// double: the core uses only operations that IEEE 754 rounds exactly, and no compiler may fuse them
/// (-ffp-contract=off).
constexpr std::uint64_t hash_of(std::span<const PathPoint> points) {
  Fnv1a hash;
  for (const PathPoint& point : points) {
    hash.add(static_cast<std::int32_t>(point.segment));
    hash.add(point.t);
  }
  return hash.value();
}

}  // namespace inbetween
