// Drives are set up without power here, and let go.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <variant>
#include <vector>

#include "host_tools/doctor/doctor.hpp"
#include "host_tools/rig/bus_kind.hpp"
#include "host_tools/rig_model/rig_motors.hpp"
#include "inbetween/can/bus_port.hpp"

namespace inbetween {
namespace {

using can::DrivePhase;

/// One bus of the rig with its drives of one protocol.
template <class Kind>
class BusVisit {
 public:
  using Host = typename Kind::Bus::Drive;
  using Frame = typename Kind::Bus::Frame;
  BusVisit(const RigFile& rig, const Bus& bus, RigHardware& hardware, const NextTick& next_tick)
      : rig_(rig), hardware_(hardware), next_tick_(next_tick), axes_(axes_of_kind<Kind>(rig, bus.name)) {
    if (axes_.empty()) return;
    for (const std::size_t a : axes_) hosts_.push_back(Kind::host_of(rig.axes[a], rig.rate_hz));
    bus_.emplace(Kind::bus_of(hosts_, rig.rate_hz, rig.axes[axes_.front()]));
    link_ = hardware.open_bus<Frame>(bus.name, axes_);
    in_.resize(can::frames_per_read(axes_.size()));
    out_.resize(Kind::Bus::frames_per_tick(axes_.size()));
  }

  Findings make() {
    if (axes_.empty()) return {};
    link_->drain();
    now_ns_ = next_tick_();
    for (Host& host : hosts_) host.connect(now_ns_);
    tick_while([](const Host& host) {
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
    for (Host& host : hosts_) host.disable(now_ns_);
    tick_while([](const Host& host) { return host.phase() == DrivePhase::disabling; });
    for (Host& host : hosts_) host.leave(now_ns_);
    tick_while([](const Host& host) { return host.phase() == DrivePhase::leaving; });
  }

  [[nodiscard]] Finding finding_of(std::size_t i) const {
    const Host& host = hosts_[i];
    const RigAxis& axis = rig_.axes[axes_[i]];
    Finding finding{.of = named(axis)};
    if (host.counters().stray_answers + host.counters().duplicates > 0) {
      finding.verdict = Verdict::problem;
      finding.what =
          fmt::format("two devices answer as node {}", std::get<typename Kind::InRig>(axis.drive).node);
      finding.remedy = "give each device of the bus a node number of its own";
      return finding;
    }
    if (host.first_finding() || host.phase() != DrivePhase::idle) {
      const auto words = can::words_of(host.first_finding().value_or(can::DriveFinding::never_booted));
      finding.verdict = Verdict::problem;
      finding.what = words.what;
      if (host.first_finding()) finding.what += Kind::detail_of(host, *host.first_finding());
      finding.remedy = words.remedy;
      return finding;
    }
    finding.what = Kind::fitness_of(host, rig_.rate_hz);
    const std::vector<std::string> lacks = Kind::lacks_of(host);
    if (lacks.empty()) return finding;
    finding.verdict = Verdict::note;
    for (const std::string& lack : lacks) finding.what += "; " + lack;
    return finding;
  }

  const RigFile& rig_;
  RigHardware& hardware_;
  const NextTick& next_tick_;
  std::int64_t now_ns_ = 0;
  std::vector<std::size_t> axes_;
  std::vector<Host> hosts_;
  std::optional<typename Kind::Bus> bus_;
  std::unique_ptr<BusLink<Frame>> link_;
  std::vector<Frame> in_, out_;
};

}  // namespace

Findings check_drives(const RigFile& of, RigHardware& hardware, const NextTick& next_tick) {
  const RigFile rig = motors_of(of).rig;
  Findings findings;
  for (const Bus& bus : rig.buses) {
    for_each_bus_kind([&]<class Kind>() {
      const Findings of_bus = BusVisit<Kind>(rig, bus, hardware, next_tick).make();
      findings.insert(findings.end(), of_bus.begin(), of_bus.end());
    });
  }
  return findings;
}

}  // namespace inbetween
