#include <cstdio>

#include "examples/firmware/board.hpp"

/// The board of examples/firmware on this machine: its ticks come as fast as they are asked for, and its
/// serial port is standard output.

namespace inbetween::board {

void start_tick(std::int32_t) {}

std::int64_t wait_for_tick() {
  static std::int64_t tick = -1;
  return ++tick;
}

void send(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stdout);
}

}  // namespace inbetween::board

int main() {
  return inbetween::board::program() ? 0 : 1;
}
