// Whether somebody at a terminal agrees that a rig moves.
#pragma once

#include <string>

#include "drivers/linux/key_terminal.hpp"

namespace inbetween {

/// Puts the question to standard error, and waits for Enter or for anything that means no: q, Esc, or an
/// interrupt (InterruptWatch).
bool agrees(KeyTerminal& terminal, const std::string& question);

}  // namespace inbetween
