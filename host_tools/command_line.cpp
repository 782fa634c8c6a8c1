#include "host_tools/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/budget.hpp"
#include "host_tools/check.hpp"
#include "host_tools/check_frames.hpp"
#include "host_tools/check_output.hpp"
#include "host_tools/output_file.hpp"
#include "host_tools/plan.hpp"
#include "host_tools/plan_output.hpp"
#include "host_tools/plot.hpp"
#include "host_tools/plot_canvas.hpp"
#include "host_tools/plot_limits.hpp"
#include "host_tools/progress_bar.hpp"
#include "host_tools/run.hpp"

namespace inbetween {
namespace {

constexpr int exit_bad_input = 1;
constexpr int exit_wrong_usage = 2;
constexpr int exit_limit = 3;
constexpr int exit_fault = 4;

/// What can only be seen with all options together.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct PlanArguments {
  std::string move, per = "frame", solver = "closed-form";
  std::optional<std::string> rig, csv, json, plot;
};

struct CheckArguments {
  std::string move, rig;
  std::optional<std::string> json, plot;
};

struct RunArguments {
  std::string move, rig;
  std::optional<std::string> json;
  bool simulated = false;
  bool fast = false;
};

/// Not fmt::print, which throws where standard error cannot be written either: the status still tells.
void complain(const std::string& line) {
  std::fputs((line + '\n').c_str(), stderr);
}

/// A file that a command reads or writes, with the argument that names it.
struct NamedFile {
  const char* argument;
  std::optional<std::string> name;
};

bool is_same_file(const std::string& one, const std::string& other) {
  std::error_code not_there;
  if (std::filesystem::equivalent(one, other, not_there)) return std::filesystem::is_regular_file(one);
  const auto place = [&](const std::string& name) {
    return std::filesystem::weakly_canonical(name, not_there);
  };
  return !std::filesystem::exists(one, not_there) && place(one) == place(other);
}

/// No output is written over an input or over another output.
void refuse_outputs_in_one_place(const std::vector<NamedFile>& inputs,
                                 const std::vector<NamedFile>& outputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const NamedFile& output = outputs[i];
    if (!output.name) continue;
    const auto refuse = [&](const NamedFile& other) {
      throw UsageError(fmt::format("{} and {} would both be {}; give each its own file", other.argument,
                                   output.argument,
                                   *output.name == "-" ? "the standard output" : *output.name));
    };
    for (std::size_t k = 0; k < i; ++k) {
      if (!outputs[k].name) continue;
      const bool to_stdout = *output.name == "-" || *outputs[k].name == "-";
      if (to_stdout ? *output.name == *outputs[k].name : is_same_file(*output.name, *outputs[k].name)) {
        refuse(outputs[k]);
      }
    }
    for (const NamedFile& input : inputs) {
      if (input.name && *output.name != "-" && is_same_file(*output.name, *input.name)) refuse(input);
    }
  }
}

Plan make_plan(const std::string& move, const std::optional<std::string>& rig, Solver solver) {
  std::optional<RigFile> rig_file;
  if (rig) rig_file = read_rig_file(*rig);
  Plan plan(read_move_file(move), std::move(rig_file), {.solver = solver});
  for (const Warning& warning : plan.warnings()) fmt::print(stderr, "{}\n", to_string(warning));
  return plan;
}

/// The summary goes to standard error when standard output carries data.
std::FILE* summary_stream(bool data_on_standard_output) {
  return data_on_standard_output ? stderr : stdout;
}

