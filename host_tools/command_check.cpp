#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>

#include "host_tools/check.hpp"
#include "host_tools/check_frames.hpp"
#include "host_tools/check_output.hpp"
#include "host_tools/command.hpp"
#include "host_tools/output_file.hpp"
#include "host_tools/plot_limits.hpp"
#include "host_tools/progress_bar.hpp"

namespace inbetween {
namespace {

struct CheckArguments {
  std::string move, rig;
  std::optional<std::string> json, plot;
};

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

void describe(CLI::App& app, CheckArguments& arguments) {
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

}  // namespace

void add_check_command(CLI::App& program, Command& chosen) {
  CLI::App* command = program.add_subcommand(
      "check", "Hold a move against the limits of a rig: is it inside them at every moment?");
  const auto arguments = std::make_shared<CheckArguments>();
  describe(*command, *arguments);
  command->callback([arguments, &chosen] { chosen = [arguments] { return check_command(*arguments); }; });
}

}  // namespace inbetween
