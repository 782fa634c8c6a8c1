#include <array>
#include <charconv>

#include "examples/firmware/board.hpp"
#include "tests/embedded/target/console.hpp"

namespace inbetween {

bool board::program() {
  return embedded::run();
}

void embedded::print(std::string_view text) {
  board::send(text);
}

void embedded::print(long long number) {
  std::array<char, 24> digits;
  board::send({digits.data(), std::to_chars(digits.begin(), digits.end(), number).ptr});
}

}  // namespace inbetween
