#include "host_tools/loop/rig_session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "host_tools/loop/loop_preparations.hpp"
#include "host_tools/reference/axis_positions.hpp"
#include "host_tools/rig/machine_hardware.hpp"
#include "host_tools/rig/simulated_hardware.hpp"
#include "inbetween/loop/tick_time.hpp"

namespace inbetween {
namespace {

/// Copies what the drives tell on a tick, for threads other than that of the loop.
class Looking final : public Preparation {
 public:
  explicit Looking(RunLoop& loop)
      : Preparation(loop), states_(loop.drive_states().size()), told_(loop.setpoints().size()) {}
  void tick(std::int32_t ticks, std::int64_t now_ns) override {
    state_ = loop_.tick(ticks, now_ns).state;
    std::ranges::copy(loop_.drive_states(), states_.begin());
    std::ranges::copy(loop_.setpoints(), told_.begin());
    has_looked_ = true;
  }
  [[nodiscard]] bool is_over() const override { return has_looked_; }

  [[nodiscard]] const std::vector<DriveState>& states() const { return states_; }
  [[nodiscard]] double told(std::size_t axis) const { return told_[axis].position; }
  /// Setpoints have ceased, and nobody has acknowledged it.
  [[nodiscard]] bool has_ceased() const {
    return state_ == SupervisorState::faulted || state_ == SupervisorState::cut_off;
  }

 private:
  std::vector<DriveState> states_;
  std::vector<Setpoint> told_;
  SupervisorState state_ = SupervisorState::disarmed;
  bool has_looked_ = false;
};

/// The places of the axes of a simulated rig.
std::vector<double> standing(const RigFile& rig, const RigReference& reference,
                             const SessionOptions& options) {
  std::vector<double> positions;
  positions.reserve(rig.axes.size());
  for (std::size_t a = 0; a < rig.axes.size(); ++a) {
    positions.push_back(reference.counted_position(a).value_or(parked(rig.axes[a])));
  }
  return standing_positions(rig, std::move(positions), options.standing);
}

std::unique_ptr<RigHardware> hardware_of(const RigFile& rig, const SessionOptions& options,
                                         const std::vector<double>& standing) {
  if (options.simulated) {
    auto hardware = std::make_unique<SimulatedHardware>(rig, standing, options.faults);
    if (options.steps) hardware->log_steps(*options.steps, options.fast);
    return hardware;
  }
  refuse_falling_axes(rig);
  refuse_unavailable_lines(rig);
  return std::make_unique<MachineHardware>(rig, !options.allow_jitter);
}

}  // namespace

// The lines come first: what is taken for outputs changes on the way.
RigSession::RigSession(const RigFile& rig, RigReference& reference, const SessionOptions& options)
    : rig_(rig),
      reference_(reference),
      options_(options),
      positions_(standing(rig, reference, options)),
      hardware_(hardware_of(rig, options, positions_)),
      lines_(rig, *hardware_),
      drives_(rig, *hardware_),
      storage_(rig.axes.size(), rig.axes.size()),
      loop_(drives_, lines_, storage_.memory()),
      record_(options.record ? std::make_unique<RunRecord>(*options.record, rig, options.fast) : nullptr),
      trace_(rig.axes.size(), {record_.get(), options.take}) {
  reference.place(drives_);
  start();
}

void RigSession::start() {
  if (options_.fast) {
    fast_.emplace(loop_, rig_.rate_hz, options_.audience, trace_);
    return;
  }
  Lateness lateness = Lateness::time_stands_still;
  std::optional<RealTimeRequest> request;
  if (!options_.simulated) {
    lateness = drives_.steps() != nullptr ? Lateness::falls_behind : Lateness::catches_up;
    request = RealTimeRequest{};
  }
  timed_.emplace(loop_, rig_.rate_hz, options_.audience, trace_, lateness, request);
  if (!options_.simulated && !options_.allow_jitter) refuse_unfit_machine(rig_.path, timed_->rights());
}

RigSession::~RigSession() {
  end();
}

ActEnd RigSession::perform(LoopTask& act, std::optional<std::int64_t> last) {
  return fast_ ? fast_->run(act, last) : timed_->run(act, last);
}

/// Once: the drives are the same however often they are switched on.
void RigSession::tell_notes() {
  if (std::exchange(has_told_notes_, true)) return;
  for (const std::string& note : drives_.notes()) fmt::print(stderr, "{}\n", note);
}

bool RigSession::arm() {
  is_armed_ = true;
  Arming arming(loop());
  perform(arming);
  tell_notes();
  positions_ = arming.positions();
  if (loop().state() != SupervisorState::ready) return false;
  reference_.compare(drives_, positions_);
  return true;
}

std::string RigSession::rest() {
  Arriving arriving(loop(), rig().rate_hz);
  perform(arriving);
  Looking looking(loop());
  perform(looking);
  for (std::size_t a = 0; a < positions_.size(); ++a) positions_[a] = looking.states()[a].actual;
  reference_.at_rest(drives_, looking.states(), looking.has_ceased());
  for (std::size_t a = 0; a < positions_.size(); ++a) {
    const DriveState& drive = looking.states()[a];
    if (drive.is_in_position || drive.own_stop != OwnStop::none) continue;
    const RigAxis& axis = rig_.axes[a];
    const double off = looking.told(a) - drive.actual;
    return fmt::format(
        "{} has not arrived: it stands at {:.6g} {}, {:.3g} {} from where it was told to be (in_position = "
        "{:.3g}), and its drive tells no fault; look for what holds it",
        named(axis), drive.actual, to_string(axis.unit), off, to_string(axis.unit),
        follow_limits_of(axis.drive).value_or(FollowLimits{}).in_position);
  }
  return "";
}

void RigSession::keep(const std::vector<DriveState>& states) {
  reference_.at_rest(drives_, states, false);
}

void RigSession::disarm() {
  if (!is_armed_) return;
  is_armed_ = false;
  Disarming disarming(loop());
  perform(disarming);
}

std::string RigSession::use(const std::function<void()>& task) {
  try {
    task();
  } catch (const std::exception& error) {
    disarm();
    reference_.forget_restarted(drives_);
    const std::string on = drives_.left_on();
    if (on.empty()) throw;
    throw PowerLeftError(std::string(error.what()) + "\n" + on);
  }
  disarm();
  reference_.forget_restarted(drives_);
  return drives_.left_on();
}

void RigSession::end() {
  disarm();
  if (timed_) {
    latency_ = timed_->latency();
    late_ticks_ = timed_->late_ticks();
  }
  timed_.reset();
  fast_.reset();
}

std::optional<LoopLogEnd> RigSession::end_record() {
  if (!record_) return std::nullopt;
  return record_->finish();
}

std::int64_t RigSession::delay_ns() const {
  // A drive reaches the setpoint of a tick at the next one; steps begin a tick later.
  return ns_per_s / rig_.rate_hz * (drives_.steps() != nullptr ? 2 : 1);
}

std::string RigSession::trouble() const {
  const std::string trouble = lines_.trouble();
  return trouble.empty() ? drives_.trouble() : trouble;
}

SetupEnd end_of(RigSession& session, const std::function<SetupEnd()>& task) {
  SetupEnd end;
  const std::string on = session.use([&] { end = task(); });
  if (on.empty()) return end;
  end.reason = end.is_done ? on : end.reason + ". And " + on;
  end.is_done = false;
  return end;
}

std::string reason_of(const RigSession& session, const std::string& otherwise) {
  const std::string trouble = session.trouble();
  return trouble.empty() ? otherwise : trouble;
}

}  // namespace inbetween
