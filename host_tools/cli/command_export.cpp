#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/cli/command.hpp"
#include "host_tools/cli/exchange_arguments.hpp"
#include "host_tools/cli/scene_export.hpp"
#include "host_tools/cli/take_arguments.hpp"
#include "host_tools/cli/take_table.hpp"
#include "host_tools/exchange/export_choices.hpp"
#include "host_tools/exchange/plan_table.hpp"
#include "host_tools/text/output_file.hpp"

namespace inbetween {
namespace {

struct ExportArguments {
  std::string from, to;
  std::optional<std::string> rig, frames, tip, line_test;
  ExchangeArguments exchange;
  std::optional<std::int32_t> decimals, turns;
  bool has_rolls = false;
};

ExchangeFormat written_format(const ExportArguments& arguments, const ExchangeWords& words) {
  if (words.format) return *words.format;
  if (arguments.to == "-") throw UsageError("standard output has no ending; say the format with --format");
  try {
    return exchange_format_to_write(arguments.to);
  } catch (const InputError& error) {
    throw InputError(error.place(), error.message() + " with --format");
  }
}

BakedTable exported_plan(const ExportArguments& arguments, const ExchangeWords& words) {
  if (!arguments.rig) throw UsageError("--rig is required: in whose units the axes count");
  if (arguments.exchange.is_measured) throw UsageError("--measured is for a take; add --take N");
  const Plan plan = make_plan(arguments.from, arguments.rig, Solver::closed_form,
                              {.turns = arguments.turns, .frames = frame_range_argument(arguments.frames)});
  return table_of_plan(plan, {.fps = words.fps,
                              .phase = words.phase.value_or(ShutterPhase::frame_boundary),
                              .has_rolls = arguments.has_rolls});
}

BakedTable exported_take(const ExportArguments& arguments) {
  const ExchangeArguments& exchange = arguments.exchange;
  if (arguments.frames || arguments.turns || arguments.has_rolls || exchange.fps || exchange.phase) {
    throw UsageError(
        "a take has the frames, the rate and the phase that it was played with; leave out --frames, "
        "--turns, --rolls, --fps and --phase");
  }
  TakeStore store(named_takes_file(arguments.from), TakeStore::Access::read);
  return frames_of_take(store, *exchange.take,
                        exchange.is_measured ? RecordedPositions::actual : RecordedPositions::told);
}

/// Degrees as whole numbers would lose all that is behind the point.
void refuse_positions_of_servos(const BakedTable& table) {
  std::string open;
  for (const BakedColumn& column : table.columns) {
    if (!column.is_in_counts) open += fmt::format(" --count \"{}=ZERO,STEP\"", column.name);
  }
  if (open.empty()) return;
  throw InputError({table.file},
                   "servos have counts; say which count is 0 of the axis and how far one is, with" + open);
}

/// Pictures, and a scene of the same beside them.
int export_line_test(const ExportArguments& arguments) {
  if (!arguments.to.empty() || arguments.exchange.format)
    throw UsageError("--line-test has its own files; leave out --to and --format");
  if (arguments.has_rolls || arguments.decimals)
    throw UsageError("a line test has the frames of the move; leave out --rolls and --decimals");
  return export_scene({.from = arguments.from,
                       .to = (std::filesystem::path(*arguments.line_test) / "scene.glb").string(),
                       .rig = arguments.rig,
                       .frames = arguments.frames,
                       .tip = arguments.tip,
                       .turns = arguments.turns,
                       .line_test = arguments.line_test,
                       .exchange = arguments.exchange},
                      SceneFormat::glb);
}

int export_as_scene(const ExportArguments& arguments, SceneFormat format) {
  if (arguments.has_rolls) throw UsageError("a scene has the frames of the move; leave out --rolls");
  if (arguments.decimals) throw UsageError("a scene has its numbers in full; leave out --decimals");
  return export_scene({.from = arguments.from,
                       .to = arguments.to,
                       .rig = arguments.rig,
                       .frames = arguments.frames,
                       .tip = arguments.tip,
                       .turns = arguments.turns,
                       .line_test = {},
                       .exchange = arguments.exchange},
                      format);
}

int export_command(const ExportArguments& arguments) {
  if (arguments.line_test) return export_line_test(arguments);
  if (arguments.to.empty()) throw UsageError("--to is required: the file that is written");
  const auto scene = scene_format_of(arguments.exchange.format, arguments.to);
  if (scene) return export_as_scene(arguments, *scene);
  if (arguments.tip) throw UsageError("--tip is for a scene (.gltf, .glb, .usda); leave it out");
  const ExchangeWords words = exchange_words_of(arguments.exchange);
  const ExchangeFormat format = written_format(arguments, words);
  const bool is_take = arguments.exchange.take.has_value();
  refuse_outputs_in_one_place(
      {{"MOVE", is_take ? named_takes_file(arguments.from) : arguments.from}, {"--rig", arguments.rig}},
      {{"--to", arguments.to}});
  refuse_to_overwrite(arguments.to, arguments.exchange.may_overwrite);
  check_output(arguments.to);
  const BakedTable table =
      exported_table(is_take ? exported_take(arguments) : exported_plan(arguments, words),
                     {.axes = words.axes, .units = words.units, .counts = words.counts, .up = words.up});
  if (format == ExchangeFormat::servo_json) refuse_positions_of_servos(table);
  const std::string text = write_baked_table(format, table, arguments.decimals);
  for (const Warning& warning : table.warnings) complain(to_string(warning));
  write_output(arguments.to, [&](std::FILE* out) { std::fwrite(text.data(), 1, text.size(), out); });
  std::FILE* const out = summary_stream(arguments.to == "-");
  if (arguments.to != "-") {
    fmt::print(out, "{}: {} of {}, {}\n", arguments.to,
               counted(static_cast<std::int64_t>(table.rows()), "row"),
               counted(std::ssize(table.columns), "column"), to_string(format));
  }
  for (const std::string& loss : losses_of(format, table, arguments.decimals))
    fmt::print(out, "  {} has {}\n", to_string(format), loss);
  fmt::print(out, "  the path, the keys and the speed curve are in the move only: keep it\n");
  return 0;
}

constexpr char export_explanation[] =
    R"(Writes what plays, a row a frame and a column an axis, for another program: CSV, Dragonframe Raw Move (.txt with
--format raw-move) and .arcm, Kuper ASCII, Flair CARTS_RAW, Maya .mov, Nuke .chan, the JSON of
blender-servo-animation; glTF and USD. The ending of the file tells the format where only one has it. Each line behind the summary
is something that the format does not hold: the other program has to be told.

Every axis that is in a track is a column of its name, in its unit, on every frame, from frame 0 to the end.
--axis COLUMN=AXIS names columns otherwise and chooses them, --unit converts, --count writes counts of servos:
what import takes is written with the same options. --fps takes another rate, --phase centre puts each row half a
row later, in the middle of its exposure.

A file that ends in .gltf, .glb or .usda is a scene: the links of the rig's URDF file and its camera, as they move, for
Blender, Unreal, Houdini, Maya and viewers. --up and --unit say in which space USD has it; glTF has metres and y up.
The summary says how far the camera is off between two rows; --fps takes more of them. --line-test DIR draws a picture
for each frame: the path of the camera, the links of the rig, and what the camera sees.

With --take N a file of takes is named in place of the move: rows are where the axes were told to be when the move
passed each frame, with --measured where they were.

Exit status 1 where the motion cannot be written so. Nothing is written over without --over.

Examples:
  inbetween export move.toml --rig rig.toml --to move.csv
  inbetween export move.toml --rig rig.toml --to move.arcm --unit deg
  inbetween export move.toml --rig rig.toml --to k.txt --format kuper --axis vPan=pan --axis vTrack=-slide --unit cm
  inbetween export move.toml --rig rig.toml --to jaw.json --axis Jaw=jaw --count "Jaw=1500,-0.1deg"
  inbetween export move.toml --rig rig.toml --to - --format csv --fps 25 --phase centre
  inbetween export move.toml --rig rig.toml --to shot.glb
  inbetween export move.toml --rig rig.toml --to shot.usda --up y --unit cm
  inbetween export move.toml --rig rig.toml --line-test pictures
  inbetween export takes.db --take 7 --measured --to measured.csv)";

void describe(CLI::App& app, ExportArguments& arguments) {
  app.add_option("MOVE", arguments.from, "the move, or with --take a file of takes")->required();
  app.add_option("--rig", arguments.rig, "the rig that it is for; not with --take");
  app.add_option("--to", arguments.to, "the file that is written (- is standard output)");
  add_exchange_options(app, arguments.exchange);
  app.add_option("--line-test", arguments.line_test,
                 "in place of --to: a folder with a picture of the rig for each frame, and scene.glb")
      ->type_name("DIR");
  app.add_option("--tip", arguments.tip, "of a scene: the tip of the rig that carries the camera")
      ->type_name("TIP");
  app.add_option("--decimals", arguments.decimals, "of each number, where the format has others")
      ->check(between(0, 12));
  add_frames(app, arguments.frames, "these frames only");
  add_turns(app, arguments.turns);
  app.add_flag("--rolls", arguments.has_rolls, "the pre-roll and the post-roll as well");
  app.footer(export_explanation);
}

}  // namespace

void add_export_command(CLI::App& program, Command& chosen) {
  add_command(program, chosen, {"export", "Write a move, or a take, for another program"}, describe,
              export_command);
}

}  // namespace inbetween
