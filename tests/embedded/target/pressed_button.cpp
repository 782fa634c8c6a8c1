#include "examples/firmware/board.hpp"

/// A finger that an emulated board does not have: it presses the button on the 701st tick.

namespace inbetween::board {

bool button_is_pressed() {
  static int asked = 0;
  return ++asked > 700;
}

}  // namespace inbetween::board
