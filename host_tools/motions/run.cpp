#include "host_tools/motions/run.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/files/diagnostics.hpp"
#include "host_tools/loop/loop_preparations.hpp"
#include "host_tools/loop/rig_loop.hpp"
#include "host_tools/loop/run_record.hpp"
#include "host_tools/motions/approach.hpp"
#include "host_tools/motions/run_checks.hpp"
#include "host_tools/motions/staged_move.hpp"
#include "host_tools/motions/start_signal.hpp"
#include "host_tools/motions/transport.hpp"
#include "host_tools/reference/axis_positions.hpp"
#include "host_tools/reference/rig_reference.hpp"
#include "host_tools/rig/cue_outputs.hpp"
#include "host_tools/rig/rig_watch.hpp"

namespace inbetween {
namespace {

/// Without real-time rights a late tick makes the smaller a jump the slower the rig is.
constexpr double jitter_rate = 0.1;

/// A line of the rig that begins something.
struct WiredSignal {
  RigInputs* lines = nullptr;
  bool (RigInputs::*has_come)() = nullptr;
  bool start_triggered(std::int64_t /*now_ns*/) { return (lines->*has_come)(); }
};

/// A move on a rig whose lines and drives are there, from before anything is switched on until nothing is on
/// any more. What the loop has played last goes with this, after the last tick.
class Run {
 public:
  Run(RigLoop& rig, StagedMove& staged, std::unique_ptr<CueOutputs> cues, const RunOptions& options)
      : rig_(rig),
        staged_(staged),
        cues_(std::move(cues)),
        options_(options),
        trigger_{&rig.lines(), &RigInputs::start_triggered},
        camera_{&rig.lines(), &RigInputs::camera_asks},
        rate_hz_(rig.rig().rate_hz) {
    report_.reason = options.shoot ? "every frame was shot" : "the move was played to its last frame";
    if (options.record) record_ = std::make_unique<RunRecord>(*options.record, rig.rig(), options.fast);
  }
  ~Run() { rig_.end(); }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  /// The drives are switched off again, whatever happens.
  void play() {
    rig_.start(options_.audience, "move at a tenth of the drawn speed", record_.get());
    play_started();
    rig_.end();
  }
  /// The drives were on.
  [[nodiscard]] bool was_armed() const { return was_armed_; }
  /// When it ended.
  [[nodiscard]] bool power_was_cut() const { return power_was_cut_; }
  /// Once it was played.
  [[nodiscard]] RunReport report() {
    report_.late_ticks = rig_.late_ticks();
    report_.wake_latency = rig_.latency();
    for (std::size_t a = 0; a < rig_.axes().size(); ++a) {
      const RigAxis& axis = rig_.rig().axes[a];
      const AxisTrace& traced = rig_.axes()[a];
      report_.axes.push_back({axis.name, std::string(to_string(axis.unit)), traced.commanded, traced.actual,
                              traced.following_error_peak});
    }
    if (record_) report_.record = record_->finish();
    report_.counts = rig_.drives().counts();
    if (cues_) {
      report_.counts.pulses = counts_of(cues_->counters());
      for (Counted& chip : cues_->chip_counts()) report_.counts.chips.push_back(std::move(chip));
    }
    return std::move(report_);
  }

 private:
  [[nodiscard]] bool is_attended() const { return static_cast<bool>(options_.audience.keys); }

  void play_started() {
    try {
      if (arm() && go_to_start()) perform_move();
    } catch (...) {
      disarm();
      throw;
    }
    const SupervisorState state = rig_.loop().state();
    power_was_cut_ = state == SupervisorState::faulted || state == SupervisorState::cut_off;
    end_cues();
    const std::string trouble = rig_.trouble();
    if (!trouble.empty() && report_.ending != Ending::finished) {
      report_.ending = Ending::fault;
      report_.reason = trouble;
    }
    disarm();
  }