/// What locked keys and holds did to the drawn curve.
void print_key_timing(const SolvedTrack<double>& solved, std::FILE* out) {
  if (!solved.key_timing()) return;
  const KeyTiming<double>& timing = *solved.key_timing();
  const auto f = static_cast<std::int32_t>(timing.control_values.size()) - 1;
  for (const KeyLock& lock : timing.locks) {
    const bool end_of_move =
        lock.hold == 0 && (lock.key == 0 || lock.key == solved.track().path().segment_count());
    if (end_of_move) continue;
    fmt::print(out, "    key {} on frame {}", lock.key, lock.frame);
    if (lock.hold > 0) fmt::print(out, ", at rest for {} frames", lock.hold);
    fmt::print(out, "{}\n", lock.breaks ? ", with a break in the speed" : "");
  }
  for (const Portion<double>& portion : solved.track().portions()) {
    fmt::print(out, "    from frame {} on K {:.6g}\n", portion.begin_frame, portion.constant);
  }
  fmt::print(out, "    speed curve: {} control values", f + 1);
  if (timing.refinements > 0) fmt::print(out, " (the drawn {}, refined)", (f >> timing.refinements) + 1);
  fmt::print(out, ", largest change {:.4g} at a = {} (frame {:.1f})\n", timing.largest_change,
             timing.largest_change_at,
             static_cast<double>(timing.largest_change_at) * solved.track().frames() / f);
}

void print_plan_summary(const Plan& plan, std::FILE* out) {
  const MoveFile& move = plan.move();
  fmt::print(out, "{}: {} frames at {} fps, {:.3f} s\n", move.name, move.frames, move.fps.as_written,
             plan.duration_s());
  for (std::size_t t = 0; t < plan.tracks().size(); ++t) {
    const SolvedTrack<double>& solved = plan.tracks()[t];
    const Provenance<double>& made = solved.table().provenance();
    const std::string unit = plan.length_unit(t);
    fmt::print(out, "  {}: {} keys, length {:.6g}{}{}; ", comma_separated(move.tracks[t].axes),
               move.tracks[t].keys.size(), solved.track().arc_length().total(), unit.empty() ? "" : " ",
               unit);
    if (!solved.track().has_profile()) {
      fmt::print(out, "timed by the frames of its keys\n");
      continue;
    }
    if (solved.track().portions().empty()) fmt::print(out, "K {:.6g}; ", made.constant);
    if (made.solver == Solver::closed_form) {
      fmt::print(out, "closed form, speed within {:g}\n", made.speed_error);
    } else {
      fmt::print(out, "Runge-Kutta, {} integrations of {} steps a frame, speed within {:.2g} (frame {})\n",
                 made.integrations, made.substeps, made.speed_error, made.speed_error_frame);
    }
    print_key_timing(solved, out);
  }
  print_rolls(plan, out);
}

void refuse_unknown_picture(const std::optional<std::string>& plot) {
  if (!plot) return;
  try {
    static_cast<void>(picture_format(*plot));
  } catch (const std::runtime_error& error) {
    throw UsageError(fmt::format("--plot {}", error.what()));
  }
}

void check_usage(const PlanArguments& arguments) {
  if (arguments.per == "tick" && !arguments.rig) {
    throw UsageError("--per tick needs --rig RIG, which says how many ticks a second has");
  }
  if (arguments.per == "tick" && arguments.solver == "runge-kutta") {
    throw UsageError("--solver runge-kutta knows frames only; leave out --per tick or the solver");
  }
  refuse_unknown_picture(arguments.plot);
  refuse_outputs_in_one_place(
      {{"MOVE", arguments.move}, {"--rig", arguments.rig}},
      {{"--csv", arguments.csv}, {"--json", arguments.json}, {"--plot", arguments.plot}});
}

void plan_command(const PlanArguments& arguments) {
  check_usage(arguments);
  const Solver solver = arguments.solver == "closed-form" ? Solver::closed_form : Solver::runge_kutta;
  const Plan plan = make_plan(arguments.move, arguments.rig, solver);
  const PlanRows rows = arguments.per == "tick" ? PlanRows::tick : PlanRows::frame;
  if (arguments.csv) {
    write_output(*arguments.csv, [&](std::FILE* file) { write_plan_csv(plan, rows, file); });
  }
  if (arguments.json) {
    write_output(*arguments.json, [&](std::FILE* file) { write_plan_json(plan, rows, file); });
  }
  if (arguments.plot) draw_plot(plot_of(plan), *arguments.plot);
  print_plan_summary(plan, summary_stream(arguments.csv == "-" || arguments.json == "-"));
}

