// How punctual this machine can be.
#pragma once

#include <cstdint>
#include <span>

#include "drivers/linux/machine_facts.hpp"
#include "drivers/linux/real_time.hpp"
#include "host_tools/doctor/finding.hpp"
#include "host_tools/loop/wake_latency.hpp"

namespace inbetween {

/// The kernel, the clock, the frequency of the processors, wireless interfaces.
Findings check_machine(const MachineFacts& facts);
/// The rights of a real-time thread, one finding each.
Findings check_rights(std::span<const RealTimeRight> rights);

/// Wakes up `rate_hz` times a second for so long, with the rights that the calling thread has.
WakeLatency measure_wake_latency(double seconds, std::int32_t rate_hz);
/// A tick that comes a quarter of its period late leaves the bus little time.
Finding judge(const WakeLatency& latency, std::int32_t rate_hz);

}  // namespace inbetween
