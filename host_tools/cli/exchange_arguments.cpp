#include "host_tools/cli/exchange_arguments.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <string_view>

#include "host_tools/cli/command.hpp"
#include "host_tools/scene/scene_format.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/output_file.hpp"

namespace inbetween {
namespace {

template <class Word>
std::vector<Word> words_of_option(const std::vector<std::string>& texts, std::string_view option,
                                  std::string_view remedy, std::optional<Word> (*read)(std::string_view)) {
  std::vector<Word> words;
  for (const std::string& text : texts) {
    const std::optional<Word> word = read(text);
    if (!word) throw UsageError(fmt::format("{} {}: {}", option, in_quotes(text), remedy));
    words.push_back(*word);
  }
  return words;
}

template <class Word>
std::optional<Word> word_of_option(const std::optional<std::string>& text, std::string_view option,
                                   std::string_view remedy, std::optional<Word> (*read)(std::string_view)) {
  if (!text) return std::nullopt;
  const std::optional<Word> word = read(*text);
  if (!word) throw UsageError(fmt::format("{} {}: {}", option, in_quotes(*text), remedy));
  return word;
}

}  // namespace

void add_exchange_options(CLI::App& app, ExchangeArguments& arguments) {
  const auto add_list = [&](const std::string& name, std::vector<std::string>& to, const std::string& what,
                            const std::string& type) {
    app.add_option(name, to, what)->expected(1)->take_all()->type_name(type);
  };
  add_list("--axis", arguments.axes,
           "which axis of the rig a column of the file is; =-AXIS where it goes the other way",
           "COLUMN=AXIS");
  add_list("--unit", arguments.units,
           "the unit of a column, or of all that it fits: mm, cm, m, in, ft, deg, rad, turn,\n"
           "or rig for that of the axis",
           "[COLUMN=]UNIT");
  add_list("--count", arguments.counts,
           "of a column with counts: which count is 0 of the axis, and how far one is\n"
           "(Pan=1500,-0.1deg)",
           "COLUMN=ZERO,STEP");
  app.add_option("--fps", arguments.fps, "rows a second, exactly: 24, 24000/1001")->type_name("RATE");
  app.add_option("--up", arguments.up, "which coordinate of positions in space points up: y or z")
      ->type_name("AXIS");
  app.add_option("--phase", arguments.phase,
                 "a row is the middle of the exposure of its frame (centre), or the boundary before the\n"
                 "frame, where the rig rests in stop motion (boundary)")
      ->type_name("PHASE");
  app.add_option("--format", arguments.format,
                 "where the name of the file does not tell: csv, raw-move, arcm, arcx, kuper, flair,\n"
                 "maya-mov, nuke-chan, servo-json, record, gltf, glb, usda")
      ->type_name("FORMAT");
  app.add_option("--take", arguments.take, "a take of the file of takes that is named")
      ->check(between(std::int64_t{1}, std::int64_t{1} << 40U))
      ->type_name("N");
  app.add_flag("--measured", arguments.is_measured,
               "of a take or a record: where the axes were, not where they were told to be");
  app.add_flag("--over", arguments.may_overwrite, "write over files that are there");
}

ExchangeWords exchange_words_of(const ExchangeArguments& arguments) {
  return {.axes = words_of_option<AxisWord>(arguments.axes, "--axis",
                                            "write COLUMN=AXIS, or COLUMN=- for none", axis_word_of),
          .units = words_of_option<UnitWord>(
              arguments.units, "--unit",
              fmt::format("write COLUMN=UNIT, or one unit: {}, rig", comma_separated(move_unit_words)),
              unit_word_of),
          .counts = words_of_option<CountWord>(
              arguments.counts, "--count", "write COLUMN=ZERO,STEP, such as Pan=1500,-0.1deg", count_word_of),
          .fps = word_of_option<FrameRate>(arguments.fps, "--fps", "write an exact rate, 24 or 24000/1001",
                                           frame_rate_of_word),
          .up = word_of_option<UpAxis>(arguments.up, "--up", "write y or z", up_axis_of_word),
          .phase = word_of_option<ShutterPhase>(arguments.phase, "--phase", "write centre or boundary",
                                                phase_of_word),
          .format = word_of_option<ExchangeFormat>(
              arguments.format, "--format",
              fmt::format("write one of {}, {}", comma_separated(exchange_format_words),
                          comma_separated(scene_format_words)),
              exchange_format_of_word)};
}

void refuse_to_overwrite(const std::string& file, bool may_overwrite) {
  std::error_code unknown;
  if (may_overwrite || file == "-" || is_special(file) || !std::filesystem::exists(file, unknown)) return;
  throw InputError({file}, "is there already; add --over to write over it, or name another file");
}

}  // namespace inbetween
