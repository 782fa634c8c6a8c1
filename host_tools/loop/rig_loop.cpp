#include "host_tools/loop/rig_loop.hpp"

#include <utility>

#include "host_tools/rig/rig_chips.hpp"
#include "inbetween/loop/tick_time.hpp"

namespace inbetween {

RigLoop::RigLoop(const RigFile& rig, std::unique_ptr<RigInputs> lines, std::unique_ptr<RigDrives> drives)
    : rig_(rig),
      lines_(std::move(lines)),
      drives_(std::move(drives)),
      room_(rig.axes.size(), rig.axes.size()),
      loop_(*drives_, *lines_, room_.memory()) {}

std::unique_ptr<RigLoop> RigLoop::simulated(const RigFile& rig, const std::vector<double>& positions,
                                            bool is_fast) {
  std::unique_ptr<RigLoop> loop(
      new RigLoop(rig, RigInputs::simulated(rig, positions), RigDrives::simulated(rig, positions)));
  loop->lines_->follow(*loop->drives_);
  loop->is_fast_ = is_fast;
  return loop;
}

std::unique_ptr<RigLoop> RigLoop::on_rig(const RigFile& rig, bool in_real_time) {
  refuse_unavailable_lines(rig);
  // The lines come first: what is taken for outputs changes on the way.
  std::unique_ptr<RigInputs> lines = RigInputs::on_chips(rig);
  std::unique_ptr<RigLoop> loop(new RigLoop(rig, std::move(lines), RigDrives::on_rig(rig, in_real_time)));
  loop->is_simulated_ = false;
  loop->in_real_time_ = in_real_time;
  return loop;
}

void RigLoop::start(const LoopAudience& audience, const char* otherwise, RunRecord* record) {
  audience_ = audience;
  trace_.emplace(rig_.axes.size(), record);
  if (is_fast_) {
    fast_.emplace(loop_, rig_.rate_hz, audience_, *trace_);
    return;
  }
  Lateness lateness = Lateness::time_stands_still;
  std::optional<RealTimeWishes> wishes;
  if (!is_simulated_) {
    lateness = drives_->steps() != nullptr ? Lateness::falls_behind : Lateness::catches_up;
    wishes = RealTimeWishes{};
  }
  timed_.emplace(loop_, rig_.rate_hz, audience_, *trace_, lateness, wishes);
  if (in_real_time_) refuse_unfit_machine(rig_.path, timed_->rights(), otherwise);
}

ActEnd RigLoop::perform(const LoopTask& act, std::optional<std::int64_t> last) {
  return fast_ ? fast_->run(act, last) : timed_->run(act, last);
}

void RigLoop::end() {
  if (timed_) {
    latency_ = timed_->latency();
    late_ticks_ = timed_->late_ticks();
  }
  timed_.reset();
  fast_.reset();
}

std::int64_t RigLoop::delay_ns() const {
  // What is written on a tick is reached at the next; steps begin a tick later.
  return ns_per_s / rig_.rate_hz * (drives_->steps() != nullptr ? 2 : 1);
}

std::string RigLoop::trouble() const {
  const std::string trouble = lines_->trouble();
  return trouble.empty() ? drives_->trouble() : trouble;
}

}  // namespace inbetween
