#include "examples/firmware/board.hpp"

namespace inbetween::board {

bool button_is_pressed() {
  return false;
}

}  // namespace inbetween::board
