#include "host_tools/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "host_tools/approach.hpp"
#include "host_tools/json_writer.hpp"
#include "host_tools/loop_preparations.hpp"
#include "host_tools/loop_room.hpp"
#include "host_tools/loop_runner.hpp"
#include "host_tools/rig_chips.hpp"
#include "host_tools/rig_cues.hpp"
#include "host_tools/rig_reference.hpp"
#include "host_tools/rig_watch.hpp"
#include "host_tools/staged_move.hpp"
#include "host_tools/start_signal.hpp"
#include "host_tools/transport.hpp"

namespace inbetween {
namespace {

/// Without real-time rights a late tick makes the smaller a jump the slower the rig is.
constexpr double jitter_rate = 0.1;

/// Where a simulated axis stands before anything moves it: as near to 0 as its limits allow.
double parked(const RigAxis& axis) {
  return std::clamp(0.0, axis.min, axis.max);
}

void refuse_unknown_axis(const Plan& plan, const std::string& name) {
  for (const RigAxis& axis : plan.rig()->axes) {
    if (axis.name == name) return;
  }
  throw InputError({plan.rig()->path, 0, 0}, fmt::format("the rig {} has no axis {}; name one of its axes",
                                                         in_quotes(plan.rig()->name), in_quotes(name)));
}

void refuse_beyond_highest_rate(const Plan& plan, const CheckReport& report, double top_rate) {
  if (top_rate <= std::max(report.highest_rate, 1.0)) return;
  throw LimitError(
      plan.move().frames_place,
      fmt::format("at {:g} times the drawn speed the move leaves the limits of the rig; up to {:.3f} "
                  "times it does not",
                  top_rate, std::floor(report.highest_rate * 1000) / 1000));
}

/// Where the axes of the rig stand: at the start of the move, those in no track where they are parked, unless
/// somebody says otherwise. Throws InputError for a name that is no axis.
std::vector<double> standing_positions(const Plan& plan, std::map<std::string, double> said) {
  std::vector<double> moving(plan.played().axis_count());
  plan.played().positions({plan.played().first_frame(), 0}, moving);
  std::vector<double> positions;
  for (std::size_t a = 0; a < plan.axes().size(); ++a) {
    const PlanAxis& axis = plan.axes()[a];
    positions.push_back(axis.track ? moving[axis.move_axis] : parked(plan.rig()->axes[a]));
    if (const auto found = said.extract(axis.name)) positions.back() = found.mapped();
  }
  if (!said.empty()) refuse_unknown_axis(plan, said.begin()->first);
  return positions;
}

void refuse_positions_beyond_limits(const Plan& plan) {
  const Move<double>& move = plan.played();
  const std::int64_t last = move.last_tick_at(plan.rig()->rate_hz);
  std::vector<double> positions(move.axis_count());
  for (std::int64_t tick = 0; tick <= last; ++tick) {
    const FrameTime<double> when = move.time_of_tick(tick, plan.rig()->rate_hz);
    move.positions(when, positions);
    for (std::size_t d = 0; d < positions.size(); ++d) {
      if (positions[d] >= plan.limits()[d].min() && positions[d] <= plan.limits()[d].max()) continue;
      const std::size_t a = plan.axis_of(d);
      const RigAxis& axis = plan.rig()->axes[a];
      throw LimitError(
          plan.place_of(a),
          fmt::format("axis {} would go to {} {} at frame {:.2f}, outside {}..{} of the rig {}; "
                      "move its keys inward",
                      in_quotes(axis.name), positions[d], to_string(axis.unit), when.frame + when.fraction,
                      axis.min, axis.max, in_quotes(plan.rig()->name)));
    }
  }
}

/// A line of the rig that begins something.
struct WiredSignal {
  RigLines* lines = nullptr;
  bool (RigLines::*has_come)() = nullptr;
  bool start_triggered(std::int64_t /*now_ns*/) { return (lines->*has_come)(); }
};

/// The motion loop with its memory.
struct LoopOfRig {
  std::unique_ptr<RigLines> lines;
  std::unique_ptr<RigDrives> drives;
  std::unique_ptr<RigCues> cues;  // null where the rig has no outputs
  SimulatedTrigger simulated_trigger;
  WiredSignal trigger, camera;
  bool is_simulated = true;
  LoopRoom room;
  RunLoop loop;
  // The loop refers to what it has played last.
  std::optional<Plan> approach;
  std::unique_ptr<StagedMove> way;
  bool was_armed = false;      ///< the drives were on
  bool power_was_cut = false;  ///< when the run ended