  bool arm() {
    Arming arming(rig_.loop());
    rig_.perform(act_of(arming, true));
    positions_ = arming.positions();
    was_armed_ = rig_.loop().state() == SupervisorState::ready;
    if (was_armed_) return true;
    report_.ending = Ending::stopped;
    report_.reason = "the drives were not switched on";
    return false;
  }

  bool go_to_start() {
    approach_ = allowed_approach(staged_.plan(), positions_, static_cast<bool>(options_.confirm));
    if (!approach_) return true;
    if (!options_.confirm(describe_approach(*approach_))) {
      report_.ending = Ending::stopped;
      report_.reason = "nobody agreed that the rig goes to the start of the move";
      return false;
    }
    refuse_changed_rig(rig_.rig().path, options_.audience.rig_has_changed);
    way_ = std::make_unique<StagedMove>(*approach_);
    Transport transport(rig_.loop(), *way_, is_attended());
    return perform(transport);
  }

  void perform_move() {
    refuse_changed_rig(rig_.rig().path, options_.audience.rig_has_changed);
    const std::int64_t last = staged_.plan().played().last_tick_at(rate_hz_);
    if (options_.shoot) {
      // A camera that asks by its line is waited for; one that cannot is taken to be ready for the next
      // frame.
      const std::optional<Camera>& wired = rig_.rig().camera;
      const bool asks_by_line = !rig_.is_simulated() && wired && wired->asks;
      SimulatedCamera camera(!is_attended() && !asks_by_line);
      ShootingLines lines{.cues = cues_.get()};
      if (asks_by_line) lines.asks = start_signal_of(camera_);
      Shooting shooting(rig_.loop(), staged_, camera, shoot_spec(*options_.shoot, rate_hz_), is_attended(),
                        lines);
      perform(shooting);
      report_.exposures = shooting.exposures();
    } else {
      TransportLines lines{.cues = cues_.get()};
      if (staged_.plan().move().start == Start::trigger) {
        lines.start = rig_.is_simulated() ? start_signal_of(simulated_trigger_) : start_signal_of(trigger_);
      }
      Transport transport(rig_.loop(), staged_, is_attended(), lines);
      perform(transport, last);
    }
    if (cues_) cues_->finish(options_.audience.interrupted);
    if (options_.audience.progress) options_.audience.progress(last, last);
  }

  /// Whether it came to its end.
  template <class Performance>
  bool perform(Performance& performance, std::optional<std::int64_t> last = std::nullopt) {
    const ActEnd end = rig_.perform(act_of(performance), last);
    report_.ticks = end.ticks + 1;
    Arriving arriving(rig_.loop(), rate_hz_);
    rig_.perform(act_of(arriving, true));
    if (end.begun && performance.is_done()) return true;
    report_.ending = end.begun ? Ending::stopped : Ending::fault;
    report_.reason = end.begun ? "the move was stopped before its end" : end.begun.error().what;
    if (performance.keys().has_lost_time()) {
      report_.ending = Ending::fault;
      report_.reason =
          "a tick came so late that an axis would have jumped, and the rig was stopped on its path";
    }
    return false;
  }

  void end_cues() {
    if (!cues_) return;
    report_.cue_log = cues_->end_log();
    const std::string trouble = cues_->trouble();
    if (trouble.empty() || report_.ending != Ending::finished) return;
    report_.ending = Ending::fault;
    report_.reason = trouble;
  }

  void disarm() {
    Disarming disarming(rig_.loop(), rate_hz_);
    rig_.perform(act_of(disarming, true));
  }

