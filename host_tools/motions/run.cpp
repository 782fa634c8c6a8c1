#include "host_tools/motions/run.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "host_tools/loop/manual_motion.hpp"
#include "host_tools/motions/run_checks.hpp"
#include "host_tools/motions/run_take.hpp"
#include "host_tools/motions/staged_move.hpp"
#include "host_tools/motions/start_signal.hpp"
#include "host_tools/motions/transport.hpp"
#include "host_tools/plan/key_frames.hpp"
#include "host_tools/rig/cue_outputs.hpp"
#include "host_tools/rig/rig_watch.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/frame_range.hpp"

namespace inbetween {
namespace {

/// Without real-time rights a late tick makes the smaller a jump the slower the rig is.
constexpr double jitter_rate = 0.1;

/// The outputs of the rig; null where it has none.
std::unique_ptr<CueOutputs> opened_cues(const Plan& plan, RigSession& session, const RunOptions& options) {
  const RigFile& rig = session.rig();
  const WholeFrames line{plan.played().first_frame(), plan.played().last_frame()};
  std::unique_ptr<CueOutputs> cues =
      CueOutputs::open(plan.move(), rig, line, plan.part(), session.hardware());
  if (cues && session.drives().steps() != nullptr) cues->go_with(*session.drives().steps());
  if (!options.cue_log) return cues;
  if (!cues) {
    throw InputError({rig.path, 0, 0},
                     fmt::format("the rig {} has no outputs; leave out --cue-log, or add an [output.NAME]",
                                 in_quotes(rig.name)));
  }
  if (options.turns && options.turns->goes_round) cues->count_frames_of_turns(options.turns->frames);
  cues->log_to(*options.cue_log, session.options().fast);
  return cues;
}

SessionOptions recorded_to(TickSink* take, SessionOptions rig) {
  rig.take = take;
  return rig;
}

/// When the keys of the first track are met, of turns those of one.
std::vector<double> keys_to_go_to(const Plan& plan, const std::optional<PlayedTurns>& turns) {
  std::vector<double> frames = key_frames_of(plan, 0);
  if (plan.move().tracks.front().closed) frames.pop_back();  // its return to key 0
  if (turns) frames.resize(frames.size() / static_cast<std::size_t>(turns->turns));
  return frames;
}

/// A move on a rig. What the loop has played goes with this, after the last tick.
class Run {
 public:
  Run(StagedMove& staged, RigReference& reference, const SessionOptions& rig, const RunOptions& options)
      : staged_(staged),
        reference_(reference),
        options_(options),
        recorder_(options.has_takes ? nullptr : begun_take(staged, rig, options)),
        session_(*staged.plan().rig(), reference, recorded_to(recorder_.get(), rig)),
        cues_(opened_cues(staged.plan(), session_, options)),
        audience_(session_.options().audience) {
    const Plan& plan = staged.plan();
    if (cues_) {
      cues_->tell([this](std::size_t pulse) {
        if (recorder_) recorder_->pulse(pulse);
      });
    }
    report_.reason = "the move was played to its last frame";
    if (plan.names_frames() && !options.shoot) report_.played = plan.part();
    if (!plan.is_whole()) {
      report_.reason = frames_in_words(plan.part(), plan.move().frames) + " were played";
    }
    if (options.follow) report_.reason = options.follow->name + " was played again, up to where it rested";
    if (options.shoot && options.shoot->log) shoot_log_.emplace(*options.shoot->log, session_.options().fast);
  }

  /// The drives are switched off again, whatever happens.
  RunReport play() {
    const std::string on = session_.use([&] {
      const DisarmAtEnd disarm(session_);
      if (arm() && go_to_start()) perform_move();
      end_cues();
      const std::string trouble = session_.trouble();
      if (!trouble.empty() && report_.ending != Ending::finished) end_by(Ending::fault, trouble);
    });
    if (!on.empty()) {
      end_by(Ending::fault, report_.ending == Ending::finished ? on : report_.reason + ". And " + on);
    }
    session_.end();
    report_.late_ticks = session_.late_ticks();
    report_.wake_latency = session_.latency();
    for (std::size_t a = 0; a < session_.axes().size(); ++a) {
      const RigAxis& axis = session_.rig().axes[a];
      const AxisTrace& traced = session_.axes()[a];
      report_.axes.push_back({axis.name, std::string(to_string(axis.unit)), traced.commanded, traced.actual,
                              traced.following_error_peak, traced.is_known, traced.is_commanded});
    }
    report_.record = session_.end_record();
    if (recorder_) report_.kept = ended_take(report_.reason, report_.ending == Ending::finished);
    report_.steps = session_.hardware().end_step_log();
    report_.counts = session_.drives().counts();
    if (cues_) {
      report_.counts.pulses = counts_of(cues_->counters());
      for (Counted& chip : cues_->chip_counts()) report_.counts.chips.push_back(std::move(chip));
    }
    return std::move(report_);
  }

 private:
  [[nodiscard]] bool is_attended() const { return static_cast<bool>(audience_.keys); }
  [[nodiscard]] bool is_simulated() const { return session_.options().simulated; }

