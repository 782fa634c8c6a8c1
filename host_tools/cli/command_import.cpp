#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/cli/asked_answers.hpp"
#include "host_tools/cli/command.hpp"
#include "host_tools/cli/exchange_arguments.hpp"
#include "host_tools/cli/import_fit.hpp"
#include "host_tools/cli/scene_import.hpp"
#include "host_tools/cli/take_arguments.hpp"
#include "host_tools/cli/take_table.hpp"
#include "host_tools/exchange/arc_move.hpp"
#include "host_tools/exchange/import_answers.hpp"
#include "host_tools/exchange/keyed_move.hpp"
#include "host_tools/exchange/motion_reading.hpp"
#include "host_tools/exchange/rows_move.hpp"
#include "host_tools/exchange/table_answers.hpp"
#include "host_tools/exchange/table_csv.hpp"
#include "host_tools/exchange/urdf_rig.hpp"
#include "host_tools/joints/kinematics.hpp"
#include "host_tools/text/output_file.hpp"

namespace inbetween {
namespace {

struct ImportArguments {
  std::string file, to;
  std::optional<std::string> rig, rotation_order, separator, frame_column, seconds_column;
  ExchangeArguments exchange;
  SceneArguments scene;
  bool has_decimal_commas = false;
  bool fills_gaps = false;
  std::vector<std::string> tolerances, resolutions;
  bool leaves_spikes_out = false;
  std::optional<std::string> plot;
  std::optional<std::int32_t> rate_hz;
  std::optional<double> reach_s;
};

void write_text(const std::string& name, const std::string& text) {
  write_output(name, [&](std::FILE* out) { std::fwrite(text.data(), 1, text.size(), out); });
}

std::string stem_of(const std::string& path) {
  return std::filesystem::path(path).stem().string();
}

// --- a rig

/// A rig is asked for nothing else: the file leaves open how fast it may go.
std::int32_t asked_rate_hz(const ImportArguments& arguments) {
  std::int32_t rate_hz = arguments.rate_hz.value_or(0);
  if (arguments.rate_hz) return rate_hz;
  const OpenQuestion question{.words = "how many ticks a second shall the rig have?",
                              .option = "--rate-hz 250"};
  ask_one(arguments.file, question, lines_of_terminal(),
          [&](const std::string& answer) -> std::optional<std::string> {
            const bool is_right =
                CLI::detail::lexical_cast(answer, rate_hz) && rate_hz >= 1 && rate_hz <= max_rate_hz;
            if (is_right) return std::nullopt;
            return fmt::format("write a whole number from 1 to {}", max_rate_hz);
          });
  return rate_hz;
}

/// The path begins at the folder of the rig, so that both may be moved together.
std::string path_from_rig(const std::string& urdf, const std::string& rig) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::absolute(rig).parent_path().lexically_normal();
  return fs::absolute(urdf).lexically_normal().lexically_proximate(folder).generic_string();
}

void refuse_options_of_motions(const ImportArguments& arguments) {
  const ExchangeArguments& exchange = arguments.exchange;
  const bool is_motion = arguments.rig || !exchange.counts.empty() || exchange.fps || exchange.phase ||
                         exchange.up || exchange.take || exchange.is_measured || arguments.plot ||
                         !arguments.tolerances.empty() || !arguments.resolutions.empty();
  if (is_motion)
    throw UsageError(fmt::format("{} becomes a rig; leave out what is said of motions", arguments.file));
}

UrdfRigChoices rig_choices(const ImportArguments& arguments) {
  UrdfRigChoices choices{.reach_s = arguments.reach_s};
  const ExchangeWords words = exchange_words_of(arguments.exchange);
  for (const AxisWord& word : words.axes) {
    if (word.is_left_out || word.axis != word.column)
      throw UsageError("an axis has the name of its joint; write --axis JOINT");
    choices.joints.push_back(word.axis);
  }
  for (const UnitWord& word : words.units) {
    if (word.column) throw UsageError("all joints of a kind count in one unit; write --unit deg, say");
    switch (word.unit) {
      case MoveUnit::deg:
      case MoveUnit::rad:
      case MoveUnit::turn:
        choices.angle = word.unit;
        break;
      case MoveUnit::mm:
      case MoveUnit::m:
        choices.length = word.unit;
        break;
      default:
        throw UsageError("a rig counts in deg, rad or turn, and in mm or m");
    }
  }
  choices.rate_hz = asked_rate_hz(arguments);
  return choices;
}

void print_open(const UrdfRig& rig) {
  constexpr std::size_t max_named = 6;
  std::vector<std::string> named(
      rig.open.begin(), rig.open.begin() + std::min(std::ssize(rig.open), std::ptrdiff_t{max_named}));
  if (rig.open.size() > max_named) named.push_back(fmt::format("{} more", rig.open.size() - max_named));
  fmt::print("  not in the file, to be filled in where a line has = ?: {}\n", comma_separated(named));
}

int import_urdf(const ImportArguments& arguments, const std::string& text) {
  refuse_options_of_motions(arguments);
  const UrdfFile file = parse_urdf(text, arguments.file);
  const UrdfRig rig = rig_of_urdf(file, path_from_rig(arguments.file, arguments.to), rig_choices(arguments));
  for (const Warning& warning : file.warnings) complain(to_string(warning));
  const bool is_whole = rig.open.empty();
  if (is_whole) static_cast<void>(Kinematics(file, parse_rig(rig.text, arguments.to)));
  write_text(arguments.to, rig.text);
  fmt::print("{}: {} and {} of {}, for --sim\n", arguments.to,
             counted(std::ssize(rig.axes), rig.axes.size() == 1 ? "axis" : "axe"),
             counted(std::ssize(rig.tips), "tip"), arguments.file);
  if (!is_whole) print_open(rig);
  return 0;
}

int import_scene(const ImportArguments& arguments, const ArcScene& scene) {
  refuse_options_of_motions(arguments);
  write_text(arguments.to, rig_of_arc_scene(scene, asked_rate_hz(arguments)));
  fmt::print("{}: {} of {}; answer each line that has = ?, and remove its #\n", arguments.to,
             scene.axes.size() == 1 ? "1 axis" : fmt::format("{} axes", scene.axes.size()), arguments.file);
  return 0;
}

// --- a motion

CsvReading csv_reading_of(const ImportArguments& arguments) {
  CsvReading reading{.has_decimal_commas = arguments.has_decimal_commas,
                     .fills_gaps = arguments.fills_gaps,
                     .frame_column = arguments.frame_column,
                     .seconds_column = arguments.seconds_column};
  if (arguments.separator) reading.separator = separator_of_word(*arguments.separator);
  return reading;
}

void refuse_options_of_csv(const ImportArguments& arguments, ExchangeFormat format) {
  const bool is_said = arguments.has_decimal_commas || arguments.fills_gaps || arguments.separator ||
                       arguments.frame_column || arguments.seconds_column;
  if (is_said && format != ExchangeFormat::csv) {
    throw UsageError(fmt::format("{} is no CSV file but {}; leave out how CSV is read", arguments.file,
                                 to_string(format)));
  }
}

RecordedPositions recorded_positions_of(const ImportArguments& arguments) {
  return arguments.exchange.is_measured ? RecordedPositions::actual : RecordedPositions::told;
}

BakedTable read_named_motion(const ImportArguments& arguments, ExchangeFormat format,
                             const std::string& text) {
  refuse_options_of_csv(arguments, format);
  if (arguments.exchange.is_measured && format != ExchangeFormat::record)
    throw UsageError("--measured is for a take or a record; leave it out");
  return read_motion(format, text, arguments.file,
                     {.csv = csv_reading_of(arguments), .positions = recorded_positions_of(arguments)});
}

ExchangeFormat format_of(const ImportArguments& arguments, const ExchangeWords& words,
                         const std::string& text) {
  if (words.format) return *words.format;
  try {
    return exchange_format_of(arguments.file, text);
  } catch (const UnclearFormat& unclear) {
    throw InputError(unclear.place(), unclear.message() + " (--format)");
  }
}

BakedTable table_of_take_file(const ImportArguments& arguments) {
  TakeStore store(named_takes_file(arguments.file), TakeStore::Access::read);
  return ticks_of_take(store, *arguments.exchange.take, recorded_positions_of(arguments));
}

/// Beside the move: shot.csv of shot.toml, unless that is what is imported.
std::string rows_file_of(const ImportArguments& arguments) {
  namespace fs = std::filesystem;
  const fs::path rows = fs::path(arguments.to).replace_extension(".csv");
  if (fs::weakly_canonical(rows) != fs::weakly_canonical(arguments.file)) return rows.string();
  return (rows.parent_path() / (rows.stem().string() + "_rows.csv")).string();
}

void write_rows_move(const ImportArguments& arguments, const RowsMove& move) {
  const std::string rows = rows_file_of(arguments);
  refuse_to_overwrite(rows, arguments.exchange.may_overwrite);
  check_output(rows);
  write_text(rows, rows_text_of(move, rows));
  write_text(arguments.to, move_text_of(move, std::filesystem::path(rows).filename().string()));
  fmt::print("{} and {}: {}\n", arguments.to, rows, summary_of(move));
}

void write_fitted_move(const ImportArguments& arguments, const RigFile& rig, const RowsMove& rows,
                       const std::vector<double>& tolerances) {
  const RowFit fit = fit_rows_move(rows, rig, tolerances);
  std::vector<std::string> comments = rows.comments;
  for (std::size_t a = 0; a < rows.axes.size(); ++a)
    comments.push_back(
        fmt::format("{} is within {} of its rows on every frame.", rows.axes[a], tolerances[a]));
  write_text(arguments.to, keyed_move_text_of(fit.move, comments));
  if (arguments.plot) draw_fit(rows, fit, rig, *arguments.plot);
  fmt::print("{}: {}, in {} of {} numbers\n", arguments.to, summary_of(rows), fit.numbers,
             rows.axes.size() * (rows.frames() + 1));
}

/// Spikes of scenes are named before the rig moves; they have no rounding that --smooth would be asked for.
int import_motion(const ImportArguments& arguments, BakedTable table, const ExchangeWords& words,
                  bool is_scene = false) {
  if (!arguments.rig) throw UsageError("--rig is required: whose axes the columns are");
  const RigFile rig = read_rig(*arguments.rig);
  ImportSaid said{.fps = words.fps,
                  .axes = words.axes,
                  .leaves_others_out = !words.axes.empty(),
                  .units = words.units,
                  .counts = words.counts,
                  .up = words.up,
                  .rotation_order = arguments.rotation_order,
                  .phase = words.phase};
  const bool was_asked = ask_open_questions(table, rig, lines_of_terminal(), said);
  table = imported_table(std::move(table), rig, said);
  std::vector<double> tolerances;
  if (!arguments.tolerances.empty()) tolerances = numbers_of_axes(arguments.tolerances, table, "--fit");
  if (is_scene && arguments.resolutions.empty()) warn_of_spikes(table, rig);
  if (!arguments.resolutions.empty()) {
    smooth_table(table, rig, numbers_of_axes(arguments.resolutions, table, "--smooth"),
                 arguments.leaves_spikes_out);
  }
  const RowsMove move = rows_move_of(table, rig, stem_of(arguments.to));
  for (const Warning& warning : table.warnings) complain(to_string(warning));
  for (const std::string& warning : move.warnings) complain(to_string(Warning{{arguments.file}, warning}));
  if (tolerances.empty()) {
    write_rows_move(arguments, move);
  } else {
    write_fitted_move(arguments, rig, move, tolerances);
  }
  if (was_asked) fmt::print("  without questions:{}\n", as_options(said));
  return 0;
}

void refuse_options_of_files(const ImportArguments& arguments) {
  const bool is_said = arguments.has_decimal_commas || arguments.fills_gaps || arguments.separator ||
                       arguments.frame_column || arguments.seconds_column || arguments.rate_hz ||
                       arguments.reach_s || arguments.rotation_order || arguments.exchange.take ||
                       arguments.exchange.is_measured;
  if (is_said) {
    throw UsageError(
        fmt::format("{} is a scene; leave out what is said of tables, of takes and of rigs", arguments.file));
  }
}

int import_scene_motion(const ImportArguments& arguments, SceneFormat format) {
  if (!arguments.rig) throw UsageError("--rig is required: whose tip goes where the scene goes");
  refuse_options_of_files(arguments);
  ExchangeArguments exchange = arguments.exchange;
  exchange.format.reset();  // it is this one
  const ExchangeWords words = exchange_words_of(exchange);
  SceneMotion motion =
      read_scene_motion(arguments.file, format, arguments.scene, words, read_rig(*arguments.rig));
  const int status = import_motion(arguments, std::move(motion.table), words, true);
  if (motion.tip) print_scene_miss(motion, arguments.to, *arguments.rig);
  return status;
}

int import_command(const ImportArguments& arguments) {
  if (arguments.to == "-" || !arguments.to.ends_with(".toml"))
    throw UsageError(fmt::format("--to {}: name a move or a rig, which ends in .toml", arguments.to));
  if (arguments.leaves_spikes_out && arguments.resolutions.empty())
    throw UsageError("--without-spikes is for --smooth, which finds them");
  if (arguments.plot && arguments.tolerances.empty()) throw UsageError("--plot draws what --fit misses");
  refuse_unknown_picture(arguments.plot);
  refuse_outputs_in_one_place({{"FILE", arguments.file}, {"--rig", arguments.rig}},
                              {{"--to", arguments.to}, {"--plot", arguments.plot}});
  if (arguments.tolerances.empty())
    refuse_outputs_in_one_place({{"FILE", arguments.file}},
                                {{"the rows beside --to", rows_file_of(arguments)}});
  refuse_to_overwrite(arguments.to, arguments.exchange.may_overwrite);
  check_output(arguments.to);
  if (const auto scene = scene_format_of(arguments.exchange.format, arguments.file))
    return import_scene_motion(arguments, *scene);
  if (arguments.scene.is_said()) {
    throw UsageError(
        fmt::format("{} is no scene (.gltf, .glb, .usda); leave out --node, --tip, --place, --scale "
                    "and --turn",
                    arguments.file));
  }
  const ExchangeWords words = exchange_words_of(arguments.exchange);
  if (arguments.rotation_order && !is_rotation_order(*arguments.rotation_order)) {
    throw UsageError(fmt::format("--rotation-order {}: write three axes in order, such as ZXY",
                                 in_quotes(*arguments.rotation_order)));
  }
  if (arguments.exchange.take) {
    if (arguments.rate_hz || arguments.reach_s) throw UsageError("--rate-hz and --reach are for a rig");
    return import_motion(arguments, table_of_take_file(arguments), words);
  }
  const std::string text = read_text_file(arguments.file, max_baked_bytes);
  const ImportedFile kind = imported_file_of(arguments.file, text);
  if (kind == ImportedFile::takes)
    throw InputError({arguments.file}, "this is a file of takes; name one of them with --take N");
  if (kind == ImportedFile::robot) return import_urdf(arguments, text);
  if (arguments.reach_s) throw UsageError("--reach is for the rig of a URDF file; leave it out");
  const ExchangeFormat format = format_of(arguments, words, text);
  if (format == ExchangeFormat::arc_scene) {
    const ArcScene scene = read_arc_scene(text, arguments.file);
    if (!scene.has_motion()) return import_scene(arguments, scene);
  }
  if (arguments.rate_hz) throw UsageError("--rate-hz is for a rig; a motion has --fps");
  return import_motion(arguments, read_named_motion(arguments, format, text), words);
}

constexpr char import_explanation[] =
    R"(A motion of another program, a row a frame and a column an axis, becomes a move: MOVE.toml, and MOVE.csv with the
rows beside it, in the units of the rig. The rows are played as they are. What is read: CSV, Dragonframe Raw Move
and .arcm, Kuper ASCII, Flair CARTS_RAW, Maya .mov, Nuke .chan, the JSON of blender-servo-animation, what
inbetween run --record wrote, and takes. docs/import-and-export.md says what each holds.

Most files do not say how many rows a second they have, in what unit a column counts, which axis it is, or where
in the exposure a row is. Nothing is guessed: an option says it, or it is asked at a terminal, a line each; Enter
agrees to what is suggested. Without a terminal one error line names all that is open, and its options. A column
goes by itself to the axis of exactly its name. Once one has an --axis, those without an axis are left out.

--fit TOLERANCE makes keys of the rows, which can be edited: few keys and a drawn speed curve, or few keys on
frames, whichever takes fewer numbers, never further than the tolerance from a row. --smooth RESOLUTION first takes
the steps out of rows that were rounded, in whole degrees or counts, say: the smoothest motion within half of it of
every row. A row that no smooth motion passes is named; --without-spikes leaves it out.

--phase centre puts row k half a frame behind frame k, as exposures are: the frames are computed between the rows.
With --phase boundary row k is frame k; this is what stop motion takes.

The robot of a URDF file becomes a rig: an axis for each joint that moves, with the range and the velocity of its
<limit>, and the links at its ends as tips. Accelerations are in no URDF file: --reach gives each axis the time in
which it comes to its velocity; without it they are left open, and the rig is refused until they are filled in. The
drives are simulated: real ones are written in their place. --axis JOINT takes some of the joints only. A scene of
Dragonframe without motion (.arcx) becomes a rig in which more is left open.

A camera or an object of a scene (.gltf, .glb, .usda) moves a tip of the rig: on every frame the axes are solved from its
URDF file, and the command says how far the tip is from the scene. --scale, --turn and --place put the scene on the
stage. With --axis columns of it are axes instead: tx, ty, tz in metres with z up, pan, tilt and roll.

Every row that is wrong is told: file, line, what, and what to do; exit status 1. Nothing is written over without
--over.

Examples:
  inbetween import pan.txt --rig rig.toml --to pan.toml       asks what the file does not say
  inbetween import p.txt --rig rig.toml --to p.toml --fps 24 --axis 1=pan --axis 2=tilt --unit deg --phase boundary
  inbetween import shot.csv --rig rig.toml --to shot.toml --axis PAN=pan --fps 24000/1001 --unit rad --phase centre
  inbetween import c.chan --rig rig.toml --to c.toml --axis tx=slide --axis ry=-pan --unit cm --fps 25 --up y
  inbetween import j.json --rig rig.toml --to j.toml --axis Jaw=jaw --count "Jaw=1500,-0.1deg" --phase boundary
  inbetween import takes.db --take 7 --measured --rig rig.toml --to again.toml
  inbetween import ik.json --rig rig.toml --to ik.toml --fps 24 --phase boundary --smooth 1 --fit 0.2 --plot fit.png
  inbetween import shot.glb --rig rig.toml --to shot.toml --fps 24 --node Camera --place 2,0,0 --turn 90
  inbetween import robot.urdf --to rig.toml --rate-hz 250 --reach 0.5)";