  RigLoop& rig_;
  StagedMove& staged_;
  std::unique_ptr<CueOutputs> cues_;  // null where the rig has no outputs
  const RunOptions& options_;
  SimulatedTrigger simulated_trigger_;
  WiredSignal trigger_, camera_;
  std::unique_ptr<RunRecord> record_;
  std::optional<Plan> approach_;
  std::unique_ptr<StagedMove> way_;
  std::int32_t rate_hz_;
  std::vector<double> positions_;
  RunReport report_;
  bool was_armed_ = false;
  bool power_was_cut_ = false;
};

/// Before anything is switched on it is written down that the axes of the move move; afterwards, and also
/// where the run was refused on the way, where they rest.
RunReport run_referenced(RigLoop& rig, RigReference& reference, StagedMove& staged,
                         std::unique_ptr<CueOutputs> cues, const RunOptions& options) {
  if (cues && rig.drives().steps() != nullptr) cues->go_with(*rig.drives().steps());
  if (options.cue_log) {
    if (!cues) {
      throw InputError({rig.rig().path, 0, 0},
                       fmt::format("the rig {} has no outputs; leave out --cue-log, or add an [output.NAME]",
                                   in_quotes(rig.rig().name)));
    }
    cues->log_to(*options.cue_log, options.fast);
  }
  reference.place(rig.drives());
  Run run(rig, staged, std::move(cues), options);
  reference.about_to_move(staged.loop_spec().drive_of);
  const auto keep = [&] {
    if (run.was_armed()) {
      reference.at_rest(rig.drives(), rig.loop().drive_states(), run.power_was_cut());
    } else {
      reference.has_not_moved();
    }
  };
  try {
    run.play();
  } catch (...) {
    rig.end();
    keep();
    throw;
  }
  keep();
  return run.report();
}

/// As the plan says: in a track at the start of the move, else parked.
std::vector<double> planned_positions(const Plan& plan) {
  std::vector<double> moving(plan.played().axis_count());
  plan.played().positions({plan.played().first_frame(), 0}, moving);
  std::vector<double> positions;
  for (std::size_t a = 0; a < plan.axes().size(); ++a) {
    const PlanAxis& axis = plan.axes()[a];
    positions.push_back(axis.track ? moving[axis.move_axis] : parked(plan.rig()->axes[a]));
  }
  return positions;
}

}  // namespace

RunReport run_simulated(const Plan& plan, const RunOptions& options) {
  const RigFile& rig_file = *plan.rig();
  const std::unique_ptr<StagedMove> staged =
      checked_move(plan, options.top_rate, options.repeat, options.shoot);
  const std::vector<double> standing =
      standing_positions(rig_file, planned_positions(plan), options.standing);
  RigReference reference = reference_of(rig_file, options.positions, true);
  reference.refuse_unreferenced(staged->loop_spec().drive_of);
  // What nobody can agree to is refused before the drives are switched on.
  if (!options.positions) {
    static_cast<void>(allowed_approach(plan, standing, static_cast<bool>(options.confirm)));
  }
  const std::unique_ptr<RigLoop> rig = RigLoop::simulated(rig_file, standing, options.fast);
  rig->drives().set_faults(options.faults);
  const Move<double>& move = plan.played();
  return run_referenced(*rig, reference, *staged,
                        CueOutputs::simulated(plan.move(), rig_file, move.first_frame(), move.last_frame()),
                        options);
}

RunReport run_on_rig(const Plan& plan, const RunOptions& options) {
  const RigFile& rig_file = *plan.rig();
  const bool in_real_time = !options.allow_jitter;
  const double top_rate = in_real_time ? options.top_rate : jitter_rate;
  const std::unique_ptr<StagedMove> staged = checked_move(plan, top_rate, options.repeat, options.shoot);
  RigReference reference = reference_of(rig_file, options.positions, false);
  reference.refuse_unreferenced(staged->loop_spec().drive_of);
  const std::unique_ptr<RigLoop> rig = RigLoop::on_rig(rig_file, in_real_time);
  const Move<double>& move = plan.played();
  return run_referenced(
      *rig, reference, *staged,
      CueOutputs::on_chips(plan.move(), rig_file, move.first_frame(), move.last_frame(), in_real_time),
      options);
}

}  // namespace inbetween