  // The lines come first: what is taken for outputs changes on the way.
  LoopOfRig(std::unique_ptr<RigLines> inputs, std::unique_ptr<RigDrives> outputs, std::size_t axes)
      : lines(std::move(inputs)),
        drives(std::move(outputs)),
        room(axes, axes),
        loop(*drives, *lines, room.memory()) {}
  LoopOfRig(const LoopOfRig&) = delete;
  LoopOfRig& operator=(const LoopOfRig&) = delete;
};

/// The slow way to the start; nothing where the rig stands there. Throws InputError where nobody can agree.
std::optional<Plan> allowed_approach(const Plan& plan, const std::vector<double>& actual,
                                     const RunOptions& options) {
  std::optional<Plan> approach = plan_approach(plan, actual);
  if (!approach) return approach;
  refuse_positions_beyond_limits(*approach);
  if (options.confirm) return approach;
  throw InputError(
      {plan.move().path, 0, 0},
      fmt::format("axis {} of the rig is not where the move starts; bring it there, or agree to let "
                  "it go there slowly (--yes)",
                  in_quotes(approach->move().tracks.front().axes.front())));
}

/// A run from the moment that the drives are switched on.
template <class Runner>
class Run {
 public:
  Run(Runner& runner, LoopOfRig& rig, StagedMove& staged, const RunOptions& options, RunReport& report)
      : runner_(runner),
        rig_(rig),
        staged_(staged),
        options_(options),
        report_(report),
        rate_hz_(staged.plan().rig()->rate_hz) {}

  /// The drives are switched off again, whatever happens.
  void play() {
    try {
      if (arm() && go_to_start()) perform_move();
    } catch (...) {
      disarm();
      throw;
    }
    rig_.power_was_cut =
        rig_.loop.state() == SupervisorState::faulted || rig_.loop.state() == SupervisorState::cut_off;
    end_cues();
    std::string trouble = rig_.lines->trouble();
    if (trouble.empty()) trouble = rig_.drives->trouble();
    if (!trouble.empty() && report_.ending != Ending::finished) {
      report_.ending = Ending::fault;
      report_.reason = trouble;
    }
    disarm();
  }

 private:
  [[nodiscard]] bool is_attended() const { return static_cast<bool>(options_.keys); }

  bool arm() {
    Arming arming(rig_.loop);
    runner_.run(act_of(arming, true), std::nullopt);
    positions_ = arming.positions();
    rig_.was_armed = rig_.loop.state() == SupervisorState::ready;
    if (rig_.was_armed) return true;
    report_.ending = Ending::stopped;
    report_.reason = "the drives were not switched on";
    return false;
  }

  bool go_to_start() {
    rig_.approach = allowed_approach(staged_.plan(), positions_, options_);
    if (!rig_.approach) return true;
    if (!options_.confirm(describe_approach(*rig_.approach))) {
      report_.ending = Ending::stopped;
      report_.reason = "nobody agreed that the rig goes to the start of the move";
      return false;
    }
    refuse_changed_rig(staged_.plan().rig()->path, options_.rig_has_changed);
    rig_.way = std::make_unique<StagedMove>(*rig_.approach);
    Transport transport(rig_.loop, *rig_.way, is_attended());
    return perform(transport, std::nullopt);
  }

