#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <optional>
#include <string>

#include "drivers/linux/interrupt_watch.hpp"
#include "drivers/linux/key_terminal.hpp"
#include "host_tools/command.hpp"
#include "host_tools/output_file.hpp"
#include "host_tools/progress_bar.hpp"
#include "host_tools/run.hpp"

namespace inbetween {
namespace {

struct RunArguments {
  std::string move, rig;
  std::optional<std::string> json;
  bool simulated = false;
  bool fast = false;
  bool loop = false;
  bool ping_pong = false;
};

void print_run_summary(const RunReport& report, const Plan& plan, const RunArguments& arguments,
                       std::FILE* out) {
  fmt::print(out, "{}: {}; {} ticks at {} Hz{}\n", plan.move().name, report.reason, report.ticks,
             plan.rig()->rate_hz, arguments.fast ? " on a virtual clock" : "");
  if (!arguments.fast) {
    fmt::print(out, "  late ticks {}; woken after {:.0f} us (median), {:.0f} us (99 %), {:.0f} us (worst)\n",
               report.late_ticks, report.wake_latency.p50_us, report.wake_latency.p99_us,
               report.wake_latency.max_us);
  }
  fmt::print(out, "  {:<16}{:>14}{:>14}{:>24}\n", "axis", "commanded", "actual", "following error, peak");
  for (const RunAxis& axis : report.axes) {
    fmt::print(out, "  {:<16}{:>14.4f}{:>14.4f}{:>24.4f}  {}\n", axis.name, axis.last_commanded,
               axis.last_actual, axis.following_error_peak, axis.unit);
  }
}

/// On a terminal with the keys of a tape recorder, elsewhere with nothing but a progress bar.
RunReport run(const Plan& plan, const RunArguments& arguments) {
  const InterruptWatch interrupts;
  RunOptions options{.fast = arguments.fast, .interrupted = &InterruptWatch::asked, .progress = {}};
  if (arguments.loop) options.repeat = Repeat::loop;
  if (arguments.ping_pong) options.repeat = Repeat::ping_pong;
  ProgressBar bar;
  const FrameRate fps = plan.move().fps.rate;
  const std::int32_t rate_hz = plan.rig()->rate_hz;
  options.progress = [&](std::int64_t tick, std::int64_t last) {
    const std::int32_t frame =
        std::min(frame_time_of_tick<double>(tick, fps, rate_hz).frame + plan.played().first_frame(),
                 plan.played().last_frame());
    bar.show(static_cast<double>(tick) / static_cast<double>(last),
             fmt::format("frame {}/{}  {:.1f} s", frame, plan.played().last_frame(),
                         static_cast<double>(tick) / rate_hz));
  };
  if (arguments.fast || !KeyTerminal::is_there()) return run_simulated(plan, options);
  KeyTerminal terminal;
  options.progress = {};
  options.keys = [&] { return terminal.read(); };
  options.status = [&](double share, const std::string& line) { bar.show(share, line); };
  return run_simulated(plan, options);
}

int run_command(const RunArguments& arguments) {
  if (!arguments.simulated) {
    throw UsageError("this version moves a simulated rig only; add --sim");
  }
  if (arguments.fast && (arguments.loop || arguments.ping_pong)) {
    throw UsageError("--loop and --ping-pong go on until somebody stops them; leave out --fast");
  }
  refuse_outputs_in_one_place({{"MOVE", arguments.move}, {"--rig", arguments.rig}},
                              {{"--json", arguments.json}});
  if (arguments.json) check_output(*arguments.json);
  const Plan plan = make_plan(arguments.move, arguments.rig, Solver::closed_form);
  const RunReport report = run(plan, arguments);
  if (arguments.json) {
    write_output(*arguments.json, [&](std::FILE* file) { write_run_json(report, file); });
  }
  print_run_summary(report, plan, arguments, summary_stream(arguments.json == "-"));
  return report.ending == Ending::finished ? 0 : exit_fault;
}

void describe(CLI::App& app, RunArguments& arguments) {
  app.add_option("MOVE", arguments.move, "the move: a TOML file with keys, a speed curve and a frame count")
      ->required();
  app.add_option("--rig", arguments.rig, "the rig: axes, limits, drives and the ticks per second")
      ->required();
  app.add_flag("--sim", arguments.simulated, "simulate every axis of the rig; no hardware is touched");
  app.add_flag("--fast", arguments.fast, "on a virtual clock, as fast as it can be computed");
  CLI::Option* loop = app.add_flag("--loop", arguments.loop, "begin again at the end, until stopped");
  app.add_flag("--ping-pong", arguments.ping_pong, "play to and fro, until stopped")->excludes(loop);
  app.add_option("--json", arguments.json, "write a report (- is standard output)");
  app.footer(
      "Before the first setpoint is sent, the move is held against the limits of the rig as inbetween check "
      "does,\n"
      "and every setpoint against its positions: a move that does not fit moves nothing (exit status 3).\n\n"
      "On a terminal it is a tape recorder: space pauses and plays, r turns, left and right go to the next "
      "frame,\n"
      "+ and - change the rate, Esc stops. After a stop, a acknowledges it and Enter starts again; q stops "
      "and\n"
      "leaves, as Ctrl-C does. Whatever changes, the axes stay on the path and inside their stop limits.\n\n"
      "--loop is refused for a move that does not end where it starts.\n\n"
      "Exit status: 0 played to its end; 3 refused; 4 stopped before its end.\n\n"
      "Examples:\n"
      "  inbetween run move.toml --rig rig.toml --sim               in real time\n"
      "  inbetween run move.toml --rig rig.toml --sim --fast        for scripts and tests");
}

}  // namespace

void add_run_command(CLI::App& program, Command& chosen) {
  CLI::App* command =
      program.add_subcommand("run", "Play a move on a rig, a position of every axis per tick");
  const auto arguments = std::make_shared<RunArguments>();
  describe(*command, *arguments);
  command->callback([arguments, &chosen] { chosen = [arguments] { return run_command(*arguments); }; });
}

}  // namespace inbetween
