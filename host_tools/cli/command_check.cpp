#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>

#include "host_tools/check/check.hpp"
#include "host_tools/check/check_frames.hpp"
#include "host_tools/check/check_output.hpp"
#include "host_tools/check/check_plot.hpp"
#include "host_tools/cli/command.hpp"
#include "host_tools/cli/progress_bar.hpp"
#include "host_tools/files/output_file.hpp"
#include "host_tools/files/speed_rewrite.hpp"
#include "host_tools/files/toml_source.hpp"
#include "host_tools/fit/fit_output.hpp"
#include "host_tools/fit/speed_fit.hpp"
#include "host_tools/plot/plot_limits.hpp"

namespace inbetween {
namespace {

struct CheckArguments {
  std::string move, rig;
  std::optional<std::string> json, plot, fit;
  std::string start = "drawn";
  std::optional<std::int32_t> turns;
};

/// Looks for a speed curve that fits, and writes the move with it.
SpeedFit fit_command(const CheckArguments& arguments, const Plan& plan, const CheckReport& report) {
  SpeedFit fit;
  {
    ProgressBar bar;
    fit = fit_speed(plan, report, arguments.start == "drawn" ? FitStart::drawn : FitStart::curvature,
                    [&](double share) { bar.show(share, "looking for a speed curve"); });
  }
  if (!fit.found) return fit;
  std::string text = read_text_file(arguments.move);
  for (const TrackFit& track : fit.tracks) {
    text = with_speed(text, arguments.move, track.track, track.speed);
  }
  write_output(*arguments.fit, [&](std::FILE* file) { std::fwrite(text.data(), 1, text.size(), file); });
  return fit;
}

void complain_of_no_fit(const Plan& plan, const SpeedFit& fit, const SmallestFrames& smallest) {
  const std::string place = to_string(plan.move().frames_place);
  complain(fmt::format("{}: error: no speed curve was found for {}: {}", place,
                       counted(plan.move().frames, "frame"), fit.reason));
  if (smallest.frames) {
    complain(
        fmt::format("{}: note: the curve as it is fits in {}", place, counted(*smallest.frames, "frame")));
  }
  if (plan.move().frames < fit.fewest.frames) return;  // the reason says so already
  complain(fmt::format("{}: note: in fewer than {} there is none, because of {} of axis {}", place,
                       counted(fit.fewest.frames, "frame"),
                       fit.fewest.by_acceleration ? "max_velocity and max_acceleration" : "max_velocity",
                       in_quotes(plan.rig()->axes[fit.fewest.axis].name)));
}

int check_command(const CheckArguments& arguments) {
  if (arguments.fit && arguments.turns) {
    throw UsageError("--fit writes the move as it is, of one turn; leave out --turns");
  }
  refuse_unknown_picture(arguments.plot);
  refuse_outputs_in_one_place(
      {{"MOVE", arguments.move}, {"--rig", arguments.rig}},
      {{"--json", arguments.json}, {"--plot", arguments.plot}, {"--fit", arguments.fit}});
  if (arguments.json) check_output(*arguments.json);
  if (arguments.fit) check_output(*arguments.fit);
  const Plan plan = make_plan(arguments.move, arguments.rig, Solver::closed_form, arguments.turns);
  const CheckReport report = check(plan);
  SmallestFrames smallest;
  {
    ProgressBar bar;
    smallest = smallest_frames(plan, report, [&](double share, std::int32_t frames) {
      bar.show(share, fmt::format("trying {}", counted(frames, "frame")));
    });
  }
  std::optional<SpeedFit> fit;
  if (arguments.fit) fit = fit_command(arguments, plan, report);
  if (arguments.json) {
    write_output(*arguments.json, [&](std::FILE* file) {
      JsonWriter json(file);
      json.begin_object();
      write_check(json, report, smallest);
      if (fit) write_fit(json, *fit);
      json.end_object();
      json.finish();
    });
  }
  if (arguments.plot) draw_limits_plot(limits_plot_of(plan, report), *arguments.plot);
  std::FILE* out = summary_stream(arguments.json == "-" || arguments.fit == "-");
  print_check(plan, report, smallest, out);
  if (fit) print_fit(plan, *fit, *arguments.fit, out);
  if (fit && fit->found) return 0;
  for (const CheckRefusal& refusal : report.refusals)
    complain(LimitError(refusal.place, refusal.message).what());
  if (fit) complain_of_no_fit(plan, *fit, smallest);
  return report.fits() ? 0 : exit_limit;
}

void describe(CLI::App& app, CheckArguments& arguments) {
  app.add_option("MOVE", arguments.move, "the move: a TOML file with keys, a speed curve and a frame count")
      ->required();
  app.add_option("--rig", arguments.rig, "the rig: gives the axes their limits")->required();
  add_turns(app, arguments.turns);
  app.add_option("--json", arguments.json, "write everything that was found (- is standard output)");
  app.add_option("--plot", arguments.plot,
                 "draw velocity, acceleration and jerk of every axis with its limits (.svg, .png or .pdf)");
  CLI::Option* fit = app.add_option(
      "--fit", arguments.fit,
      "write the move with a speed curve that fits in the same frames, changed as little as can be");
  app.add_option(
         "--start", arguments.start,
         "what the fitted curve is near to: the drawn one, or one that follows the curvature of the path")
      ->check(CLI::IsMember({"drawn", "curvature"}))
      ->needs(fit)
      ->capture_default_str();
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
      "spline = \"smooth\" has none at its keys unless the path turns back there (ease, corners), and a "
      "speed curve that begins and ends with 0, 0 none at "
      "its ends.\n\n"
      "The last line tells in how many frames the move would fit, its locked keys and holds moved in "
      "proportion.\n"
      "At one frame less it was tried and does not fit. Where slowing down cures nothing, it says why.\n\n"
      "--fit OUT writes the same file with another speed curve, comments and all else kept. It covers the "
      "same\n"
      "distance by the same frames, so that locked keys stay locked; rests stay rests. Where no curve with "
      "as\n"
      "many control values fits, it is given twice as many, and again. Where none is found, it says why, "
      "and\n"
      "below how many frames there can be none.\n\n"
      "A controlled stop from any moment, forward or backward, is proven as well: how long the longest "
      "takes,\n"
      "and that it keeps the stop limits of the rig.\n\n"
      "Exit status: 0 the move fits, or --fit found a curve; 3 it does not, and every reason is a line of "
      "standard error.\n\n"
      "Examples:\n"
      "  inbetween check move.toml --rig rig.toml                   a table of peaks, and the verdict\n"
      "  inbetween check move.toml --rig rig.toml --plot limits.svg where the peaks are\n"
      "  inbetween check move.toml --rig rig.toml --fit slower.toml the move, made to fit\n"
      "  inbetween check move.toml --rig rig.toml --json -          for other programs");
}

}  // namespace

void add_check_command(CLI::App& program, Command& chosen) {
  CLI::App* command = program.add_subcommand(
      "check", "Hold a move against the limits of a rig: is it inside them at every moment?");
  const auto arguments = std::make_shared<CheckArguments>();
  describe(*command, *arguments);
  command->callback([arguments, &chosen] { chosen = [arguments] { return check_command(*arguments); }; });
}

}  // namespace inbetween
