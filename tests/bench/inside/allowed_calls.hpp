// Proof of which system calls a loop makes: every other one ends the process.
#pragma once

#include <functional>
#include <string>

namespace inbetween {

/// Runs `prepare` and then `loop` in a child process; from the first line of `loop` on, its thread may make
/// no system call but clock_nanosleep, sendmmsg, recvmmsg, and what a clock is read with where that takes a
/// call (the bench kernel has no vDSO that reads it without). Says "" if it came to its end, or how it ended.
std::string only_loop_calls(const std::function<void()>& prepare, const std::function<void()>& loop);

}  // namespace inbetween