  void end_by(Ending ending, std::string reason) {
    report_.ending = ending;
    report_.reason = std::move(reason);
  }

  bool arm() {
    if (session_.arm()) return true;
    end_by(Ending::stopped, "the drives were not switched on");
    return false;
  }

  bool go_to_start() {
    const std::vector<GoTarget> away = away_from_start(
        staged_.plan(), session_.positions(), staged_.playhead().time(), session_.options().as_arguments);
    if (away.empty()) return true;
    refuse_unagreed_transit(staged_.plan(), away.front().axis, static_cast<bool>(audience_.confirm));
    Transit& transit = transit_.emplace(session_.rig(), away, session_.positions(), options_.start_share);
    if (!audience_.confirm(transit.describe("the rig is not where the move starts:"))) {
      end_by(Ending::stopped, "nobody agreed that the rig goes to the start of the move");
      return false;
    }
    ManualMotion motion(session_.loop(), transit.loop_spec(), "going to the start", transit.ticks());
    return perform(motion, transit.axes());
  }

  void perform_move() {
    const double rate = options_.shoot ? 1 : staged_.playhead().override_rate();
    const auto drawn = static_cast<double>(staged_.plan().played().last_tick_at(session_.rig().rate_hz));
    const auto last = static_cast<std::int64_t>(std::ceil(drawn / rate));
    if (options_.shoot) {
      shoot();
    } else {
      TransportLines lines{.cues = cues_.get(), .turns = options_.turns};
      if (options_.follow) lines.followed = options_.follow->places;
      if (is_attended()) lines.key_frames = keys_to_go_to(staged_.plan(), options_.turns);
      if (staged_.plan().move().start == Start::trigger) {
        lines.start = [&](std::int64_t) { return session_.lines().start_triggered(); };
        if (is_simulated()) lines.start = SimulatedTrigger();
      }
      Transport transport(session_.loop(), staged_, is_attended(), lines);
      if (options_.has_takes) {
        play_takes(transport);
      } else {
        const bool is_done = perform(transport, staged_.loop_spec().drive_of, last);
        if (!is_done && report_.ending == Ending::stopped) tell_turn(transport);
      }
    }
    if (cues_) cues_->finish(audience_.interrupted);
    if (audience_.progress) audience_.progress(last, last);
  }

  /// What goes round has no end before which it could be stopped.
  void tell_turn(const Transport& transport) {
    const std::optional<TurnSnapshot> turn = transport.turn();
    if (!turn || turn->of > 0) return;
    report_.reason =
        fmt::format("stopped in turn {}, on frame {:.1f}", turn->turn, transport.snapshot().frame);
  }

  /// The name of the record of a take; nothing where none is wanted.
  [[nodiscard]] std::optional<std::string> file_of(std::int32_t take) const {
    return options_.take_record ? std::optional(numbered(*options_.take_record, take)) : std::nullopt;
  }

  /// The take of the next number on that is free: no record is written over.
  void open_take(std::int32_t& take, Transport& transport) {
    refuse_changed_rig(session_.rig().path, audience_.rig_has_changed);
    while (file_of(take) && std::filesystem::exists(*file_of(take))) ++take;
    report_.takes.push_back({.number = take, .file = file_of(take)});
    if (const auto file = file_of(take)) {
      take_record_ = std::make_unique<RunRecord>(*file, session_.rig(), session_.options().fast);
    }
    recorder_ = begun_take(staged_, session_.options(), options_);
    transport.take_is_ready(session_.trace(), {take_record_.get(), recorder_.get()});
  }

  void close_take(bool is_whole) {
    report_.takes.back().is_whole = is_whole;
    if (take_record_) report_.takes.back().record = take_record_->finish();
    take_record_.reset();
    if (!recorder_) return;
    report_.takes.back().kept =
        ended_take(is_whole ? "the move was played to its last frame" : "not played to its end", is_whole);
  }

  KeptTake ended_take(const std::string& ending, bool is_whole) {
    KeptTake kept = recorder_->finish(ending, is_whole, session_.trouble());
    recorder_.reset();
    return kept;
  }

  void play_takes(Transport& transport) {
    transport.play_takes();
    reference_.about_to_move(staged_.loop_spec().drive_of);
    std::int32_t take = 1;
    bool is_open = false;
    ActEnd end;
    for (bool goes_on = true; goes_on;) {
      end = session_.perform(transport);
      report_.ticks += end.ticks;
      const Transport::Ask asks = transport.asks();
      goes_on = end.begun && asks != Transport::Ask::none;
      if (asks == Transport::Ask::begin_take) {
        open_take(take, transport);
        ++take;
        is_open = true;
      } else if (asks == Transport::Ask::end_take) {
        close_take(transport.was_whole());
        transport.take_is_noted();
        is_open = false;
      }
    }
    if (is_open) close_take(transport.was_whole());
    const std::string unreached = session_.rest();
    end_takes(end, transport);
    if (!unreached.empty() && report_.ending == Ending::finished) end_by(Ending::fault, unreached);
  }

