// Whether this machine, and a rig on it, are fit to run, as far as can be said before its drives have power.
#pragma once

#include <cstdint>
#include <cstdio>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/can/can_link.hpp"
#include "drivers/linux/machine_facts.hpp"
#include "drivers/linux/real_time.hpp"
#include "host_tools/loop/wake_latency.hpp"
#include "host_tools/rig/rig_hardware.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

enum class Verdict {
  fine,
  note,     ///< it runs, but could be better
  problem,  ///< run refuses it, or does not work
};

/// One line about one thing, and what to do about it.
struct Finding {
  std::string of;  ///< "kernel", "bus can0", "axis pan"
  Verdict verdict = Verdict::fine;
  std::string what{};    ///< one clause, no full stop
  std::string remedy{};  ///< what to do; "" where nothing is to be done
};

using Findings = std::vector<Finding>;

constexpr std::string_view word_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::fine:
      return "fine";
    case Verdict::note:
      return "note";
    case Verdict::problem:
      break;
  }
  return "problem";
}

/// The rig file itself, its buses and its GPIO lines, as the machine has them. Nothing is sent and no line is
/// taken.
Findings check_rig(const RigFile& of);

/// Waits for the next tick and returns its time.
using NextTick = std::function<std::int64_t()>;

/// Sets up every CiA 402 drive of the rig as a run does, and lets it go. No drive gets power; but each starts
/// its communication anew, so that another program loses it. Throws InputError where a bus cannot be opened.
Findings check_drives(const RigFile& of, RigHardware& hardware, const NextTick& next_tick);

/// Whether none of them is a problem.
bool is_fit(const Findings& findings);
/// A line for each, the problems last: those are what somebody has to read.
void print_findings(const Findings& findings, std::FILE* file);
void write_findings_json(const Findings& findings, const std::optional<WakeLatency>& latency,
                         std::FILE* file);

/// What a rig asks of a bus.
struct BusNeeds {
  std::int64_t bitrate = 1'000'000;
  std::optional<std::int64_t> data_bitrate{};  ///< of drives that speak CAN FD
  std::int64_t frames_per_tick = 0;            ///< that are sent at once
};

/// `link` is nothing where there is no such CAN interface; `needs` where no rig says any.
Findings check_bus(const std::string& name, const std::optional<can::CanLink>& link,
                   const std::optional<BusNeeds>& needs);

/// The kernel, the clock, the frequency of the processors, wireless interfaces.
Findings check_machine(const MachineFacts& facts);
/// The rights of a real-time thread, one finding each.
Findings check_rights(std::span<const RealTimeRight> rights);

/// Wakes up `rate_hz` times a second for so long, with the rights that the calling thread has.
WakeLatency measure_wake_latency(double seconds, std::int32_t rate_hz);
/// A tick that comes a quarter of its period late leaves the bus little time.
Finding judge(const WakeLatency& latency, std::int32_t rate_hz);

}  // namespace inbetween