  void perform_move() {
    refuse_changed_rig(staged_.plan().rig()->path, options_.rig_has_changed);
    const std::int64_t last = staged_.plan().played().last_tick_at(rate_hz_);
    if (options_.shoot) {
      // A camera that asks by its line is waited for; one that cannot is taken to be ready for the next
      // frame.
      const std::optional<Camera>& wired = staged_.plan().rig()->camera;
      const bool asks_by_line = !rig_.is_simulated && wired && wired->asks;
      SimulatedCamera camera(!is_attended() && !asks_by_line);
      ShootingLines lines{.cues = rig_.cues.get()};
      if (asks_by_line) lines.asks = start_signal_of(rig_.camera);
      Shooting shooting(rig_.loop, staged_, camera, shoot_spec(*options_.shoot, rate_hz_), is_attended(),
                        lines);
      perform(shooting, std::nullopt);
      report_.exposures = shooting.exposures();
    } else {
      TransportLines lines{.cues = rig_.cues.get()};
      if (staged_.plan().move().start == Start::trigger) {
        lines.start =
            rig_.is_simulated ? start_signal_of(rig_.simulated_trigger) : start_signal_of(rig_.trigger);
      }
      Transport transport(rig_.loop, staged_, is_attended(), lines);
      perform(transport, last);
    }
    if (rig_.cues) rig_.cues->finish(options_.interrupted);
    if (options_.progress) options_.progress(last, last);
  }

  /// Whether it came to its end.
  template <class Performance>
  bool perform(Performance& performance, std::optional<std::int64_t> last) {
    const ActEnd end = runner_.run(act_of(performance), last);
    report_.ticks = end.ticks + 1;
    Arriving arriving(rig_.loop, rate_hz_);
    runner_.run(act_of(arriving, true), std::nullopt);
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
    if (!rig_.cues) return;
    report_.cue_log = rig_.cues->end_log();
    const std::string trouble = rig_.cues->trouble();
    if (trouble.empty() || report_.ending != Ending::finished) return;
    report_.ending = Ending::fault;
    report_.reason = trouble;
  }

  void disarm() {
    Disarming disarming(rig_.loop, rate_hz_);
    runner_.run(act_of(disarming, true), std::nullopt);
  }

