#include "examples/firmware/board.hpp"

/// The first user button of an MPS2 board with the images AN386 and AN500: bit 0 of FPGAIO's BUTTON (Arm DAI
/// 0386, 4.4). QEMU's reads as released.

namespace inbetween::board {

bool button_is_pressed() {
  constexpr std::uint32_t fpgaio_button = 0x40028008;
  return (*reinterpret_cast<const volatile std::uint32_t*>(fpgaio_button) & 0b1) != 0;
}

}  // namespace inbetween::board
