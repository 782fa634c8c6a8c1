#pragma once

#include <cstdint>
#include <string_view>

/// A program on a bare controller asks these of its board. board_mps2.cpp and button_mps2.cpp answer for
/// Arm's MPS2 boards, which QEMU has; for another board write them and a linker script anew.

namespace inbetween::board {

/// The program, defined by whoever uses the board. Start-up calls it and hands what it returns to finish().
bool program();

/// Starts the tick, `rate_hz` times a second. Domain: rates whose period the 24-bit SysTick timer can count,
/// 2 Hz to 1 MHz at 25 MHz.
void start_tick(std::int32_t rate_hz);
/// Sleeps until the next tick is due and returns its number, from 0. A tick that was missed is skipped by
/// its number: the caller sees the gap.
std::int64_t wait_for_tick();
/// The tick interrupt.
void on_tick();

/// Whether somebody holds the button that stops the move. Called once a tick.
bool button_is_pressed();

/// Puts characters out on the serial port, waiting for it where it is slower.
void send(std::string_view text);

/// The board's clock: rises by one every 1 / clock_hz seconds, wraps after 2^24. start_clock() makes SysTick
/// this clock; it cannot be the tick at the same time.
inline constexpr std::uint32_t clock_hz = 25'000'000;
inline constexpr std::uint32_t clock_mask = 0xFF'FFFF;
void start_clock();
std::uint32_t clock_now();

/// Ends the program, with a status that a debugger or emulator sees (semihosting). On a board without one it
/// stops here.
[[noreturn]] void finish(bool success);

}  // namespace inbetween::board
