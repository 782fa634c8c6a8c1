#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>

/// Numbers in the bytes of a frame, least significant first.

namespace inbetween::can {

/// The number at `offset`. Bytes behind the eighth end the program: a defect of the caller, not an input.
template <std::unsigned_integral T>
constexpr T load(const std::array<std::uint8_t, 8>& data, std::size_t offset) {
  if (offset + sizeof(T) > data.size()) __builtin_trap();
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value |= std::uint64_t{data[offset + i]} << (8 * i);
  return static_cast<T>(value);
}

/// Puts `value` at `offset`, with the same bound.
template <std::unsigned_integral T>
constexpr void store(std::array<std::uint8_t, 8>& data, std::size_t offset, T value) {
  if (offset + sizeof(T) > data.size()) __builtin_trap();
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    data[offset + i] = static_cast<std::uint8_t>(std::uint64_t{value} >> (8 * i));
  }
}

}  // namespace inbetween::can
