#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <string_view>

#include "drivers/linux/monotonic_clock.hpp"
#include "host_tools/doctor/doctor.hpp"
#include "inbetween/loop/tick_time.hpp"

namespace inbetween {
namespace {

Finding check_kernel(const MachineFacts& facts) {
  Finding finding{.of = "kernel",
                  .what = facts.kernel.empty() ? "it does not tell its version" : facts.kernel};
  if (facts.is_real_time_kernel || facts.kernel.find("PREEMPT_RT") != std::string::npos) return finding;
  finding.verdict = Verdict::note;
  finding.what += ", which is no real-time kernel: a tick may be milliseconds late under load";
  finding.remedy =
      "install one (Debian: apt install linux-image-rt-ARCHITECTURE), or leave the machine alone "
      "while the rig moves";
  return finding;
}

Finding check_clock(const std::string& source) {
  Finding finding{.of = "clock", .what = source};
  constexpr std::array<std::string_view, 4> slow{"hpet", "acpi_pm", "jiffies", "refined-jiffies"};
  if (std::ranges::find(slow, source) == slow.end()) return finding;
  finding.verdict = Verdict::note;
  finding.what += ", which takes microseconds to read";
  finding.remedy = "see in the kernel's log (dmesg) why it does not trust tsc";
  return finding;
}

Finding check_governors(const MachineFacts& facts) {
  std::vector<std::string> slow;
  for (const NamedSetting& governor : facts.governors) {
    if (governor.setting != "performance") slow.push_back(governor.name + " " + governor.setting);
  }
  if (slow.empty()) return {.of = "processor frequency", .what = "does not change by itself"};
  return {.of = "processor frequency",
          .verdict = Verdict::note,
          .what = fmt::format("changes with the load ({})", fmt::join(slow, ", ")),
          .remedy = "as root: echo performance | tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor"};
}

}  // namespace

Findings check_machine(const MachineFacts& facts) {
  Findings findings{check_kernel(facts)};
  if (facts.clock_source) findings.push_back(check_clock(*facts.clock_source));
  findings.push_back(check_governors(facts));
  for (const std::string& interface : facts.wireless) {
    findings.push_back({.of = "network",
                        .verdict = Verdict::note,
                        .what = interface + " is wireless: some of their drivers hold a processor for long",
                        .remedy = "ip link set " + interface + " down, while the rig moves"});
  }
  return findings;
}

Findings check_rights(std::span<const RealTimeRight> rights) {
  Findings findings;
  for (const RealTimeRight& right : rights) {
    Finding finding{.of = right.name, .what = "given"};
    if (right.refusal) {
      finding.verdict = right.is_needed ? Verdict::problem : Verdict::note;
      finding.what = right.refusal->what;
      finding.remedy = right.refusal->remedy;
    }
    findings.push_back(std::move(finding));
  }
  return findings;
}

WakeLatency measure_wake_latency(double seconds, std::int32_t rate_hz) {
  const MonotonicClock clock;
  const auto counter = std::make_unique<WakeLatencyCounter>();
  const auto ticks = static_cast<std::int64_t>(seconds * rate_hz);
  const std::int64_t start_ns = clock.now_ns();
  for (std::int64_t tick = 1; tick <= ticks; ++tick) {
    const std::int64_t deadline_ns = start_ns + tick * ns_per_s / rate_hz;
    clock.sleep_until_ns(deadline_ns);
    const std::int64_t now_ns = clock.now_ns();
    counter->add(now_ns - deadline_ns, now_ns);
  }
  return counter->summary();
}

Finding judge(const WakeLatency& latency, std::int32_t rate_hz) {
  const double quarter_us = 0.25e6 / rate_hz;
  Finding finding{
      .of = "wake-up",
      .what = fmt::format("at {} Hz half within {:.0f} us, 99.9 % within {:.0f} us, the worst {:.0f} us",
                          rate_hz, latency.p50_us, latency.p99_9_us, latency.max_us)};
  if (latency.max_us <= quarter_us) return finding;
  finding.verdict = Verdict::note;
  finding.what += fmt::format(", more than a quarter of a tick ({:.0f} us)", quarter_us);
  finding.remedy = "free the machine of other work, see to the lines above, or lower rate_hz";
  return finding;
}

}  // namespace inbetween
