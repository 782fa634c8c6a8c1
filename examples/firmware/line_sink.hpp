#pragma once

#include <array>
#include <charconv>
#include <cstdint>
#include <span>

#include "examples/firmware/board.hpp"

namespace inbetween::board {

/// This sends positions as lines of text. A drive on a bus is another class with the same function.
class LineSink {
 public:
  void set_positions(std::int64_t tick, std::span<const std::int32_t> counts) {
    put(tick);
    for (const std::int32_t count : counts) {
      send(" ");
      put(count);
    }
    send("\n");
  }

 private:
  static void put(std::int64_t number) {
    std::array<char, 24> digits;
    const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), number);
    send({digits.data(), end});
  }
};

}  // namespace inbetween::board
