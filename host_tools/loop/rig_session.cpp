#include "host_tools/loop/rig_session.hpp"

#include <algorithm>
#include <utility>

#include "host_tools/loop/loop_preparations.hpp"
#include "host_tools/reference/axis_positions.hpp"

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

std::unique_ptr<RigLoop> opened(const RigFile& rig, const RigReference& reference,
                                const SessionOptions& options) {
  if (!options.simulated) return RigLoop::on_rig(rig, !options.allow_jitter);
  std::vector<double> positions;
  positions.reserve(rig.axes.size());
  for (std::size_t a = 0; a < rig.axes.size(); ++a) {
    positions.push_back(reference.position(a).value_or(parked(rig.axes[a])));
  }
  return RigLoop::simulated(rig, standing_positions(rig, std::move(positions), options.standing),
                            options.fast);
}

}  // namespace

RigSession::RigSession(const RigFile& rig, RigReference& reference, const SessionOptions& options)
    : reference_(reference), rig_loop_(opened(rig, reference, options)) {
  reference.place(rig_loop_->drives());
  rig_loop_->start(options.audience, "move slowly");
}

RigSession::~RigSession() {
  disarm();
}

ActEnd RigSession::perform(const LoopTask& act, std::optional<std::int64_t> last) {
  return rig_loop_->perform(act, last);
}

bool RigSession::arm() {
  is_armed_ = true;
  Arming arming(loop());
  perform(act_of(arming, true));
  positions_ = arming.positions();
  return loop().state() == SupervisorState::ready;
}

void RigSession::rest() {
  Arriving arriving(loop(), rig().rate_hz);
  perform(act_of(arriving, true));
  Looking looking(loop());
  perform(act_of(looking, true));
  for (std::size_t a = 0; a < positions_.size(); ++a) positions_[a] = looking.states()[a].actual;
  reference_.at_rest(rig_loop_->drives(), looking.states(), looking.has_ceased());
}

void RigSession::keep(const std::vector<DriveState<double>>& states) {
  reference_.at_rest(rig_loop_->drives(), states, false);
}

void RigSession::disarm() {
  if (!is_armed_) return;
  is_armed_ = false;
  // Something that moves is stopped by the first wish, and switched off by the second.
  for (int wish = 0; wish < 2 && loop().state() != SupervisorState::disarmed; ++wish) {
    Disarming disarming(loop(), rig().rate_hz);
    perform(act_of(disarming, true));
  }
}

std::string reason_of(const RigSession& session, const std::string& otherwise) {
  const std::string trouble = session.trouble();
  return trouble.empty() ? otherwise : trouble;
}

}  // namespace inbetween
