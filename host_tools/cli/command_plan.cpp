#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/cli/command.hpp"
#include "host_tools/plan/passed_keys.hpp"
#include "host_tools/plan/plan_output.hpp"
#include "host_tools/plot/plot.hpp"
#include "host_tools/table/trajectory_table.hpp"
#include "host_tools/text/output_file.hpp"

namespace inbetween {
namespace {

struct PlanArguments {
  std::string move, per = "frame", solver = "closed-form";
  std::optional<std::string> rig, csv, json, plot, trajectory, frames;
  PictureStyle style = PictureStyle::light;
  std::optional<std::int32_t> turns;
};

/// Prints the change that locked keys and holds made to the drawn curve.
void print_key_timing(const SolvedTrack& solved, std::FILE* out) {
  if (!solved.key_timing()) return;
  const KeyTiming& timing = *solved.key_timing();
  const auto f = static_cast<std::int32_t>(timing.control_values.size()) - 1;
  for (std::size_t i = 0; i < timing.locks.size(); ++i) {
    const KeyLock& lock = timing.locks[i];
    const bool end_of_move = lock.hold == 0 && (i == 0 || i + 1 == timing.locks.size());
    if (end_of_move) continue;
    fmt::print(out, "    {} on frame {:.6g}", lock.key < 0 ? "turn" : fmt::format("key {}", lock.key),
               timing.frame_of(lock, solved.track().frames()));
    if (lock.ease) fmt::print(out, ", eased");
    if (lock.hold > 0) fmt::print(out, ", at rest for {}", counted(lock.hold, "frame"));
    fmt::print(out, "{}\n", lock.breaks ? ", with a break in the speed" : "");
  }
  for (const Portion& portion : solved.track().portions()) {
    fmt::print(out, "    from frame {} on K {:.6g}\n", portion.begin_frame, portion.constant);
  }
  fmt::print(out, "    speed curve: {} control values", f + 1);
  if (timing.refinements > 0) fmt::print(out, " (the drawn {}, refined)", (f >> timing.refinements) + 1);
  fmt::print(out, ", largest change {:.4g} at a = {} (frame {:.1f})\n", timing.largest_change,
             timing.largest_change_at,
             static_cast<double>(timing.largest_change_at) * solved.track().frames() / f);
}

/// Prints K, and what the highest control value of the drawn curve means: K alone tells an animator nothing.
void print_constant(const Plan& plan, std::size_t t, double constant, std::FILE* out) {
  const Track& track = plan.tracks()[t].track();
  const std::vector<double>& drawn = plan.move().tracks[t].speed;
  fmt::print(out, "K {:.6g}", constant);
  if (!drawn.empty()) {
    const double highest = *std::ranges::max_element(drawn);
    const double per_s = plan.move().fps.rate.frames_per_second() / track.frames();
    const std::string unit = plan.length_unit(t);
    fmt::print(out, ", {:g} on the speed curve is {:.4g} {}", highest,
               constant * highest * track.profile().span_count() * per_s,
               unit.empty() ? "a second" : unit + "/s");
  }
  fmt::print(out, "; ");
}

void print_plan_summary(const Plan& plan, std::FILE* out) {
  const MoveFile& move = plan.move();
  fmt::print(out, "{}: {} at {} fps, {:.3f} s\n", move.name, frames_in_words(plan.part(), move.frames),
             move.fps.as_written, plan.duration_s());
  for (std::size_t t = 0; t < plan.tracks().size(); ++t) {
    const SolvedTrack& solved = plan.tracks()[t];
    const Provenance& made = solved.table().provenance();
    const std::string unit = plan.length_unit(t);
    const std::optional<MoveTable>& table = move.tracks[t].table;
    const std::size_t count = table ? table->frames.size() : move.tracks[t].keys.size();
    fmt::print(out, "  {}: {}, length {:.6g}{}{}; ", comma_separated(move.tracks[t].axes),
               counted(static_cast<std::int64_t>(count), table ? "row" : "key"),
               solved.track().arc_length().total(), unit.empty() ? "" : " ", unit);
    if (!solved.track().has_profile()) {
      fmt::print(out, "timed by the frames of its {}\n", table ? "rows" : "keys");
      print_followed(plan, t, "    ", out);
      print_passed(plan, t, "    ", out);
      continue;
    }
    if (solved.track().portions().empty()) print_constant(plan, t, made.constant, out);
    if (const std::optional<OdeTable>& by = solved.integrated()) {
      fmt::print(out, "Runge-Kutta, {} integrations of {} steps a frame, speed within {:.2g} (frame {})\n",
                 by->integrations, by->substeps, made.speed_error, by->speed_error_frame);
    } else {
      fmt::print(out, "closed form, speed within {:g}\n", made.speed_error);
    }
    print_followed(plan, t, "    ", out);
    print_passed(plan, t, "    ", out);
    print_key_timing(solved, out);
  }
  print_rolls(plan, out);
}

void check_table_usage(const PlanArguments& arguments) {
  if (!arguments.trajectory) return;
  const std::string& name = *arguments.trajectory;
  if (!name.ends_with(".json") && !name.ends_with(".h")) {
    throw UsageError(
        fmt::format("--trajectory {}: the name must end in .json, or in .h for a C header", name));
  }
  if (!arguments.rig) {
    throw UsageError("--trajectory needs --rig RIG, whose limits say how the move is stopped");
  }
  if (arguments.solver == "runge-kutta") {
    throw UsageError("--solver runge-kutta knows frames only; leave out --trajectory or the solver");
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
  check_table_usage(arguments);
  refuse_outputs_in_one_place({{"MOVE", arguments.move}, {"--rig", arguments.rig}},
                              {{"--csv", arguments.csv},
                               {"--json", arguments.json},
                               {"--plot", arguments.plot},
                               {"--trajectory", arguments.trajectory}});
}

/// Refuses what `run` would refuse: nobody proves anything of it after this.
void write_trajectory(const Plan& plan, const std::string& name, std::FILE* out) {
  const CheckReport report = check(plan);
  refuse_beyond_limits(report);
  const TrajectoryTable table = trajectory_table(plan, report);
  write_output(name, [&](std::FILE* file) {
    if (name.ends_with(".h")) {
      write_table_header(table, table_name_of(name), file);
    } else {
      write_table_json(table, file);
    }
  });
  fmt::print(out, "{}: {} of {}, and a stop for each of {} places, which takes at most {:.3g} s\n", name,
             counted(static_cast<std::int64_t>(piece_count(table)), "piece"),
             counted(static_cast<std::int64_t>(table.motors.size()), "motor"), table.stops.size(),
             longest_stop_s(table));
}

int plan_command(const PlanArguments& arguments) {
  check_usage(arguments);
  const Solver solver = arguments.solver == "closed-form" ? Solver::closed_form : Solver::runge_kutta;
  const Plan plan = make_plan(arguments.move, arguments.rig, solver,
                              {.turns = arguments.turns, .frames = frame_range_argument(arguments.frames)});
  for (const Warning& warning : plan.keys_outside()) fmt::print(stderr, "{}\n", to_string(warning));
  const PlanRows rows = arguments.per == "tick" ? PlanRows::tick : PlanRows::frame;
  if (arguments.csv) {
    write_output(*arguments.csv, [&](std::FILE* file) { write_plan_csv(plan, rows, file); });
  }
  if (arguments.json) {
    write_output(*arguments.json, [&](std::FILE* file) { write_plan_json(plan, rows, file); });
  }
  if (arguments.plot) draw_plot(plot_of(plan), *arguments.plot, arguments.style);
  std::FILE* const out = summary_stream(arguments.csv == "-" || arguments.json == "-");
  print_plan_summary(plan, out);
  if (arguments.trajectory) write_trajectory(plan, *arguments.trajectory, out);
  return 0;
}

void describe(CLI::App& app, PlanArguments& arguments) {
  app.add_option("MOVE", arguments.move, "the move: a TOML file with keys, a speed curve and a frame count")
      ->required();
  app.add_option("--rig", arguments.rig, "the rig: gives the axes their units, and ticks their rate");
  add_turns(app, arguments.turns);
  add_frames(app, arguments.frames,
             "a part of the move, 20..80 or 20.. or ..80, on a rig with rolls of its own");
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
  app.add_option(
      "--trajectory", arguments.trajectory,
      "write what plays as a table of polynomials with proven stops, for a microcontroller: .json, or "
      ".h for a C header (with --rig)");
  add_style(app, arguments.style);
  app.footer(R"(Examples:
  inbetween plan move.toml                                   a summary
  inbetween plan move.toml --plot move.svg                   a picture
  inbetween plan move.toml --csv - | head                    positions per frame
  inbetween plan move.toml --frames 20..80 --csv -           a part of the move, its frames numbered as ever
  inbetween plan move.toml --rig rig.toml --per tick --csv ticks.csv
  inbetween plan move.toml --rig rig.toml --trajectory move.h  a table that a microcontroller plays)");
}

}  // namespace

void add_plan_command(CLI::App& program, Command& chosen) {
  add_command(program, chosen, {"plan", "Solve a move and show it: summary, CSV, JSON, picture"}, describe,
              plan_command);
}

}  // namespace inbetween
