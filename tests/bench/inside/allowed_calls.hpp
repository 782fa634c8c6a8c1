// Proof of which system calls a loop makes: every other one ends the process.
#pragma once

#include <sys/syscall.h>

#include <functional>
#include <string>
#include <vector>

namespace inbetween {

/// Of a motion loop on a bus.
inline const std::vector<unsigned> bus_loop_calls = {SYS_clock_nanosleep, SYS_sendmmsg, SYS_recvmmsg};

/// Runs `prepare` and then `loop` in a child process; from the first line of `loop` on, its thread may make
/// no system call but those named, and what a clock is read with where that takes a call (the bench kernel
/// has no vDSO that reads it without). Says "" if it came to its end, or how it ended.
std::string only_loop_calls(const std::function<void()>& prepare, const std::function<void()>& loop,
                            const std::vector<unsigned>& calls = bus_loop_calls);

}  // namespace inbetween