int check_command(const CheckArguments& arguments) {
  refuse_unknown_picture(arguments.plot);
  refuse_outputs_in_one_place({{"MOVE", arguments.move}, {"--rig", arguments.rig}},
                              {{"--json", arguments.json}, {"--plot", arguments.plot}});
  if (arguments.json) check_output(*arguments.json);
  const Plan plan = make_plan(arguments.move, arguments.rig, Solver::closed_form);
  const CheckReport report = check(plan);
  SmallestFrames smallest;
  {
    ProgressBar bar;
    smallest = smallest_frames(plan, report, [&](double share, std::int32_t frames) {
      bar.show(share, fmt::format("trying {} frames", frames));
    });
  }
  if (arguments.json) {
    write_output(*arguments.json, [&](std::FILE* file) { write_check_json(report, smallest, file); });
  }
  if (arguments.plot) draw_limits_plot(limits_plot_of(plan, report), *arguments.plot);
  print_check(plan, report, smallest, summary_stream(arguments.json == "-"));
  for (const Refusal& refusal : report.refusals) complain(LimitError(refusal.place, refusal.message).what());
  return report.fits() ? 0 : exit_limit;
}

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

int run_command(const RunArguments& arguments) {
  if (!arguments.simulated) {
    throw UsageError("this version moves a simulated rig only; add --sim");
  }
  refuse_outputs_in_one_place({{"MOVE", arguments.move}, {"--rig", arguments.rig}},
                              {{"--json", arguments.json}});
  if (arguments.json) check_output(*arguments.json);
  const Plan plan = make_plan(arguments.move, arguments.rig, Solver::closed_form);
  RunReport report;
  {
    ProgressBar bar;
    const FrameRate fps = plan.move().fps.rate;
    const std::int32_t rate_hz = plan.rig()->rate_hz;
    report = run_simulated(
        plan, {.fast = arguments.fast, .progress = [&](std::int64_t tick, std::int64_t last) {
                 const std::int32_t frame = std::min(
                     frame_time_of_tick<double>(tick, fps, rate_hz).frame + plan.played().first_frame(),
                     plan.played().last_frame());
                 bar.show(static_cast<double>(tick) / static_cast<double>(last),
                          fmt::format("frame {}/{}  {:.1f} s", frame, plan.played().last_frame(),
                                      static_cast<double>(tick) / rate_hz));
               }});
  }
  if (arguments.json) {
    write_output(*arguments.json, [&](std::FILE* file) { write_run_json(report, file); });
  }
  print_run_summary(report, plan, arguments, summary_stream(arguments.json == "-"));
  return report.ending == Ending::fault ? exit_fault : 0;
}

int budget_command(const BudgetCapacity& capacity) {
  if (capacity.locks > capacity.keys) {
    throw UsageError(
        fmt::format("--locks {} is more than --keys {}; raise --keys", capacity.locks, capacity.keys));
  }
  print_budget(capacity, stdout);
  return 0;
}

void describe_plan(CLI::App& app, PlanArguments& arguments) {
  app.add_option("MOVE", arguments.move, "the move: a TOML file with keys, a speed curve and a frame count")
      ->required();
  app.add_option("--rig", arguments.rig, "the rig: gives the axes their units, and ticks their rate");
  app.add_option("--per", arguments.per, "rows of the CSV and of the JSON's axes")
      ->check(CLI::IsMember({"frame", "tick"}))
      ->capture_default_str();
  app.add_option("--solver", arguments.solver,
                 "closed-form inverts the arc length; runge-kutta is the paper's own, a second opinion")
      ->check(CLI::IsMember({"closed-form", "runge-kutta"}))
      ->capture_default_str();
  app.add_option("--csv", arguments.csv,
                 "write the positions of all axes, a row per frame or tick (- is standard output)");
  app.add_option("--json", arguments.json, "write everything: path, table, axes (- is standard output)");
  app.add_option("--plot", arguments.plot,
                 "draw the path, the speed curve, the time bar and the axes (.svg, .png or .pdf)");
  app.footer(
      "Examples:\n"
      "  inbetween plan move.toml                                   a summary\n"
      "  inbetween plan move.toml --plot move.svg                   a picture\n"
      "  inbetween plan move.toml --csv - | head                    positions per frame\n"
      "  inbetween plan move.toml --rig rig.toml --per tick --csv ticks.csv");
}

