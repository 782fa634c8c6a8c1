#pragma once

#include <string_view>

/// What the programs of this folder need of the machine they run on: somewhere to print. console_board.cpp
/// has the serial port of a bare board, console_stdio.cpp an operating system.

namespace inbetween::embedded {

/// The program: defined by each, called once. False: something was wrong, and a line that begins with
/// FAILED says what.
bool run();

void print(std::string_view text);
/// In decimal.
void print(long long number);

}  // namespace inbetween::embedded
