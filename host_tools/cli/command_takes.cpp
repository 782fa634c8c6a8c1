#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/cli/command.hpp"
#include "host_tools/cli/take_arguments.hpp"
#include "host_tools/cli/take_export.hpp"
#include "host_tools/cli/take_reports.hpp"
#include "host_tools/cli/takes_arguments.hpp"
#include "host_tools/takes/take_store.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/json_writer.hpp"
#include "host_tools/text/output_file.hpp"

namespace inbetween {
namespace {

std::string frames_in_list(const TakeInfo& take) {
  return fmt::format("{}..{}", take.part.first, take.part.last);
}

std::string ending_in_words(const TakeInfo& take) {
  if (take.ending.empty()) return "the program ended before the take did";
  return take.lost_ticks == 0 ? take.ending
                              : fmt::format("{} ({} lost)", take.ending, counted(take.lost_ticks, "tick"));
}

// --- list

void write_take_members(const TakeInfo& take, JsonWriter& json) {
  json.member("take", take.number);
  json.member("move", take.move_name);
  json.member("rig", take.rig_name);
  json.member("started_at", take.started_at);
  json.member("version", take.version);
  json.member("simulated", take.is_simulated);
  json.member("whole", take.is_whole);
  json.member("kept", take.is_marked);
  json.member("rate_hz", take.rate_hz);
  json.member("frames", take.frames);
  json.member("first", take.part.first);
  json.member("last", take.part.last);
  json.member("ticks", take.ticks);
  json.member("lost", take.lost_ticks);
  json.member("bytes", take.bytes);
  json.member("ended", take.ending);
}

void write_list_json(const std::vector<TakeInfo>& takes, const std::string& name) {
  write_output(name, [&](std::FILE* file) {
    JsonWriter json(file);
    json.begin_object();
    json.member("format", 1);
    json.line();
    json.objects("takes", takes, [&](const TakeInfo& take) { write_take_members(take, json); });
    json.end_object();
    json.finish();
  });
}

int list_takes(const TakesArguments& arguments) {
  TakeStore store = opened(arguments);
  const std::vector<TakeInfo> takes = store.list();
  if (arguments.json) write_list_json(takes, *arguments.json);
  if (arguments.json == "-") return 0;
  fmt::print("{:>6}  {:<19}  {:<20}  {:<20}{:>12}{:>10}{:>10}  {}\n", "take", "started (UTC)", "move", "on",
             "frames", "seconds", "size", "ended");
  for (const TakeInfo& take : takes) {
    std::string started = take.started_at.substr(0, 19);
    std::ranges::replace(started, 'T', ' ');
    fmt::print("{}{:>5}  {:<19}  {:<20}  {:<20}{:>12}{:>10.1f}{:>10}  {}\n", take.is_marked ? '*' : ' ',
               take.number, started, take.move_name, take.rig_name + (take.is_simulated ? ", simulated" : ""),
               frames_in_list(take), static_cast<double>(take.ticks) / std::max(take.rate_hz, 1),
               size_in_words(take.bytes), ending_in_words(take));
  }
  fmt::print("{} in {}, {}\n", counted(static_cast<std::int64_t>(takes.size()), "take"), store.file(),
             size_in_words(store.used_bytes()));
  return 0;
}

// --- show

const char* name_of(TakeEvent::Kind kind) {
  switch (kind) {
    case TakeEvent::Kind::state:
      return "state";
    case TakeEvent::Kind::fault:
      return "fault";
    case TakeEvent::Kind::pulse:
      return "pulse";
    case TakeEvent::Kind::key:
      return "key";
  }
  return "";
}

void write_take_json(const Take& take, const std::string& name) {
  write_output(name, [&](std::FILE* file) {
    JsonWriter json(file);
    json.begin_object();
    json.member("format", 1);
    write_take_members(take, json);
    json.line();
    json.objects("files", take.files, [&](const TakeFile& one) {
      json.member("path", one.path);
      json.member("hash", one.hash);
    });
    json.line();
    json.objects("axes", take.axes, [&](const TakeAxis& axis) {
      json.member("name", axis.name);
      json.member("unit", axis.unit);
      json.member("resolution", axis.resolution);
    });
    json.line();
    json.objects("events", take.events, [&](const TakeEvent& event) {
      json.member("tick", event.tick);
      json.member("kind", name_of(event.kind));
      json.member("text", event.text);
    });
    json.end_object();
    json.finish();
  });
}

int show_take(const TakesArguments& arguments) {
  if (arguments.budget && !arguments.has_errors) throw UsageError("--budget is for errors; add --errors");
  if (arguments.has_errors) return show_errors(arguments);
  TakeStore store = opened(arguments);
  const Take take = store.read_head(arguments.takes.front());
  if (arguments.json) write_take_json(take, *arguments.json);
  if (arguments.json == "-") return 0;
  fmt::print("take {}: {} on {}{}, started {}\n", take.number, take.move_name, take.rig_name,
             take.is_simulated ? ", simulated" : "", take.started_at);
  fmt::print("  {}\n", ending_in_words(take));
  fmt::print("  {}, {} at {} Hz, {}; by inbetween {}{}\n", frames_in_words(take.part, take.frames),
             counted(take.ticks, "tick"), take.rate_hz, size_in_words(take.bytes), take.version,
             take.is_marked ? "; kept for good" : "");
  for (const TakeFile& file : take.files) fmt::print("  {}  {}\n", file.path, file.hash);
  for (const TakeAxis& axis : take.axes)
    fmt::print("  {:<16} to {:.3g} {}\n", axis.name, axis.resolution, axis.unit);
  for (const TakeEvent& event : take.events) {
    fmt::print("  {:>10.3f} s  {:<6}{}\n", static_cast<double>(event.tick) / std::max(take.rate_hz, 1),
               name_of(event.kind), event.text);
  }
  return 0;
}

// --- the others

int plot_take(const TakesArguments& arguments) {
  refuse_unknown_picture(arguments.plot);
  check_output(*arguments.plot);
  if (arguments.is_trend) return plot_trend(arguments);
  if (arguments.json) throw UsageError("--json is for --trend; takes show and takes export write a take");
  if (arguments.takes.size() != 1)
    throw UsageError("name the take to draw, or draw the trend of all with --trend");
  TakeStore store = opened(arguments);
  draw_run_plot(plot_of_take(store, arguments.takes.front()), *arguments.plot, arguments.style);
  fmt::print("{}: take {} is drawn\n", *arguments.plot, arguments.takes.front());
  return 0;
}

int export_take(const TakesArguments& arguments) {
  const std::optional<std::string>& table = arguments.trajectory;
  if (!arguments.csv && !table) throw UsageError("name what to write: --csv FILE or --trajectory FILE");
  if (table && !table->ends_with(".json") && !table->ends_with(".h"))
    throw UsageError(
        fmt::format("--trajectory {}: the name must end in .json, or in .h for a C header", *table));
  refuse_outputs_in_one_place({{"--in", named_takes_file(arguments.in)}},
                              {{"--csv", arguments.csv}, {"--trajectory", table}});
  TakeStore store = opened(arguments);
  const std::int64_t take = arguments.takes.front();
  std::FILE* const out = summary_stream(arguments.csv == "-");
  if (arguments.csv) {
    export_take_csv(store, take, *arguments.csv);
    if (arguments.csv != "-") fmt::print(out, "{}: the record of take {}\n", *arguments.csv, take);
  }
  if (table) {
    export_take_trajectory(store, take, *table);
    fmt::print(out, "{}: the trajectory of take {}\n", *table, take);
  }
  return 0;
}

int delete_takes(const TakesArguments& arguments) {
  if (arguments.takes.empty() && !arguments.max_bytes)
    throw UsageError("name the takes to delete, or a size with --keep");
  TakeStore store = opened(arguments);
  for (const std::int64_t take : arguments.takes) static_cast<void>(store.read_head(take));  // all are there
  for (const std::int64_t take : arguments.takes) store.forget(take);
  std::vector<std::int64_t> gone = arguments.takes;
  if (arguments.max_bytes) {
    const std::vector<std::int64_t> oldest = store.prune(*arguments.max_bytes);
    gone.insert(gone.end(), oldest.begin(), oldest.end());
  }
  fmt::print("{}: {} deleted, {} left\n", store.file(),
             counted(static_cast<std::int64_t>(gone.size()), "take"), size_in_words(store.used_bytes()));
  if (!arguments.max_bytes || store.used_bytes() <= *arguments.max_bytes) return 0;
  complain(fmt::format("{}: warning: what is left is kept for good, and larger than {}", store.file(),
                       size_in_words(*arguments.max_bytes)));
  return 0;
}

int keep_takes(const TakesArguments& arguments) {
  TakeStore store = opened(arguments);
  for (const std::int64_t take : arguments.takes) static_cast<void>(store.read_head(take));
  for (const std::int64_t take : arguments.takes) store.mark(take, !arguments.is_not);
  fmt::print("{}: {} {}\n", store.file(), counted(static_cast<std::int64_t>(arguments.takes.size()), "take"),
             arguments.is_not ? "may be forgotten" : "kept for good");
  return 0;
}

// --- the command line

constexpr char takes_explanation[] =
    R"(Every inbetween run is a take, unless --no-take: the move and the rig with their texts, what was commanded in
every tick, where the axes were, what happened, which keys were pressed. They are in one SQLite file in the folder
of the move, inbetween-takes.db; --in names another, a folder, or a move beside it.

A take in the list with a * is kept for good: run --keep SIZE and delete --keep SIZE forget the oldest of the
others. What a run has told to be kept is there after a crash and after a power cut. A take that the program did
not end has what it had a second before.

inbetween run MOVE --rig RIG --take N plays take N again.

Examples:
  inbetween takes list                              of this folder
  inbetween takes list --in shots/reveal.toml       of the folder of a move
  inbetween takes show 7                            its files, axes and events
  inbetween takes plot 7 --plot take.svg            where every axis was told to be, was, and how far behind
  inbetween takes show 7 --errors                   how far off it was, at rest and moving, in mm and px too
  inbetween takes compare 1 7 --budget 1px          how far take 7 was from take 1: exit status 3 above 1 px
  inbetween takes compare 1 2 3 4 5                 accuracy and repeatability of a path, as ISO 9283 has them
  inbetween takes plot --trend --plot trend.svg     what wears: all takes of the last move, one after another
  inbetween takes export 7 --csv take.csv           what run --record would have written
  inbetween takes export 7 --trajectory take.json   what it played, for a microcontroller
  inbetween takes keep 7                            never forgotten; keep --not 7 takes that back
  inbetween takes delete 3 4                        these
  inbetween takes delete --keep 2G                  the oldest, until the others take no more than 2 GB)";

/// A subcommand with --in. What it does is done once all arguments are known.
CLI::App& add_act(CLI::App& app, TakesArguments& arguments, const CommandTitle& title,
                  int (*act)(const TakesArguments&)) {
  CLI::App& command = *app.add_subcommand(title.name, title.what);
  command.add_option("--in", arguments.in, "the file of takes, its folder, or a move in that folder")
      ->type_name("FILE");
  command.callback([&arguments, act] { arguments.act = act; });
  return command;
}

void add_one_take(CLI::App& command, TakesArguments& arguments) {
  command.add_option("TAKE", arguments.takes, "the number of a take")->required()->expected(1);
}

/// Adds --budget.
void add_budget(CLI::App& command, TakesArguments& arguments) {
  command
      .add_option_function<std::string>(
          "--budget", [&arguments](const std::string& text) { arguments.budget = parse_budget(text); },
          "how much it may be off: 1px, 0.2mm, 0.05deg; exit status 3 where it is more")
      ->type_name("SIZE");
}

void describe(CLI::App& app, TakesArguments& arguments) {
  app.require_subcommand(1);
  CLI::App& list = add_act(app, arguments, {"list", "List the takes of a folder"}, list_takes);
  list.add_option("--json", arguments.json, "write the list (- is standard output)");
  CLI::App& show =
      add_act(app, arguments, {"show", "Show what a take has, and what happened in it"}, show_take);
  add_one_take(show, arguments);
  show.add_flag(
      "--errors", arguments.has_errors,
      "where every axis was against where it was told to be; with joints the tips, with a lens the picture");
  add_budget(show, arguments);
  show.add_option("--json", arguments.json, "write it (- is standard output)");
  CLI::App& compare =
      add_act(app, arguments, {"compare", "Compare takes with the first of them"}, compare_takes);
  compare.add_option("TAKE", arguments.takes, "the numbers of two takes or more")
      ->required()
      ->expected(2, 10'000);
  add_budget(compare, arguments);
  compare.add_option("--json", arguments.json, "write it (- is standard output)");
  CLI::App& plot =
      add_act(app, arguments, {"plot", "Draw a take, or what changes from take to take"}, plot_take);
  plot.add_option("TAKE", arguments.takes,
                  "the number of a take; with --trend of several, or none for all of the last move");
  plot.add_flag("--trend", arguments.is_trend,
                "draw, take by take, how far each axis was behind at most, how long it settled, and its play "
                "where it turns");
  plot.add_option("--json", arguments.json, "with --trend, write the numbers (- is standard output)");
  plot.add_option("--plot", arguments.plot, "where to (.svg, .png or .pdf)")->required();
  add_style(plot, arguments.style);
  CLI::App& exported = add_act(app, arguments, {"export", "Write a take as another file"}, export_take);
  add_one_take(exported, arguments);
  exported.add_option("--csv", arguments.csv, "what run --record would have written (- is standard output)");
  exported.add_option("--trajectory", arguments.trajectory,
                      "what it played, as plan --trajectory writes it: .json, or .h for a C header");
  CLI::App& deleted = add_act(app, arguments, {"delete", "Delete takes"}, delete_takes);
  deleted.add_option("TAKE", arguments.takes, "the numbers of takes");
  add_keep_size(deleted, arguments.max_bytes,
                "the oldest that are not kept for good, until all take no more than this (20M, 1.5G)");
  CLI::App& kept = add_act(app, arguments, {"keep", "Keep takes for good"}, keep_takes);
  kept.add_option("TAKE", arguments.takes, "the numbers of takes")->required();
  kept.add_flag("--not", arguments.is_not, "they may be forgotten again");
  app.footer(takes_explanation);
}

int takes_command(const TakesArguments& arguments) {
  return arguments.act(arguments);
}

}  // namespace

TakeStore opened(const TakesArguments& arguments, TakeStore::Access access) {
  return {named_takes_file(arguments.in), access};
}

void add_takes_command(CLI::App& program, Command& chosen) {
  add_command(program, chosen,
              {"takes", "List, show, compare, draw, export and delete the runs that were kept"}, describe,
              takes_command);
}

}  // namespace inbetween