  void end_takes(const ActEnd& end, const Transport& transport) {
    const std::string counted_takes = counted(static_cast<std::int64_t>(report_.takes.size()), "take");
    if (!end.begun) {
      end_by(Ending::fault, end.begun.error().what);
    } else if (transport.is_done()) {
      report_.reason = fmt::format("{} played, and left", counted_takes);
    } else {
      end_by(Ending::stopped, fmt::format("{} begun, and the move was stopped in it", counted_takes));
    }
  }

  void shoot() {
    // A camera that asks by its line is waited for; one that cannot is taken to be ready for the next frame.
    const std::optional<Camera>& wired = session_.rig().camera;
    const bool asks_by_line = !is_simulated() && wired && wired->asks;
    SimulatedCamera camera(!is_attended() && !asks_by_line);
    ShootingLines lines{.cues = cues_.get(), .log = shoot_log_ ? &*shoot_log_ : nullptr};
    if (asks_by_line) lines.asks = [&](std::int64_t) { return session_.lines().camera_asks(); };
    Shooting shooting(session_.loop(), staged_, camera, *options_.shoot, is_attended(), lines);
    const bool is_done = perform(shooting, staged_.loop_spec().drive_of);
    report_.exposures = shooting.exposures();
    report_.shoot = shooting.count();
    if (shoot_log_) report_.shoot_log = shoot_log_->finish();
    if (!is_done) return;
    report_.reason =
        report_.shoot->has_all() ? "every frame was shot" : "the shoot was ended with frames missing";
  }

  /// Whether it came to its end.
  template <class Performance>
  bool perform(Performance& performance, std::span<const std::size_t> axes,
               std::optional<std::int64_t> last = std::nullopt) {
    refuse_changed_rig(session_.rig().path, audience_.rig_has_changed);
    reference_.about_to_move(axes);
    const ActEnd end = session_.perform(performance, last);
    report_.ticks = end.ticks + 1;
    const std::string unreached = session_.rest();
    if (end.begun && performance.is_done()) {
      if (unreached.empty()) return true;
      end_by(Ending::fault, unreached);
      return false;
    }
    if (performance.keys().has_lost_time()) {
      end_by(Ending::fault,
             "a tick came so late that an axis would have jumped, and the rig was stopped on its path");
    } else if (end.begun) {
      end_by(Ending::stopped, "the move was stopped before its end");
    } else {
      end_by(Ending::fault, end.begun.error().what);
    }
    return false;
  }

  void end_cues() {
    if (!cues_) return;
    report_.cue_log = cues_->end_log();
    const std::string trouble = cues_->trouble();
    if (!trouble.empty() && report_.ending == Ending::finished) end_by(Ending::fault, trouble);
  }

  StagedMove& staged_;
  RigReference& reference_;
  const RunOptions& options_;
  std::optional<Transit> transit_;
  // The loop's thread writes to these, and ends before.
  std::unique_ptr<RunRecord> take_record_;
  std::unique_ptr<TakeRecorder> recorder_;
  RigSession session_;
  std::unique_ptr<CueOutputs> cues_;
  std::optional<ShootLog> shoot_log_;
  const LoopAudience& audience_;
  RunReport report_;
};

/// Simulated axes of a track stand where the move starts, if nothing else is known or said.
SessionOptions standing_at_start(StagedMove& staged, const RigReference& reference, SessionOptions rig) {
  const Plan& plan = staged.plan();
  std::vector<double> start(plan.played().axis_count());
  plan.motion().positions(staged.playhead().time(), start);
  for (std::size_t d = 0; d < start.size(); ++d) {
    const std::size_t a = plan.axis_of(d);
    if (!reference.position(a)) rig.standing.try_emplace(plan.axes()[a].name, start[d]);
  }
  return rig;
}

}  // namespace

RunReport run(const Plan& plan, const SessionOptions& rig, const RunOptions& options) {
  if (options.shoot) {
    const std::int32_t first = shot_frames(plan.move(), *options.shoot).first;
    const ShootCount before = ShootCount::of(first, shots_before(plan.move(), *options.shoot));
    if (before.has_all()) {
      RunReport report;
      report.reason = "every frame was shot before";
      report.shoot = before;
      return report;
    }
  }
  const double top_rate = rig.allow_jitter ? jitter_rate : options.top_rate;
  const std::unique_ptr<StagedMove> staged = options.shoot ? checked_shoot(plan, top_rate, *options.shoot)
                                                           : checked_move(plan, top_rate, options.repeat);
  if (options.rate < staged->playhead().override_rate()) {
    value_or_throw(staged->playhead().set_override(options.rate));
  }
  if (options.follow) refuse_to_follow(*options.follow, *staged);
  RigReference reference = reference_of(*plan.rig(), options.positions, rig.simulated);
  reference.refuse_unreferenced(staged->loop_spec().drive_of);
  return Run(*staged, reference, standing_at_start(*staged, reference, rig), options).play();
}

}  // namespace inbetween
