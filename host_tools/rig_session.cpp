#include "host_tools/rig_session.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host_tools/diagnostics.hpp"
#include "host_tools/loop_preparations.hpp"
#include "host_tools/rig_chips.hpp"
#include "inbetween/tick_time.hpp"

namespace inbetween {
namespace {

/// What the drives tell on a tick, for whoever is not the thread of the loop.
class Looking {
 public:
  explicit Looking(RunLoop& loop) : loop_(loop), states_(loop.drive_states().size()) {}
  static Status begin() { return Done{}; }
  void press(TransportKey) {}
  void tick(std::int32_t ticks, std::int64_t now_ns) {
    state_ = loop_.tick(ticks, now_ns).state;
    std::ranges::copy(loop_.drive_states(), states_.begin());
    has_looked_ = true;
  }
  [[nodiscard]] bool is_over() const { return has_looked_; }
  [[nodiscard]] RunSnapshot snapshot() const { return {.state = loop_.state()}; }

  [[nodiscard]] const std::vector<DriveState<double>>& states() const { return states_; }
  /// Setpoints have ceased, and nobody has acknowledged it.
  [[nodiscard]] bool has_ceased() const {
    return state_ == SupervisorState::faulted || state_ == SupervisorState::cut_off;
  }

 private:
  RunLoop& loop_;
  std::vector<DriveState<double>> states_;
  SupervisorState state_ = SupervisorState::disarmed;
  bool has_looked_ = false;
};

std::vector<double> standing_positions(const RigFile& rig, const RigReference& reference,
                                       std::map<std::string, double> said) {
  std::vector<double> positions;
  positions.reserve(rig.axes.size());
  for (std::size_t a = 0; a < rig.axes.size(); ++a) {
    const RigAxis& axis = rig.axes[a];
    positions.push_back(reference.position(a).value_or(std::clamp(0.0, axis.min, axis.max)));
    if (const auto found = said.extract(axis.name)) positions.back() = found.mapped();
  }
  if (!said.empty()) static_cast<void>(axis_named(rig, said.begin()->first));
  return positions;
}

}  // namespace

std::size_t axis_named(const RigFile& rig, const std::string& name) {
  for (std::size_t a = 0; a < rig.axes.size(); ++a) {
    if (rig.axes[a].name == name) return a;
  }
  std::vector<std::string> names;
  names.reserve(rig.axes.size());
  for (const RigAxis& axis : rig.axes) names.push_back(axis.name);
  throw InputError({rig.path, 0, 0},
                   fmt::format("the rig {} has no axis {}; name one of {}", in_quotes(rig.name),
                               in_quotes(name), comma_separated(names)));
}

RigSession::RigSession(const RigFile& rig, RigReference& reference, const SessionOptions& options)
    : rig_(rig), reference_(reference), audience_(options.audience), trace_(rig.axes.size()) {
  if (options.simulated) {
    const std::vector<double> standing = standing_positions(rig, reference, options.standing);
    lines_ = RigLines::simulated(rig, standing);
    drives_ = RigDrives::simulated(rig, standing);
    lines_->follow(*drives_);
  } else {
    refuse_unavailable_lines(rig);
    // The lines come first: what is taken for outputs changes on the way.
    lines_ = RigLines::on_chips(rig);
    drives_ = RigDrives::on_rig(rig, !options.allow_jitter);
  }
  reference.place(*drives_);
  room_ = std::make_unique<LoopRoom>(rig.axes.size(), rig.axes.size());
  loop_.emplace(*drives_, *lines_, room_->memory());
  if (options.fast) {
    fast_.emplace(*loop_, rig.rate_hz, audience_, trace_);
    return;
  }
  Lateness lateness = Lateness::time_stands_still;
  std::optional<RealTimeWishes> wishes;
  if (!options.simulated) {
    lateness = drives_->steps() != nullptr ? Lateness::falls_behind : Lateness::catches_up;
    wishes = RealTimeWishes{};
  }
  timed_.emplace(*loop_, rig.rate_hz, audience_, trace_, lateness, wishes);
  if (!options.allow_jitter) refuse_unfit_machine(rig.path, timed_->rights(), "move slowly");
}

RigSession::~RigSession() {
  disarm();
}

ActEnd RigSession::perform(const LoopAct& act, std::optional<std::int64_t> last) {
  return fast_ ? fast_->run(act, last) : timed_->run(act, last);
}

bool RigSession::arm() {
  is_armed_ = true;
  Arming arming(*loop_);
  perform(act_of(arming, true));
  positions_ = arming.positions();
  return loop_->state() == SupervisorState::ready;
}

void RigSession::rest() {
  Arriving arriving(*loop_, rig_.rate_hz);
  perform(act_of(arriving, true));
  Looking looking(*loop_);
  perform(act_of(looking, true));
  for (std::size_t a = 0; a < positions_.size(); ++a) positions_[a] = looking.states()[a].actual;
  reference_.at_rest(*drives_, looking.states(), looking.has_ceased());
}

void RigSession::keep(const std::vector<DriveState<double>>& states) {
  reference_.at_rest(*drives_, states, false);
}

void RigSession::disarm() {
  if (!is_armed_) return;
  is_armed_ = false;
  // Something that moves is stopped by the first wish, and switched off by the second.
  for (int wish = 0; wish < 2 && loop_->state() != SupervisorState::disarmed; ++wish) {
    Disarming disarming(*loop_, rig_.rate_hz);
    perform(act_of(disarming, true));
  }
}

std::string RigSession::trouble() const {
  const std::string trouble = lines_->trouble();
  return trouble.empty() ? drives_->trouble() : trouble;
}

std::int64_t RigSession::delay_ns() const {
  // What is written on a tick is reached at the next; steps begin a tick later.
  return ns_per_s / rig_.rate_hz * (drives_->steps() != nullptr ? 2 : 1);
}

std::string reason_of(const RigSession& session, const std::string& otherwise) {
  const std::string trouble = session.trouble();
  return trouble.empty() ? otherwise : trouble;
}

}  // namespace inbetween