void describe_check(CLI::App& app, CheckArguments& arguments) {
  app.add_option("MOVE", arguments.move, "the move: a TOML file with keys, a speed curve and a frame count")
      ->required();
  app.add_option("--rig", arguments.rig, "the rig: gives the axes their limits")->required();
  app.add_option("--json", arguments.json, "write everything that was found (- is standard output)");
  app.add_option("--plot", arguments.plot,
                 "draw velocity, acceleration and jerk of every axis with its limits (.svg, .png or .pdf)");
  app.footer(
      "Every moment from the first frame to the last is held against the limits, not samples of it: a peak "
      "is "
      "a\n"
      "proven bound, not below the true one and at most 1 % above it. Jerk is held only where the rig has a\n"
      "max_jerk.\n\n"
      "A move that starts moving gets a pre-roll from rest, on frames below 0, and one that ends moving a\n"
      "post-roll: the shortest that keep the limits, one number of frames for all axes.\n\n"
      "A step of the velocity (a corner of the path, a break) never fits: no drive can follow it. A step of "
      "the acceleration breaks a max_jerk unless it is within "
      "max_acceleration_step;\n"
      "spline = \"smooth\" has none at its keys, and a speed curve that begins and ends with 0, 0 none at "
      "its ends.\n\n"
      "The last line tells in how many frames the move would fit, its locked keys and holds moved in "
      "proportion.\n"
      "At one frame less it was tried and does not fit. Where slowing down cures nothing, it says why.\n\n"
      "Exit status: 0 the move fits; 3 it does not, and every reason is a line of standard error.\n\n"
      "Examples:\n"
      "  inbetween check move.toml --rig rig.toml                   a table of peaks, and the verdict\n"
      "  inbetween check move.toml --rig rig.toml --plot limits.svg where the peaks are\n"
      "  inbetween check move.toml --rig rig.toml --json -          for other programs");
}

void describe_run(CLI::App& app, RunArguments& arguments) {
  app.add_option("MOVE", arguments.move, "the move: a TOML file with keys, a speed curve and a frame count")
      ->required();
  app.add_option("--rig", arguments.rig, "the rig: axes, limits, drives and the ticks per second")
      ->required();
  app.add_flag("--sim", arguments.simulated, "simulate every axis of the rig; no hardware is touched");
  app.add_flag("--fast", arguments.fast, "on a virtual clock, as fast as it can be computed");
  app.add_option("--json", arguments.json, "write a report (- is standard output)");
  app.footer(
      "Before the first setpoint is sent, the move is held against the limits of the rig as inbetween check "
      "does,\n"
      "and every setpoint against its positions: a move that does not fit moves nothing (exit status 3).\n\n"
      "Examples:\n"
      "  inbetween run move.toml --rig rig.toml --sim               in real time\n"
      "  inbetween run move.toml --rig rig.toml --sim --fast        for scripts and tests");
}

