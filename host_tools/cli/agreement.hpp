// Asks somebody at a terminal to agree that a rig moves.
#pragma once

#include <string>

#include "drivers/linux/key_terminal.hpp"

namespace inbetween {

/// Prints the question to standard error and waits for a key. Enter means yes; q, Esc or an interrupt
/// (InterruptWatch) means no.
bool agrees(KeyTerminal& terminal, const std::string& question);

}  // namespace inbetween