  Runner& runner_;
  LoopOfRig& rig_;
  StagedMove& staged_;
  const RunOptions& options_;
  RunReport& report_;
  std::int32_t rate_hz_;
  std::vector<double> positions_;
};

template <class Runner>
void run_with(Runner& runner, LoopOfRig& rig, StagedMove& staged, const RunOptions& options,
              RunReport& report) {
  Run<Runner>(runner, rig, staged, options, report).play();
  report.late_ticks = runner.late_ticks();
  report.wake_latency = runner.latency();
}

const char* name_of(Ending ending) {
  switch (ending) {
    case Ending::finished:
      return "finished";
    case Ending::stopped:
      return "stopped";
    case Ending::fault:
      return "fault";
  }
  return "fault";
}

}  // namespace

namespace {

/// What is checked before anything is opened. Throws what run_simulated says.
std::unique_ptr<StagedMove> staged_for_run(const Plan& plan, const RunOptions& options, double top_rate) {
  const CheckReport checked = check(plan);
  refuse_beyond_limits(checked);
  refuse_positions_beyond_limits(plan);
  refuse_beyond_highest_rate(plan, checked, top_rate);
  std::vector<std::string> still;
  if (options.shoot) still = options.shoot->still;
  for (const std::string& axis : still) refuse_unknown_axis(plan, axis);
  auto staged = std::make_unique<StagedMove>(plan, top_rate, still);
  staged->set_repeat(options.repeat);
  if (options.shoot) refuse_exposures(*staged, shoot_spec(*options.shoot, plan.rig()->rate_hz));
  return staged;
}

void list_axes(const Plan& plan, const LoopTrace& trace, RunReport& report) {
  for (std::size_t a = 0; a < trace.axes().size(); ++a) {
    const RigAxis& axis = plan.rig()->axes[a];
    const AxisTrace& traced = trace.axes()[a];
    report.axes.push_back({axis.name, std::string(to_string(axis.unit)), traced.commanded, traced.actual,
                           traced.following_error_peak});
  }
}

RunReport good_report(const RunOptions& options) {
  RunReport report;
  report.reason = options.shoot ? "every frame was shot" : "the move was played to its last frame";
  return report;
}

std::unique_ptr<RunRecord> record_of(const Plan& plan, const RunOptions& options) {
  if (!options.record) return nullptr;
  return std::make_unique<RunRecord>(*options.record, *plan.rig(), options.fast);
}

LoopAudience audience_of(const RunOptions& options) {
  return {options.keys, options.interrupted, options.status, options.progress, options.rig_has_changed};
}

/// Before anything is switched on it is written down that these axes move; afterwards, and also where the run
/// was refused on the way, where they rest.
template <class Performance>
RunReport run_referenced(LoopOfRig& rig, RigReference& reference, std::span<const std::size_t> axes,
                         const Performance& perform) {
  reference.place(*rig.drives);
  reference.about_to_move(axes);
  const auto keep = [&] {
    if (rig.was_armed) {
      reference.at_rest(*rig.drives, rig.loop.drive_states(), rig.power_was_cut);
    } else {
      reference.has_not_moved();
    }
  };
  try {
    RunReport report = perform();
    keep();
    return report;
  } catch (...) {
    keep();
    throw;
  }
}

void set_cues(LoopOfRig& rig, std::unique_ptr<RigCues> cues, const Plan& plan, const RunOptions& options) {
  rig.cues = std::move(cues);
  if (rig.cues && rig.drives->steps() != nullptr) rig.cues->go_with(*rig.drives->steps());
  if (!options.cue_log) return;
  if (!rig.cues) {
    throw InputError({plan.rig()->path, 0, 0},
                     fmt::format("the rig {} has no outputs; leave out --cue-log, or add an [output.NAME]",
                                 in_quotes(plan.rig()->name)));
  }
  rig.cues->log_to(*options.cue_log, options.fast);
}

}  // namespace

RunReport run_simulated(const Plan& plan, const RunOptions& options) {
  const RigFile& rig_file = *plan.rig();
  const std::unique_ptr<StagedMove> staged = staged_for_run(plan, options, options.top_rate);
  const std::vector<double> standing = standing_positions(plan, options.standing);
  RigReference reference = reference_of(rig_file, options.positions, true);
  const std::span<const std::size_t> axes = staged->loop_spec().drive_of;
  reference.refuse_unreferenced(axes);
  // What nobody can agree to is refused before the drives are switched on.
  if (!options.positions) static_cast<void>(allowed_approach(plan, standing, options));
  LoopOfRig rig(RigLines::simulated(rig_file, standing), RigDrives::simulated(rig_file, standing),
                plan.axes().size());
  rig.lines->follow(*rig.drives);
  rig.drives->set_faults(options.faults);
  const Move<double>& played = plan.played();
  set_cues(rig, RigCues::simulated(plan.move(), rig_file, played.first_frame(), played.last_frame()), plan,
           options);
  return run_referenced(rig, reference, axes, [&] {
    const std::unique_ptr<RunRecord> record = record_of(plan, options);
    LoopTrace trace(plan.axes().size(), record.get());
    const LoopAudience audience = audience_of(options);
    RunReport report = good_report(options);
    if (options.fast) {
      FastRunner runner(rig.loop, rig_file.rate_hz, audience, trace);
      run_with(runner, rig, *staged, options, report);
    } else {
      TimedRunner runner(rig.loop, rig_file.rate_hz, audience, trace, Lateness::time_stands_still,
                         std::nullopt);
      run_with(runner, rig, *staged, options, report);
    }
    list_axes(plan, trace, report);
    if (record) report.record = record->finish();
    return report;
  });
}

RunReport run_on_rig(const Plan& plan, const RunOptions& options) {
  const RigFile& rig_file = *plan.rig();
  const double top_rate = options.allow_jitter ? jitter_rate : options.top_rate;
  const std::unique_ptr<StagedMove> staged = staged_for_run(plan, options, top_rate);
  RigReference reference = reference_of(rig_file, options.positions, false);
  const std::span<const std::size_t> axes = staged->loop_spec().drive_of;
  reference.refuse_unreferenced(axes);
  refuse_unavailable_lines(rig_file);
  std::unique_ptr<RigLines> lines = RigLines::on_chips(rig_file);
  LoopOfRig rig(std::move(lines), RigDrives::on_rig(rig_file, !options.allow_jitter), plan.axes().size());
  rig.is_simulated = false;
  rig.trigger = {rig.lines.get(), &RigLines::start_triggered};
  rig.camera = {rig.lines.get(), &RigLines::camera_asks};
  const Move<double>& played = plan.played();
  set_cues(rig,
           RigCues::on_chips(plan.move(), rig_file, played.first_frame(), played.last_frame(),
                             !options.allow_jitter),
           plan, options);
  return run_referenced(rig, reference, axes, [&] {
    const std::unique_ptr<RunRecord> record = record_of(plan, options);
    LoopTrace trace(plan.axes().size(), record.get());
    const LoopAudience audience = audience_of(options);
    const Lateness lateness = rig.drives->steps() != nullptr ? Lateness::falls_behind : Lateness::catches_up;
    RunReport report = good_report(options);
    {
      TimedRunner runner(rig.loop, rig_file.rate_hz, audience, trace, lateness, RealTimeWishes{});
      if (!options.allow_jitter)
        refuse_unfit_machine(rig_file.path, runner.rights(), "move at a tenth of the drawn speed");
      run_with(runner, rig, *staged, options, report);
    }
    list_axes(plan, trace, report);
    if (record) report.record = record->finish();
    return report;
  });
}

void write_run_json(const RunReport& report, std::FILE* file) {
  JsonWriter json(file);
  json.begin_object();
  json.member("format", 1);
  json.member("ended", name_of(report.ending));
  json.member("reason", report.reason);
  json.member("ticks", report.ticks);
  json.member("late_ticks", report.late_ticks);
  if (report.exposures) json.member("exposures", *report.exposures);
  if (report.record) {
    json.key("record");
    json.begin_object();
    json.member("ticks", report.record->written);
    json.member("lost", report.record->lost);
    json.member("why", report.record->why);
    json.end_object();
  }
  json.line();
  json.key("axes");
  json.begin_array();
  for (const RunAxis& axis : report.axes) {
    json.line();
    json.begin_object();
    json.member("name", axis.name);
    json.member("last_commanded", axis.last_commanded);
    json.member("last_actual", axis.last_actual);
    json.member("following_error_peak", axis.following_error_peak);
    json.end_object();
  }
  json.end_array();
  json.line();
  json.key("wake_latency_us");
  json.begin_object();
  json.member("p50", report.wake_latency.p50_us);
  json.member("p99", report.wake_latency.p99_us);
  json.member("p99_9", report.wake_latency.p99_9_us);
  json.member("max", report.wake_latency.max_us);
  json.member("max_at_s", report.wake_latency.max_at_s);
  json.key("histogram");
  json.begin_array();
  for (const WakeLatency::Bucket& bucket : report.wake_latency.histogram) {
    json.begin_object();
    json.member("below_us", bucket.below_us);
    json.member("ticks", bucket.ticks);
    json.end_object();
  }
  json.end_array();
  json.end_object();
  json.end_object();
  json.finish();
}

}  // namespace inbetween