void describe_budget(CLI::App& app, BudgetCapacity& capacity) {
  const auto add_count = [&](const char* name, std::int32_t& count, std::int32_t least, std::int32_t largest,
                             const char* what) {
    app.add_option(name, count, what)->check(CLI::Range(least, largest))->capture_default_str();
  };
  add_count("--keys", capacity.keys, 1, largest_budget.keys, "keys of a track");
  add_count("--axes", capacity.axes, 1, largest_budget.axes, "axes of a track");
  add_count(
      "--control-values", capacity.control_values, 1, largest_budget.control_values,
      "control values of the speed curve; locked keys may refine a drawn one, to twice as many and more");
  add_count("--frames", capacity.frames, 1, largest_budget.frames, "frames of the move");
  add_count("--locks", capacity.locks, 0, largest_budget.locks,
            "keys with a frame, a hold or a break of their own");
  app.add_option("--delta", capacity.delta,
                 "largest relative error of the speed; without it 1e-6 in double, 1e-5 in single precision")
      ->check([](const std::string& text) {
        constexpr double least = Precision<double>::smallest_delta;
        double delta = 0;
        const double above = *largest_budget.delta;
        const bool known = CLI::detail::lexical_cast(text, delta) && delta >= least && delta < above;
        return known ? "" : fmt::format("Value {} not in range: from {:g} to below {:g}", text, least, above);
      });
  app.footer(
      "Three tables: the bytes that the caller of the core provides for every object of a move of that "
      "capacity\n"
      "(the same on every processor); the worst stack of every public function on two microcontrollers, "
      "added up\n"
      "from what the compiler says; the instructions that a tick of three axes takes there, counted in an "
      "emulator.\n"
      "The last two are limits, which the tests of the project hold.\n\n"
      "Examples:\n"
      "  inbetween budget                                           8 keys, 3 axes, 240 frames\n"
      "  inbetween budget --keys 100 --axes 16 --control-values 40 --frames 5000\n"
      "  inbetween budget --delta 1e-4                              coarser, in less memory");
}

}  // namespace

int run_command_line(int argc, const char* const* argv) {
  CLI::App app(
      "Moves camera rigs and puppets the way an animator draws the motion: key positions say where, one "
      "drawn\n"
      "speed curve says how fast, the frame count says how long.",
      "inbetween");
  app.set_version_flag("--version", "inbetween " INBETWEEN_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Files: docs/formats.md describes moves and rigs.\n"
      "Exit status: 0 done; 1 bad input; 2 wrong usage; 3 a limit would be exceeded; 4 stopped by a fault.");
  PlanArguments plan_arguments;
  CheckArguments check_arguments;
  RunArguments run_arguments;
  CLI::App* plan = app.add_subcommand("plan", "Solve a move and show it: summary, CSV, JSON, picture");
  describe_plan(*plan, plan_arguments);
  CLI::App* check_limits = app.add_subcommand(
      "check", "Hold a move against the limits of a rig: is it inside them at every moment?");
  describe_check(*check_limits, check_arguments);
  CLI::App* run = app.add_subcommand("run", "Play a move on a rig, a position of every axis per tick");
  describe_run(*run, run_arguments);
  BudgetCapacity budget_capacity;
  CLI::App* budget =
      app.add_subcommand("budget", "Say what a move takes of a machine: memory, stack, instructions");
  describe_budget(*budget, budget_capacity);
  const auto wrong_usage = [&](const std::string& what) {
    const std::vector<CLI::App*> commands = app.get_subcommands();
    const std::string command = commands.empty() ? "" : commands.front()->get_name() + " ";
    complain(fmt::format("inbetween: error: {}; see inbetween {}--help", what, command));
    return exit_wrong_usage;
  };
  try {
    int status = 0;
    try {
      app.parse(argc, argv);
      if (run->parsed()) {
        status = run_command(run_arguments);
      } else if (check_limits->parsed()) {
        status = check_command(check_arguments);
      } else if (budget->parsed()) {
        status = budget_command(budget_capacity);
      } else {
        plan_command(plan_arguments);
      }
    } catch (const CLI::Success& asked) {  // --help, --version
      app.exit(asked);
      std::cout.flush();
    }
    check_standard_output();
    return status;
  } catch (const CLI::ParseError& error) {
    return wrong_usage(error.what());
  } catch (const UsageError& error) {
    return wrong_usage(error.what());
  } catch (const LimitError& error) {
    complain(error.what());
    return exit_limit;
  } catch (const std::exception& error) {
    complain(error.what());
    return exit_bad_input;
  }
}

}  // namespace inbetween
