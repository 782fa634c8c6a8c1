
#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "drivers/linux/machine_facts.hpp"
#include "drivers/linux/monotonic_clock.hpp"
#include "drivers/linux/real_time.hpp"
#include "host_tools/cli/command.hpp"
#include "host_tools/doctor/doctor.hpp"
#include "host_tools/rig/machine_hardware.hpp"
#include "host_tools/text/output_file.hpp"
#include "inbetween/loop/tick_time.hpp"

namespace inbetween {
namespace {

struct DoctorArguments {
  std::optional<std::string> rig, json;
  double seconds = 2;
  bool visits_drives = false;
};

void add(Findings& findings, const Findings& more) {
  findings.insert(findings.end(), more.begin(), more.end());
}

Findings check_real_drives(const RigFile& rig) {
  try {
    MachineHardware hardware(rig);
    const MonotonicClock clock;
    std::int64_t deadline_ns = clock.now_ns();
    return check_drives(rig, hardware, [&] {
      clock.sleep_until_ns(deadline_ns += ns_per_s / rig.rate_hz);
      return clock.now_ns();
    });
  } catch (const InputError& error) {
    return {{.of = "drives", .verdict = Verdict::problem, .what = error.what()}};
  }
}

int doctor_command(const DoctorArguments& arguments) {
  if (arguments.visits_drives && !arguments.rig)
    throw UsageError("--drives needs --rig RIG, which names them");
  if (arguments.json) check_output(*arguments.json);
  refuse_outputs_in_one_place({{"--rig", arguments.rig}}, {{"--json", arguments.json}});
  constexpr std::int32_t usual_rate_hz = 250;
  std::optional<RigFile> rig;
  if (arguments.rig) rig = read_rig(*arguments.rig);
  const std::int32_t rate_hz = rig ? rig->rate_hz : usual_rate_hz;
  const MachineFacts facts = read_machine_facts();
  Findings findings = check_machine(facts);
  std::optional<WakeLatency> latency;
  {
    const RealTimeThread thread(RealTimeRequest{});
    add(findings, check_rights(thread.rights()));
    if (arguments.seconds > 0) {
      latency = measure_wake_latency(arguments.seconds, rate_hz);
      findings.push_back(judge(*latency, rate_hz));
    }
  }
  if (rig) {
    const Findings of_rig = check_rig(*rig);
    add(findings, of_rig);
    if (arguments.visits_drives && is_fit(of_rig)) add(findings, check_real_drives(*rig));
  } else {
    for (const std::string& bus : facts.can_interfaces) {
      add(findings, check_bus(bus, can::read_can_link(bus), std::nullopt));
    }
  }
  print_findings(findings, summary_stream(arguments.json == "-"));
  if (arguments.json) {
    write_output(*arguments.json, [&](std::FILE* file) { write_findings_json(findings, latency, file); });
  }
  return is_fit(findings) ? 0 : exit_fault;
}

void describe(CLI::App& app, DoctorArguments& arguments) {
  app.add_option("--rig", arguments.rig, "the rig: its buses and lines are looked at, and its rate counts");
  app.add_flag("--drives", arguments.visits_drives,
               "set up every CiA 402 drive of the rig without power, and let it go; each starts its\n"
               "communication anew, so no other program may use them");
  constexpr double longest_s = 86'400;
  app.add_option("--seconds", arguments.seconds, "how long wake-ups are measured; 0: not at all")
      ->check(between(0.0, longest_s))
      ->capture_default_str();
  app.add_option("--json", arguments.json, "write the findings (- is standard output)");
  app.footer(
      R"(Looks whether this machine can run in real time: kernel, clock, frequency of the processors, the rights of
a real-time thread, how late it wakes up; then the CAN interfaces and the GPIO lines of the rig. Each line is
one finding: fine, note (it runs, but could be better) or problem (run refuses it), and behind the semicolon
what to do. Nothing moves, and without --drives nothing is sent.

Exit status: 0 no problem; 1 bad input; 4 there is a problem.

Examples:
  inbetween doctor
  inbetween doctor --rig rig.toml --seconds 60
  inbetween doctor --rig rig.toml --drives --json doctor.json)");
}

}  // namespace

void add_doctor_command(CLI::App& program, Command& chosen) {
  add_command(program, chosen, {"doctor", "Say whether this machine, and a rig on it, are fit to run"},
              describe, doctor_command);
}

}  // namespace inbetween
