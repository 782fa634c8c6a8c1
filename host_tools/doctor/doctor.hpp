// Whether a rig can run on this machine, as far as can be said before its drives have power.
#pragma once

#include <cstdint>
#include <cstdio>
#include <functional>
#include <optional>

#include "host_tools/doctor/finding.hpp"
#include "host_tools/loop/wake_latency.hpp"
#include "host_tools/rig/rig_hardware.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

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

}  // namespace inbetween
