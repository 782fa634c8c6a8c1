#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>

#include "host_tools/cli/command.hpp"
#include "host_tools/cli/run_picture.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/output_file.hpp"

namespace inbetween {
namespace {

struct PlotArguments {
  std::string record;
  std::optional<std::string> rig, plot;
  PictureStyle style = PictureStyle::light;
};

int plot_command(const PlotArguments& arguments) {
  refuse_unknown_picture(arguments.plot);
  refuse_outputs_in_one_place({{"RECORD", arguments.record}, {"--rig", arguments.rig}},
                              {{"--plot", arguments.plot}});
  check_output(*arguments.plot);
  std::optional<RigFile> rig;
  if (arguments.rig) rig = read_rig(*arguments.rig);
  ReadRecord read = read_record(arguments.record, rig ? &*rig : nullptr);
  read.plot.name = std::filesystem::path(arguments.record).filename();
  read.plot.summary = counted(read.ticks, "tick");
  draw_run_plot(read.plot, *arguments.plot, arguments.style);
  fmt::print("{}: {} are drawn\n", *arguments.plot, counted(read.ticks, "tick"));
  return 0;
}

constexpr char plot_explanation[] =
    R"(RECORD is a file that inbetween run --record has written, of today or of an older version. Where the disk
was full it has fewer lines; those that it has are drawn.

Examples:
  inbetween plot takes/3.csv --plot takes/3.svg                  one picture of a take
  inbetween plot run.csv --rig rig.toml --plot run.png           with the units of the rig
  inbetween plot run.csv --plot run.pdf --style dark)";

void describe(CLI::App& app, PlotArguments& arguments) {
  app.add_option("RECORD", arguments.record, "the record of a run: CSV")->required();
  app.add_option("--rig", arguments.rig, "the rig that was recorded, which knows the units");
  app.add_option("--plot", arguments.plot,
                 "where to draw where every axis was told to be, where it was, and how far behind\n"
                 "(.svg, .png or .pdf)")
      ->required();
  add_style(app, arguments.style);
  app.footer(plot_explanation);
}

}  // namespace

void add_plot_command(CLI::App& program, Command& chosen) {
  add_command(program, chosen, {"plot", "Draw the record of a run"}, describe, plot_command);
}

}  // namespace inbetween