void describe(CLI::App& app, ImportArguments& arguments) {
  app.add_option("FILE", arguments.file, "the file of another program, a record, or a file of takes")
      ->required();
  app.add_option("--rig", arguments.rig, "the rig whose axes the columns are; not for a URDF file");
  app.add_option("--to", arguments.to, "the move or the rig that is written (.toml)")->required();
  add_exchange_options(app, arguments.exchange);
  add_scene_options(app, arguments.scene);
  app.add_option("--rotation-order", arguments.rotation_order,
                 "of a file with three angles: about which axes they turn, one after the other")
      ->type_name("ZXY");
  app.add_option("--separator", arguments.separator, "of a CSV file: comma, semicolon or tab")
      ->check(CLI::IsMember({"comma", "semicolon", "tab"}));
  app.add_flag("--decimal-comma", arguments.has_decimal_commas, "of a CSV file: decimals have a comma, 12,5");
  app.add_flag("--fill-gaps", arguments.fills_gaps,
               "of a CSV file: frames that are missing lie on a line between their neighbours");
  app.add_option("--frame-column", arguments.frame_column, "of a CSV file: the column of frame numbers");
  app.add_option("--seconds-column", arguments.seconds_column, "of a CSV file: the column of times");
  app.add_option(
         "--fit", arguments.tolerances,
         "few keys and a speed curve, or keys on frames, within this of every row: of all axes in the unit "
         "of each, or AXIS=NUMBER")
      ->type_name("TOLERANCE")
      ->allow_extra_args(false);
  app.add_option(
         "--smooth", arguments.resolutions,
         "rows were rounded to this, of all axes or AXIS=NUMBER: the smoothest motion within half of it")
      ->type_name("RESOLUTION")
      ->allow_extra_args(false);
  app.add_flag("--without-spikes", arguments.leaves_spikes_out,
               "rows that stand out follow the motion around them; without it they are refused by --smooth");
  app.add_option("--plot", arguments.plot, "a picture of what --fit misses (.svg, .png or .pdf)");
  app.add_option("--rate-hz", arguments.rate_hz, "of a rig that is made: its ticks a second")
      ->check(between(1, max_rate_hz));
  app.add_option("--reach", arguments.reach_s,
                 "of a rig of a URDF file: seconds in which an axis comes from rest to its max_velocity")
      ->check(between(0.001, 1'000.0))
      ->type_name("SECONDS");
  app.footer(import_explanation);
}

}  // namespace

void add_import_command(CLI::App& program, Command& chosen) {
  add_command(program, chosen, {"import", "Make a move of another program's rows, or a rig of a URDF file"},
              describe, import_command);
}

}  // namespace inbetween
