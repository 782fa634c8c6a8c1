// Drives are set up without power here, and let go.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <variant>
#include <vector>

#include "host_tools/doctor/doctor.hpp"
#include "host_tools/rig/can_drives.hpp"
#include "inbetween/can/cia402_bus.hpp"
#include "inbetween/can/cia402_port.hpp"

namespace inbetween {
namespace {

using can::DrivePhase;

/// One bus of the rig with its drives.
class BusVisit {
 public:
  BusVisit(const RigFile& rig, const Bus& bus, RigHardware& hardware, const NextTick& next_tick)
      : rig_(rig), hardware_(hardware), next_tick_(next_tick) {
    for (std::size_t a = 0; a < rig.axes.size(); ++a) {
      const RigAxis& axis = rig.axes[a];
      const auto* const drive = std::get_if<Cia402Drive>(&axis.drive);
      if (drive == nullptr || drive->bus != bus.name) continue;
      axes_.push_back(a);
      hosts_.push_back(
          value_or_refuse(can::Cia402Drive::make(settings_of(axis, rig.rate_hz)), axis.place, named(axis)));
    }
    if (axes_.empty()) return;
    const std::int64_t between_ns = hosts_.front().host_timeout_ns() / can::life_time_factor;
    bus_.emplace(value_or_refuse(
        can::Cia402Bus::make(hosts_, {.host = host_node(), .heartbeat_period_ns = between_ns}), bus.place));
    link_ = hardware.open_bus(bus.name, axes_);
    in_.resize(can::frames_per_read(axes_.size()));
    out_.resize(can::Cia402Bus::frames_per_tick(axes_.size()));
  }

  Findings make() {
    if (axes_.empty()) return {};
    link_->drain();
    for (can::Cia402Drive& host : hosts_) host.connect(now_ns_);
    tick_while([](const can::Cia402Drive& host) {
      return host.phase() != DrivePhase::idle && host.phase() != DrivePhase::refused;
    });
    Findings findings;
    for (std::size_t i = 0; i < axes_.size(); ++i) findings.push_back(finding_of(i));
    let_go();
    return findings;
  }

 private:
  void tick() {
    now_ns_ = next_tick_();
    hardware_.advance(now_ns_);
    const std::size_t heard = link_->receive(in_, now_ns_);
    for (std::size_t i = 0; i < heard; ++i) bus_->receive(in_[i], now_ns_);
    const std::size_t count = bus_->tick(now_ns_, {}, out_).value();
    link_->send(std::span(out_).first(count));
  }
  /// Until no drive is so; each phase of a drive is bounded, and so is this, whatever they do.
  template <class IsSo>
  void tick_while(IsSo&& is_so) {
    constexpr std::int64_t longest_s = 30;
    for (std::int64_t left = longest_s * rig_.rate_hz; left > 0 && std::ranges::any_of(hosts_, is_so); --left)
      tick();
  }
  void let_go() {
    for (can::Cia402Drive& host : hosts_) host.disable(now_ns_);
    tick_while([](const can::Cia402Drive& host) { return host.phase() == DrivePhase::disabling; });
    for (can::Cia402Drive& host : hosts_) host.leave(now_ns_);
    tick_while([](const can::Cia402Drive& host) { return host.phase() == DrivePhase::leaving; });
  }

  [[nodiscard]] Finding finding_of(std::size_t i) const {
    const can::Cia402Drive& host = hosts_[i];
    const RigAxis& axis = rig_.axes[axes_[i]];
    Finding finding{.of = named(axis)};
    if (host.counters().stray_answers + host.counters().duplicates > 0) {
      finding.verdict = Verdict::problem;
      finding.what = fmt::format("two devices answer as node {}", host.node().value());
      finding.remedy = "give each device of the bus a node number of its own";
      return finding;
    }
    if (host.first_finding() || host.phase() != DrivePhase::idle) {
      const auto words = can::words_of(host.first_finding().value_or(can::DriveFinding::never_booted));
      finding.verdict = Verdict::problem;
      finding.what = words.what;
      if (host.setup().state() == can::SetupState::refused) {
        finding.what += fmt::format(" ({})", words_of(host.refusal()));
      }
      finding.remedy = words.remedy;
      return finding;
    }
    finding.what = fmt::format("node {} has mode 8, the period of {} Hz and a watchdog of {} ms",
                               host.node().value(), rig_.rate_hz, watchdog_ms(host.setup()));
    const std::vector<std::string> lacks = words_of_lacks(host.setup());
    if (lacks.empty()) return finding;
    finding.verdict = Verdict::note;
    for (const std::string& lack : lacks) finding.what += "; " + lack;
    return finding;
  }
  static std::uint32_t watchdog_ms(const can::SetupRunner& setup) {
    const std::uint32_t host = setup.host_timeout_ms();
    const std::uint32_t setpoint = setup.setpoint_timeout_ms();
    return host == 0 ? setpoint : setpoint == 0 ? host : std::min(host, setpoint);
  }

  const RigFile& rig_;
  RigHardware& hardware_;
  const NextTick& next_tick_;
  std::int64_t now_ns_ = 0;
  std::vector<std::size_t> axes_;
  std::vector<can::Cia402Drive> hosts_;
  std::optional<can::Cia402Bus> bus_;
  std::unique_ptr<BusLink> link_;
  std::vector<can::Frame> in_, out_;
};

}  // namespace

Findings check_drives(const RigFile& rig, RigHardware& hardware, const NextTick& next_tick) {
  Findings findings;
  for (const Bus& bus : rig.buses) {
    const Findings of_bus = BusVisit(rig, bus, hardware, next_tick).make();
    findings.insert(findings.end(), of_bus.begin(), of_bus.end());
  }
  return findings;
}

}  // namespace inbetween
