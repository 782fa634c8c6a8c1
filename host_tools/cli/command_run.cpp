#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "drivers/linux/interrupt_watch.hpp"
#include "drivers/linux/key_terminal.hpp"
#include "drivers/linux/monotonic_clock.hpp"
#include "host_tools/cli/agreement.hpp"
#include "host_tools/cli/command.hpp"
#include "host_tools/cli/held_keys.hpp"
#include "host_tools/cli/run_picture.hpp"
#include "host_tools/cli/run_screen.hpp"
#include "host_tools/cli/setup_arguments.hpp"
#include "host_tools/cli/shoot_arguments.hpp"
#include "host_tools/cli/take_arguments.hpp"
#include "host_tools/loop/rig_session.hpp"
#include "host_tools/motions/run.hpp"
#include "host_tools/plan/turns.hpp"
#include "host_tools/rig/fault_script.hpp"
#include "host_tools/rig/rig_watch.hpp"
#include "host_tools/text/output_file.hpp"

namespace inbetween {
namespace {

struct RunArguments : SetupArguments, ShootArguments, TakeArguments {
  std::string move;
  std::optional<std::string> json, record, cue_log, steps, plot, device;
  PictureStyle style = PictureStyle::light;
  bool loop = false;
  bool ping_pong = false;
  bool takes = false;
  bool latency = false;
  bool yes = false;
  double top_rate = 1;
  double rate = 1;
  double start_share = transit_share;
  std::optional<std::string> faults;
  std::optional<std::int32_t> turns;
};

void refuse_to_play_a_shoot(const RunArguments& arguments) {
  if (!arguments.is_shot()) return;
  if (arguments.top_rate != 1 || arguments.rate != 1) {
    throw UsageError(
        "--rate and --top-rate are for a move that is played; leave them out, or --step and "
        "--shutter");
  }
  if (arguments.ping_pong) {
    throw UsageError("a move that is shot frame by frame is not repeated; leave out --ping-pong");
  }
}

/// Prints the latency in a line, and if it is wanted one line an octave, with a bar if the octave has any
/// ticks.
void print_wake_latency(const RunReport& report, bool has_octaves, std::FILE* out) {
  const WakeLatency& latency = report.wake_latency;
  fmt::print(out,
             "  late ticks {}; woken after {:.0f} us (median), {:.0f} us (99 %), {:.0f} us (worst, {:.1f} s "
             "after the first)\n",
             report.late_ticks, latency.p50_us, latency.p99_us, latency.max_us, latency.max_at_s);
  if (!has_octaves) return;
  std::int64_t max_ticks = 1;
  for (const WakeLatency::Bucket& bucket : latency.histogram) max_ticks = std::max(max_ticks, bucket.ticks);
  constexpr std::int64_t bar_width = 40;
  for (const WakeLatency::Bucket& bucket : latency.histogram) {
    const auto width = static_cast<std::size_t>((bucket.ticks * bar_width + max_ticks - 1) / max_ticks);
    fmt::print(out, "  {:>12.0f} us{:>10} {}\n", bucket.below_us, bucket.ticks, std::string(width, '#'));
  }
}

/// Prints the end of a log. `records` is the word for its lines.
void print_log(const LoopLogEnd& log, const char* records, const std::string& file, std::FILE* out) {
  if (log.lost == 0) {
    fmt::print(out, "  {}: {} {}\n", file == "-" ? "standard output" : file, log.written, records);
    return;
  }
  complain(fmt::format("{}: warning: it holds {} of {} {}: {}; the rig was not held up", file, log.written,
                       log.written + log.lost, records, log.why));
}

/// "frames 0..48: 49 due, 48 shot, 1 of them again, 1 skipped", and where to go on.
void print_shoot(const ShootCount& shoot, bool has_log, std::FILE* out) {
  std::string words =
      fmt::format("frames {}..{}: {} due, {} shot", shoot.first, shoot.last, shoot.due(), shoot.shot);
  if (shoot.shot_again > 0) words += fmt::format(", {} of them again", shoot.shot_again);
  if (shoot.skipped > 0) words += fmt::format(", {} skipped", shoot.skipped);
  if (shoot.left > 0) words += fmt::format(", {} left", shoot.left);
  if (shoot.cut_off > 0) words += fmt::format("; {} cut off by a stop", counted(shoot.cut_off, "exposure"));
  if (has_log && !shoot.has_all()) {
    words += "; go on with --resume";
  } else if (shoot.left > 0) {
    words += fmt::format("; go on with --frames {}..{}", shoot.last - shoot.left + 1, shoot.last);
  }
  fmt::print(out, "  {}\n", words);
}

/// A shoot that came to no fault is done when every frame is there.
int exit_status_of(const RunReport& report, bool is_shot) {
  if (!is_shot || report.ending == Ending::fault) return report.ending == Ending::finished ? 0 : exit_fault;
  return report.shoot && report.shoot->has_all() ? 0 : exit_frames_missing;
}

/// One line about a take: that it is kept, or how much of it.
void print_kept(const KeptTake& kept, const char* indent, std::FILE* out) {
  if (kept.number == 0) return;
  if (kept.lost == 0) {
    fmt::print(out, "{}take {} kept in {} ({})\n", indent, kept.number, kept.file, size_in_words(kept.bytes));
  } else {
    complain(fmt::format("{}: warning: take {} has {} of {} ticks: {}; the rig was not held up", kept.file,
                         kept.number, kept.ticks, kept.ticks + kept.lost, kept.why));
  }
  if (!kept.forgotten.empty()) {
    fmt::print(out, "{}{} forgotten to make room\n", indent,
               counted(static_cast<std::int64_t>(kept.forgotten.size()), "older take"));
  }
}

void print_run_summary(const RunReport& report, const Plan& plan, const RunArguments& arguments,
                       std::FILE* out) {
  const bool names_part = !plan.is_whole() && report.ending != Ending::finished;
  fmt::print(out, "{}{}: {}; {} at {} Hz{}\n", plan.move().name,
             names_part ? ", " + frames_in_words(plan.part(), plan.move().frames) : "", report.reason,
             counted(report.ticks, "tick"), plan.rig()->rate_hz, arguments.fast ? " on a virtual clock" : "");
  if (report.shoot) print_shoot(*report.shoot, arguments.shoot_log.has_value(), out);
  if (!arguments.fast) {
    print_wake_latency(report, arguments.latency, out);
  }
  fmt::print(out, "  {:<16}{:>14}{:>14}{:>24}\n", "axis", "commanded", "actual", "following error, peak");
  for (const RunAxis& axis : report.axes) {
    const auto known = [](double number, bool is_known) {
      return is_known ? fmt::format("{:.4f}", number) : std::string("-");
    };
    fmt::print(out, "  {:<16}{:>14}{:>14}{:>24}  {}\n", axis.name,
               known(axis.last_commanded, axis.is_commanded), known(axis.last_actual, axis.is_known),
               known(axis.following_error_peak, axis.is_commanded), axis.unit);
  }
  for (const RunTake& take : report.takes) {
    fmt::print(out, "  take {}: {}{}\n", take.number, take.is_whole ? "whole" : "not played to its end",
               take.file ? ", " + *take.file : "");
    if (take.record && take.record->lost > 0) print_log(*take.record, "ticks", *take.file, out);
    if (take.kept) print_kept(*take.kept, "    ", out);
  }
  const std::string trouble = trouble_of(report.counts);
  if (!trouble.empty()) fmt::print(out, "  counted: {}\n", trouble);
  if (report.kept) print_kept(*report.kept, "  ", out);
  if (report.record) print_log(*report.record, "ticks", *arguments.record, out);
  if (report.steps) print_log(*report.steps, "edges", *arguments.steps, out);
  if (report.cue_log) print_log(*report.cue_log, "pulses", *arguments.cue_log, out);
  if (report.shoot_log) print_log(*report.shoot_log, "exposures", *arguments.shoot_log, out);
}

struct TurnsOfRun {
  Plan plan;
  std::optional<PlayedTurns> turns = {};
};

std::string turns_in_title(const std::optional<PlayedTurns>& turns) {
  return turns && !turns->goes_round ? ", " + counted(turns->turns, "turn") : "";
}

/// Nobody is there who could press a key.
RunReport play_unattended(const Plan& plan, const RunArguments& arguments, SessionOptions& rig,
                          const RunOptions& options) {
  ProgressBar bar;
  const std::int32_t rate_hz = plan.rig()->rate_hz;
  RunScreen phases("", *plan.rig());
  if (!arguments.fast && !phases.has_terminal()) {
    rig.audience.status = [&](const RunSnapshot& now) { phases.show(now); };
  }
  rig.audience.progress = [&](std::int64_t tick, std::int64_t last) {
    const std::int32_t frame =
        std::min(plan.played().time_of_tick(tick, rate_hz).frame, plan.played().last_frame());
    bar.show(static_cast<double>(tick) / static_cast<double>(last),
             fmt::format("frame {}/{}  {:.1f} s", frame, plan.played().last_frame(),
                         static_cast<double>(tick) / rate_hz));
  };
  return run(plan, rig, options);
}

/// The keys of a tape recorder.
RunReport play_on_screen(const TurnsOfRun& planned, const RunArguments& arguments, SessionOptions& rig,
                         const RunOptions& options) {
  const Plan& plan = planned.plan;
  std::optional<HeldKeys> held;
  if (arguments.device) held.emplace(*arguments.device);
  KeyTerminal terminal;
  RunScreen screen(fmt::format("{} on {}{}{}", plan.move().name, plan.rig()->name,
                               arguments.simulated ? ", simulated" : "", turns_in_title(planned.turns)),
                   *plan.rig());
  screen.take_wheel();
  rig.audience.status = [&](const RunSnapshot& now) { screen.show(now); };
  rig.audience.keys = [&] { return terminal.read() + (held ? held->typed() : ""); };
  if (held) rig.audience.device = [&] { return held->read(MonotonicClock().now_ns()); };
  if (!rig.audience.confirm) {
    rig.audience.confirm = [&](const std::string& question) {
      screen.leave();
      return agrees(terminal, question);
    };
  }
  return run(plan, rig, options);
}

/// What a run keeps, and what it plays again.
struct TakesOfRun {
  std::optional<TakeRequest> kept = {};
  std::optional<FollowedTake> follow = {};
};

RunReport play(const TurnsOfRun& planned, const RunArguments& arguments, const RigWatch& watch,
               const TakesOfRun& takes) {
  const Plan& plan = planned.plan;
  const InterruptWatch interrupts;
  RunOptions options{.turns = planned.turns,
                     .top_rate = arguments.top_rate,
                     .rate = arguments.rate,
                     .start_share = arguments.start_share,
                     .has_takes = arguments.takes,
                     .take_record = arguments.takes ? arguments.record : std::nullopt,
                     .shoot = shoot_options(arguments),
                     .positions = arguments.positions,
                     .cue_log = arguments.cue_log,
                     .take = takes.kept,
                     .follow = takes.follow};
  if (options.shoot) options.shoot->is_loop = arguments.loop || arguments.turns;
  if (arguments.resume) options.shoot->before = read_shoot_log(*arguments.shoot_log, plan.move().frames);
  if (arguments.loop && !is_periodic(plan.move())) options.repeat = Repeat::loop;
  if (arguments.ping_pong) options.repeat = Repeat::ping_pong;
  SessionOptions rig = session_options_of(arguments);
  if (arguments.faults) rig.faults = read_fault_script(*arguments.faults, *plan.rig());
  if (!arguments.takes) rig.record = arguments.record;
  rig.steps = arguments.steps;
  rig.audience.interrupted = &InterruptWatch::asked;
  rig.audience.rig_has_changed = [&] { return watch.has_changed(); };
  if (arguments.yes) {
    rig.audience.confirm = [](const std::string& question) {
      fmt::print(stderr, "{}\n", question);
      return true;
    };
  }
  const bool is_attended = !arguments.fast && KeyTerminal::is_there();
  return is_attended ? play_on_screen(planned, arguments, rig, options)
                     : play_unattended(plan, arguments, rig, options);
}

void refuse_no_camera(const Plan& plan) {
  if (plan.rig()->camera) return;
  throw InputError({plan.rig()->path, 0, 0},
                   fmt::format("the rig {} has no camera; add a [camera] with the line of its shutter, or "
                               "simulate one with --sim",
                               in_quotes(plan.rig()->name)));
}

/// A periodic move that comes back goes round until it is stopped, and one that goes further with every turn
/// as often as the rig has room, which is told before it moves; shot frame by frame, either is one turn.
TurnsOfRun looped(Plan plan, const RunArguments& arguments) {
  const bool is_shot = arguments.is_shot();
  const bool goes_on = is_periodic(plan.move());
  if (is_shot && !goes_on) {
    throw UsageError(
        "a move that is shot frame by frame is not repeated unless it is periodic; leave out --loop");
  }
  if (is_shot || !goes_on) return {std::move(plan)};
  if (arguments.frames) {
    throw UsageError(
        "--loop goes round the whole of a periodic move; leave out --frames, or name frames of --turns K");
  }
  PlayedTurns turns{.frames = plan.move().frames};
  if (comes_back(plan.move())) {
    turns = turns_to_go_round(plan);
    fmt::print(stderr, "{}: --loop goes round until it is stopped\n", plan.move().name);
  } else {
    const FittingTurns fitting = fitting_turns(plan);
    turns.turns = fitting.turns;
    fmt::print(stderr, "{}: --loop plays {}, as many as fit: {}\n", plan.move().name,
               counted(fitting.turns, "turn"), fitting.border);
  }
  return {{turns_of(plan, turns.turns), plan.rig(), {.kinematics = plan.kinematics()}}, turns};
}

/// The screen counts turns where all of them are played: --loop, and --turns K without --frames.
TurnsOfRun planned_turns(const RunArguments& arguments) {
  const bool is_shot = arguments.is_shot();
  // A shoot goes to single frames of the whole move; what is played of it is a move of its own.
  Plan plan = make_plan(
      arguments.move, arguments.rig, Solver::closed_form,
      {.turns = arguments.turns, .frames = is_shot ? FrameRange{} : frame_range_argument(arguments.frames)});
  if (arguments.loop && !arguments.turns) return looped(std::move(plan), arguments);
  if (!arguments.turns || arguments.frames) return {std::move(plan)};
  const std::int32_t frames = plan.move().frames / *arguments.turns;
  return {std::move(plan), PlayedTurns{.frames = frames, .turns = *arguments.turns}};
}

bool is_numbered(const std::optional<std::string>& file) {
  return file && file->find("%n") != std::string::npos;
}

void refuse_take_arguments(const RunArguments& arguments) {
  if (!arguments.takes) {
    for (const auto& [option, file] : {std::pair("--record", arguments.record), {"--plot", arguments.plot}}) {
      if (is_numbered(file))
        throw UsageError(fmt::format("%n in {} is the number of a take; add --takes", option));
    }
    return;
  }
  if (arguments.is_shot())
    throw UsageError("--takes is for a move that is played; leave out --step and --shutter");
  if (arguments.fast || !KeyTerminal::is_there()) {
    throw UsageError("--takes needs somebody at a terminal who asks for each; leave it out in a script");
  }
  for (const auto& [option, file, example] : {std::tuple("--record", arguments.record, "takes/%n.csv"),
                                              {"--plot", arguments.plot, "takes/%n.svg"}}) {
    if (!file || is_numbered(file)) continue;
    throw UsageError(fmt::format("with --takes {} needs a %n for the number of the take, for example {}",
                                 option, example));
  }
}

void refuse_to_replay(const RunArguments& arguments) {
  if (!arguments.take) return;
  const bool plays_otherwise = arguments.frames || arguments.turns || arguments.loop || arguments.ping_pong ||
                               arguments.rate != 1 || arguments.top_rate != 1;
  if (plays_otherwise) {
    throw UsageError(
        "--take plays what the take played, as fast; leave out --frames, --turns, --loop, --ping-pong, "
        "--rate "
        "and --top-rate");
  }
  if (arguments.is_shot()) throw UsageError("--take plays a take; leave out --step and --shutter");
}

void refuse_changed_files(const Take& take, const std::vector<TakeFile>& then,
                          const std::vector<TakeFile>& today) {
  const std::string changed = changed_file(take.number, then, today);
  if (!changed.empty())
    throw std::runtime_error(changed + "; put back what it was (inbetween takes show has its hash)");
}

/// The take that is named. From here on the arguments are those with which it was played.
std::optional<ReplayedTake> take_to_replay(RunArguments& arguments, const std::vector<TakeFile>& files) {
  if (!arguments.take) return std::nullopt;
  TakeStore store(takes_file(TakeArguments{.takes_in = arguments.takes_in}, arguments.move)
                      .value_or(named_takes_file(std::nullopt)),
                  TakeStore::Access::read);
  ReplayedTake replayed = replayed_take(store, *arguments.take);
  const Take& take = replayed.head;
  std::vector<TakeFile> of_move_and_rig = take.files;
  std::erase_if(of_move_and_rig, [](const TakeFile& file) { return file.role == TakeFile::Role::other; });
  refuse_changed_files(take, of_move_and_rig, files);
  if (take.turns > 0) arguments.turns = take.turns;
  if (take.part != WholeFrames{0, take.frames})
    arguments.frames = fmt::format("{}..{}", take.part.first, take.part.last);
  arguments.top_rate = take.top_rate;
  return replayed;
}

void refuse_another_motion(const Plan& plan, const Take& take) {
  if (bytes_of(plan.motion()) == take.trajectory) return;
  throw InputError(
      {plan.move().path, 0, 0},
      fmt::format("inbetween {} solved this move otherwise when take {} was played, in last bits "
                  "at least; record it again, or use that version",
                  take.version, take.number));
}

void refuse_plot_arguments(const RunArguments& arguments) {
  refuse_unknown_picture(arguments.plot);
  if (!arguments.plot) return;
  if (!arguments.record || arguments.record == "-") {
    throw UsageError("--plot draws what --record has written to a file; add --record FILE");
  }
}

/// Draws what the record of a run, or of one of its takes, tells.
void draw_run(const std::string& record, const std::string& picture, const Plan& plan,
              const RunArguments& arguments, const std::string& of, const std::string& how) {
  ReadRecord read = read_record(record, &*plan.rig());
  read.plot.name = plan.move().name + of;
  read.plot.summary = fmt::format("{} at {} Hz; {}", counted(read.ticks, "tick"), plan.rig()->rate_hz, how);
  draw_run_plot(read.plot, picture, arguments.style);
}

void draw_pictures(const RunReport& report, const Plan& plan, const RunArguments& arguments) {
  if (!arguments.plot) return;
  if (!arguments.takes)
    return draw_run(*arguments.record, *arguments.plot, plan, arguments, "", report.reason);
  for (const RunTake& take : report.takes) {
    draw_run(*take.file, numbered(*arguments.plot, take.number), plan, arguments,
             fmt::format(", take {}", take.number), take.is_whole ? "whole" : "not played to its end");
  }
}

TakesOfRun takes_of_run(const RunArguments& arguments, const Plan& plan, const std::vector<TakeFile>& files,
                        const std::optional<std::string>& file, const std::optional<ReplayedTake>& replayed) {
  TakesOfRun takes;
  if (file) {
    takes.kept = {.keeping = {.file = *file, .max_bytes = arguments.max_take_bytes},
                  .files = files,
                  .version = INBETWEEN_VERSION};
  }
  if (!replayed) return takes;
  refuse_changed_files(replayed->head, replayed->head.files, files);
  refuse_another_motion(plan, replayed->head);
  takes.follow = {fmt::format("take {}", replayed->head.number), replayed->places};
  return takes;
}

int run_command(const RunArguments& given) {
  RunArguments arguments = given;
  if (arguments.allow_jitter && arguments.start_share > jitter_share) {
    throw UsageError("with --allow-jitter --speed is 0.1 at most; lower it");
  }
  refuse_take_arguments(arguments);
  refuse_plot_arguments(arguments);
  refuse_to_replay(arguments);
  refuse_to_play_a_shoot(arguments);
  shoot_options(arguments);  // refuses wrong arguments before any file is read
  frame_range_argument(arguments.frames);
  check_setup_usage(arguments);
  if (arguments.device && (arguments.fast || !KeyTerminal::is_there())) {
    throw UsageError("--device is for somebody at a terminal; leave it out, or --fast");
  }
  if (arguments.faults && !arguments.simulated) {
    throw UsageError("--faults is for simulated drives; add --sim, or give it to inbetween sim-drives");
  }
  if (arguments.steps && !arguments.simulated)
    throw UsageError("--steps writes what simulated motors get; add --sim, or leave it out");
  const bool is_shot = arguments.is_shot();
  if (arguments.fast && ((arguments.loop && !is_shot) || arguments.ping_pong)) {
    throw UsageError("--loop and --ping-pong go on until somebody stops them; leave out --fast");
  }
  refuse_outputs_in_one_place(
      {{"MOVE", arguments.move}, {"--rig", arguments.rig}, {"--faults", arguments.faults}},
      {{"--json", arguments.json},
       {"--record", arguments.record},
       {"--plot", arguments.plot},
       {"--steps", arguments.steps},
       {"--cue-log", arguments.cue_log},
       {"--shoot-log", arguments.shoot_log}});
  if (arguments.json) check_output(*arguments.json);
  const RigWatch watch(arguments.rig);
  const std::optional<std::string> takes = takes_file(arguments, arguments.move);
  std::vector<TakeFile> files;
  if (takes || arguments.take) files = files_of_run(arguments.move, arguments.rig);
  const std::optional<ReplayedTake> replayed = take_to_replay(arguments, files);
  const TurnsOfRun planned = planned_turns(arguments);
  const Plan& plan = planned.plan;
  if (!files.empty()) complete_files(plan, files);
  const TakesOfRun of_run = takes_of_run(arguments, plan, files, takes, replayed);
  if (!arguments.simulated && is_shot) refuse_no_camera(plan);
  const RunReport report = play(planned, arguments, watch, of_run);
  release_lost_terminal();
  if (arguments.json) {
    write_output(*arguments.json, [&](std::FILE* file) { write_run_json(report, file); });
  }
  print_run_summary(
      report, plan, arguments,
      summary_stream(arguments.json == "-" || arguments.cue_log == "-" || arguments.steps == "-" ||
                     arguments.record == "-" || arguments.shoot_log == "-"));
  draw_pictures(report, plan, arguments);
  return exit_status_of(report, arguments.is_shot());
}

constexpr char run_explanation[] =
    R"(Before the first setpoint is sent, the move is held against the limits of the rig as inbetween check
does, and every setpoint against its positions: a move that does not fit moves nothing (exit status 3). A rig
that does not stand where the move starts goes there first, at a tenth of its limits unless --speed says
otherwise, and only after somebody agreed: with Enter on a terminal, with --yes in a script.

The drives of a real rig are switched on only where every axis says that it keeps its place without power
(unpowered = "holds").

On a terminal it is a tape recorder: space pauses and plays, r turns, left and right go to the next frame, and
held on and on, as the wheel of a mouse does by frames; g 9 6 Enter goes to frame 96 and k 3 Enter to key 3 of
the first track (the first is 0), along the path and slowly: no axis faster than a tenth of its limit. Home goes
back to the start, + and - change the rate, Esc stops. After a stop, a acknowledges it and Enter starts again; q
stops and leaves, as Ctrl-C and a lost terminal do. Whatever changes, the axes stay on the path and inside their
stop limits.

The screen shows what happens (going to the start, pre-roll, playing, post-roll, stopped), frame, rate and the
time that is left, and where every axis was told to be, is, and how far behind it is. It follows the size of
its window and needs no colours. Where standard error is no terminal, a line tells whenever something else
happens. Played backward to its beginning a move rests there until Enter plays it.

With --takes the rig waits where the move begins, and every take begins with Enter. At its end it waits again:
Home goes back along the path, arrows, g and k go elsewhere on it, q leaves. --record takes/%n.csv writes a file
a take, from the first number on that is free; --plot takes/%n.svg draws each of them when the drives are off.

Every run, and with --takes each take, is kept in inbetween-takes.db in the folder of the move: inbetween takes
lists, draws and exports them. --take N plays one again: the same setpoints tick by tick, up to where it first
rested, after the same checks, where move and rig are what they were. Whoever is at the keys stops it as any move,
which from then on it is. Where takes cannot be kept a line says so, and the rig moves as without.

--record and --cue-log write no file over. What a disk that was full has not taken is counted, and the file ends
with a whole line. inbetween plot draws a record again.

--frames 20..80 plays a part of the move as a move of its own: from rest it is led into frame 20 as the move
passes it, and out of frame 80 to rest. It has its own check (inbetween check --frames 20..80), transit to the
start, takes and Home; its positions are those of the whole move, and so are the numbers of its frames. Cues
of other frames do not happen; the clapper claps on the first and the last that is played.

--loop is refused for a move that does not end where it starts. A periodic move goes on through its seam at its
speed: --turns K plays K turns between one pre-roll and one post-roll, --loop goes round until it is stopped;
where every turn ends further on it says beforehand how many fit on the rig, and plays these. The screen shows
the turn, and the frame in it. With --step or --shutter either shoots N frames a turn: frame N is frame 0.

--step goes to the first frame and exposes it when space (or without a terminal the camera) asks; space goes
on with the next frame that is not shot, e exposes the one that the rig stands on again, left and right look at
others. After a stop the rig stands on its frame until it is asked again. With --shutter it runs up to each
exposure, passes the share of the frame between the angles at a constant rate in --exposure seconds, and runs
out. Either is held to what moves, positions, travels and exposures, not to what playing it would take; a
travel rests where the motion steps. --frames 37.. shoots from there on, and the last line of --shoot-log names
the last frame that was shot; with --resume the shoot goes on with the first frame that this log does not have.

The line of the rig's [camera] is on while a frame is exposed. Where the camera has a line that asks,
on a rig that asks for each next frame as well; with --sim no line is touched.

A move with start = "trigger" is made ready, with the drives on, and waits: on a rig for its [start_trigger]
to become active (what came before it waited starts nothing), with --sim for a trigger that comes by itself
after a second. Enter starts it too, and q leaves.

The cues of a move are pulses on the [output.NAME] and [camera] lines of the rig, each when the axes are at
its place, forward only. --cue-log writes a line for each that begins: seconds, line, frame, width_ms, merged,
late_us; with --sim too.

Whatever ends it, every axis rests then and every drive of a bus has told that it is off. One that has not is
named; its own watchdogs stay on (exit status 4).

Exit status: 0 played to its end, or every frame was shot; 3 refused; 4 stopped before its end, or a drive may
have power; 5 a shoot that ended with frames missing.

Axes that no drive knows (see reference in docs/formats.md) must have been homed, or placed by somebody:
inbetween home, inbetween goto --set-zero. Where they rest is kept from one run to the next.

SIGUSR1 presses an emergency stop, SIGUSR2 releases it: setpoints cease, and whatever moved must be
acknowledged. A real rig is refused without the rights of a real-time program (inbetween says which and how to
get them).

Examples:
  inbetween run move.toml --rig rig.toml                     on the drives of the rig
  inbetween run move.toml --rig rig.toml --sim               in real time
  inbetween run move.toml --rig rig.toml --rate 0.1          at a tenth of the drawn speed
  inbetween run move.toml --rig rig.toml --frames 20..80     a part of the move
  inbetween run move.toml --rig rig.toml --sim --fast        for scripts and tests
  inbetween run move.toml --rig rig.toml --sim --from pan=10 from elsewhere, slowly to its start first
  inbetween run move.toml --rig rig.toml --speed 0.5         the same at half of its limits
  inbetween run move.toml --rig rig.toml --sim --step        stop motion
  inbetween run move.toml --rig rig.toml --step --shoot-log shoot.csv --resume
  inbetween run move.toml --rig rig.toml --sim --shutter 0..180 --exposure 0.5
  inbetween run move.toml --rig rig.toml --sim --fast --cue-log cues.csv
  inbetween run move.toml --rig rig.toml --take 7            take 7 again)";

/// The help shows the options in these groups; those of a shoot have one of their own.
void group_options(CLI::App& app) {
  const std::vector<std::pair<const char*, std::vector<const char*>>> groups{
      {"The rig, or one that is simulated",
       {"--rig", "--sim", "--fast", "--from", "--positions", "--allow-jitter", "--faults", "--device",
        "--yes"}},
      {"What is played, and how fast",
       {"--frames", "--turns", "--loop", "--ping-pong", "--takes", "--take", "--rate", "--top-rate",
        "--speed"}},
      {"What is written",
       {"--no-take", "--takes-in", "--keep", "--json", "--record", "--plot", "--style", "--steps",
        "--cue-log", "--latency"}}};
  for (const auto& [group, names] : groups) {
    for (const char* name : names) app.get_option(name)->group(group);
  }
}

void describe(CLI::App& app, RunArguments& arguments) {
  app.add_option("MOVE", arguments.move, "the move: a TOML file with keys, a speed curve and a frame count")
      ->required();
  add_setup_options(app, arguments, true);
  app.get_option("--from")->description(
      "AXIS=POSITION, where a simulated axis stands before (the start of the move)");
  app.get_option("--allow-jitter")
      ->description("move a real rig without real-time rights, at a tenth of the drawn speed at most");
  add_frames(app, arguments.frames,
             "play a part of the move, 20..80 or 20.. or ..80, with rolls of its own; with --step or\n"
             "--shutter shoot it");
  CLI::Option* loop = app.add_flag("--loop", arguments.loop, "begin again at the end, until stopped");
  app.add_flag("--ping-pong", arguments.ping_pong, "play to and fro, until stopped")->excludes(loop);
  add_turns(app, arguments.turns);
  app.add_option("--top-rate", arguments.top_rate, "let + go up to so many times the drawn speed")
      ->check(between(1.0, 10.0))
      ->capture_default_str();
  app.add_option("--rate", arguments.rate, "begin at so many times the drawn speed")
      ->check(between(0.01, 1.0))
      ->capture_default_str();
  app.add_option(
         "--speed", arguments.start_share,
         "the share of their velocity, acceleration and jerk that the axes may use on the transit to the\n"
         "start")
      ->check(between(0.001, 1.0))
      ->capture_default_str();
  app.add_flag("--yes", arguments.yes, "agree that the rig goes slowly to the start of the move");
  app.add_option("--faults", arguments.faults,
                 "a script of what goes wrong with simulated CiA 402 drives, and when");
  app.add_option("--json", arguments.json, "write a report (- is standard output)");
  app.add_flag("--takes", arguments.takes,
               "stay after the end: Home goes back to the start, Enter begins the next take");
  app.add_option(
      "--record", arguments.record,
      "write what every axis was told and where it was, a line a tick (CSV); with --takes a file a\n"
      "take, %n is its number");
  app.add_option("--plot", arguments.plot,
                 "with --record: draw where every axis was told to be, where it was, and how far behind\n"
                 "(.svg, .png or .pdf); with --takes a picture a take, %n is its number");
  add_style(app, arguments.style);
  app.add_option(
      "--device", arguments.device,
      "a jog wheel, game pad or keyboard of /dev/input: its wheel and its arrows do what those of\n"
      "the terminal do, and it tells when they are let go");
  app.add_option("--steps", arguments.steps,
                 "with --sim: write every edge on the STEP lines of the step-dir axes, a line an edge (CSV)");
  app.add_option("--cue-log", arguments.cue_log,
                 "write when which pulse began on the outputs of the rig, a line a pulse (CSV; - is standard "
                 "output)");
  app.add_flag("--latency", arguments.latency, "at the end show how late the loop woke up, by octaves");
  add_take_options(app, arguments);
  add_shoot_options(app, arguments);
  group_options(app);
  app.footer(run_explanation);
}

}  // namespace

void add_run_command(CLI::App& program, Command& chosen) {
  add_command(program, chosen, {"run", "Play a move on a rig, a position of every axis per tick"}, describe,
              run_command);
}

}  // namespace inbetween
