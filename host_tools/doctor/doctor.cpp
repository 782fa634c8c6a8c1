#include "host_tools/doctor/doctor.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host_tools/rig/bus_kind.hpp"
#include "host_tools/rig/machine_hardware.hpp"
#include "host_tools/rig/rig_drives.hpp"
#include "host_tools/rig/step_drives.hpp"
#include "host_tools/rig_model/rig_motors.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/json_writer.hpp"

namespace inbetween {
namespace {

/// A refusal of the program as a finding: its remedy stands behind the last semicolon.
Finding problem_of(const std::string& of, const InputError& error) {
  const std::string text = to_string(error.place()) + ": " + error.message();
  const std::size_t end = text.rfind("; ");
  if (end == std::string::npos) return {.of = of, .verdict = Verdict::problem, .what = text};
  return {.of = of, .verdict = Verdict::problem, .what = text.substr(0, end), .remedy = text.substr(end + 2)};
}

void add_refusal(Findings& findings, const std::string& of, const std::function<void()>& look) {
  try {
    look();
  } catch (const InputError& error) {
    findings.push_back(problem_of(of, error));
  }
}

}  // namespace

Findings check_rig(const RigFile& of) {
  const RigFile rig = motors_of(of).rig;
  Findings findings;
  add_refusal(findings, "rig", [&] { refuse_falling_axes(of); });
  add_refusal(findings, "rig", [&] { refuse_overloaded_buses(rig); });
  add_refusal(findings, "rig", [&] { refuse_step_rates(rig); });
  if (findings.empty()) {
    findings.push_back({.of = "rig", .what = fmt::format("{}, at {} Hz", in_quotes(rig.name), rig.rate_hz)});
  }
  for (const Bus& bus : rig.buses) {
    const BusNeeds needs{.bitrate = bus.bitrate,
                         .data_bitrate = bus.data_bitrate,
                         .frames_per_tick = share_of_bus(rig, bus).frames};
    const Findings of_bus = check_bus(bus.name, can::read_can_link(bus.name), needs);
    findings.insert(findings.end(), of_bus.begin(), of_bus.end());
  }
  const std::vector<InputError> lines = unavailable_lines(of);
  for (const InputError& error : lines) findings.push_back(problem_of("line", error));
  return findings;
}

bool is_fit(const Findings& findings) {
  return std::ranges::none_of(findings,
                              [](const Finding& finding) { return finding.verdict == Verdict::problem; });
}

void print_findings(const Findings& findings, std::FILE* file) {
  for (const Verdict verdict : {Verdict::fine, Verdict::note, Verdict::problem}) {
    for (const Finding& finding : findings) {
      if (finding.verdict != verdict) continue;
      fmt::print(file, "{:8} {}: {}{}{}\n", word_of(verdict), finding.of, finding.what,
                 finding.remedy.empty() ? "" : "; ", finding.remedy);
    }
  }
}

void write_findings_json(const Findings& findings, const std::optional<WakeLatency>& latency,
                         std::FILE* file) {
  JsonWriter json(file);
  json.begin_object();
  json.member("format", 1);
  json.member("fit", is_fit(findings));
  json.line();
  json.objects("findings", findings, [&](const Finding& finding) {
    json.member("verdict", word_of(finding.verdict));
    json.member("of", finding.of);
    json.member("what", finding.what);
    json.member("remedy", finding.remedy);
  });
  if (latency) {
    json.line();
    write_json(*latency, json);
  }
  json.end_object();
  json.finish();
}

}  // namespace inbetween
