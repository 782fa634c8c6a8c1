// The shared part of the commands of `inbetween`. Each command has a file of its own, command_NAME.cpp.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host_tools/cli/command_line.hpp"
#include "host_tools/plan/plan.hpp"
#include "host_tools/plot/plot_canvas.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

inline constexpr int exit_bad_input = 1;
inline constexpr int exit_wrong_usage = 2;
inline constexpr int exit_limit = 3;
inline constexpr int exit_fault = 4;
inline constexpr int exit_frames_missing = 5;

/// A mistake in the options that shows only when all options are known.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The command that was named, with its arguments. Returns the exit status.
using Command = std::function<int()>;

/// How a command is listed.
struct CommandTitle {
  const char* name;
  const char* what;
};

/// Adds a command to the program: `describe` gives it its options and its help, `run` does it. Only the
/// command that is named is described: to make the options of all of them would take longer than all else
/// that a start does.
template <class Arguments>
void add_command(CLI::App& program, Command& chosen, const CommandTitle& title,
                 void (*describe)(CLI::App&, Arguments&), const std::function<int(const Arguments&)>& run) {
  CLI::App* const command = program.add_subcommand(title.name, title.what);
  const auto arguments = std::make_shared<Arguments>();
  command->preparse_callback([command, arguments, describe](std::size_t) { describe(*command, *arguments); });
  command->callback([arguments, run, &chosen] { chosen = [arguments, run] { return run(*arguments); }; });
}
template <class Arguments>
void add_command(CLI::App& program, Command& chosen, const CommandTitle& title,
                 void (*describe)(CLI::App&, Arguments&), int (*run)(const Arguments&)) {
  add_command(program, chosen, title, describe, std::function<int(const Arguments&)>(run));
}

/// Add a command with its options and its help to the program. Parsing sets `chosen` if it is the one.
void add_plan_command(CLI::App& program, Command& chosen);
void add_check_command(CLI::App& program, Command& chosen);
void add_edit_command(CLI::App& program, Command& chosen, const EditCommand& edit);
void add_run_command(CLI::App& program, Command& chosen);
void add_goto_command(CLI::App& program, Command& chosen);
void add_home_command(CLI::App& program, Command& chosen);
void add_jog_command(CLI::App& program, Command& chosen);
void add_dragonframe_command(CLI::App& program, Command& chosen);
void add_plot_command(CLI::App& program, Command& chosen);
void add_takes_command(CLI::App& program, Command& chosen);
void add_import_command(CLI::App& program, Command& chosen);
void add_export_command(CLI::App& program, Command& chosen);
void add_sim_drives_command(CLI::App& program, Command& chosen);
void add_doctor_command(CLI::App& program, Command& chosen);
void add_budget_command(CLI::App& program, Command& chosen);

/// Prints one line to standard error.
void complain(const std::string& line);

/// Refuses what is not a number from `min` to `max`, and shows the range in the help. CLI::Range says both in
/// words of its own program.
template <class Number>
CLI::Validator between(Number min, Number max) {
  const std::string range = fmt::format("{} to {}", min, max);
  const auto refuse = [=](const std::string& text) {
    Number number{};
    const bool is_inside = CLI::detail::lexical_cast(text, number) && number >= min && number <= max;
    return is_inside ? std::string() : fmt::format("{} is not in the range {}", text, range);
  };
  return {refuse, range};
}

/// A file that a command reads or writes, with the argument that names it.
struct NamedFile {
  const char* argument;
  std::optional<std::string> name;
};

/// Throws UsageError if an output would overwrite an input or another output.
void refuse_outputs_in_one_place(const std::vector<NamedFile>& inputs, const std::vector<NamedFile>& outputs);

/// Throws UsageError if the name of a picture has no known ending.
void refuse_unknown_picture(const std::optional<std::string>& plot);

/// Reads a rig, and the data sheets of its drives: what one lacks is told before anything is connected.
/// Throws InputError.
RigFile read_rig(const std::string& path);

/// What of a move is played: so many turns of a periodic one, and of all that these frames.
struct PlayedPart {
  std::optional<std::int32_t> turns = {};
  FrameRange frames = {};
};

/// Reads and solves; warnings go to standard error.
Plan make_plan(const std::string& move, const std::optional<std::string>& rig, Solver solver,
               const PlayedPart& part = {});

/// Adds --turns.
void add_turns(CLI::App& app, std::optional<std::int32_t>& turns);

/// Adds --frames, which frame_range_argument reads.
void add_frames(CLI::App& app, std::optional<std::string>& frames, const std::string& what);
/// Reads frames such as "20..80". Throws UsageError.
FrameRange frame_range_argument(const std::optional<std::string>& text);

/// Adds --style, for a command that has --plot already.
void add_style(CLI::App& app, PictureStyle& style);

/// The stream for the summary: standard error if standard output carries data.
std::FILE* summary_stream(bool data_on_standard_output);

}  // namespace inbetween
