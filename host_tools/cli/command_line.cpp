#include "host_tools/cli/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/cli/command.hpp"
#include "host_tools/loop/rig_session.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/output_file.hpp"
#include "host_tools/text/spelling.hpp"

namespace inbetween {
namespace {

/// "; did you mean --json?", where `mark` is "--", or `otherwise` if no word is near.
std::string remedy_for(std::string_view word, const std::vector<std::string>& words, std::string_view mark,
                       const std::string& otherwise) {
  const std::vector<std::string_view> views(words.begin(), words.end());
  const std::optional<std::string_view> meant = probably_meant(word, views);
  return meant ? fmt::format("; did you mean {}{}?", mark, *meant) : otherwise;
}

std::vector<std::string> commands_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands(nullptr)) names.push_back(command->get_name());
  return names;
}

std::vector<std::string> options_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back(name);
  }
  return names;
}

/// The first word that names nothing; empty if every word does.
std::string wrong_word(const CLI::App& app) {
  const std::vector<CLI::App*> given = app.get_subcommands();
  const CLI::App& command = given.empty() ? app : *given.front();
  const std::vector<std::string> left = command.remaining();
  for (const std::string& word : left) {
    if (word.size() < 2 || word.front() != '-') continue;
    const std::string option = word.substr(0, word.find('='));
    const std::string_view name = std::string_view(option).substr(std::min(option.size(), std::size_t{2}));
    return fmt::format("there is no option {}{}", option, remedy_for(name, options_of(command), "--", ""));
  }
  if (left.empty()) return given.empty() ? "no command is given" : "";
  if (!given.empty()) return fmt::format("{} is one argument too many", in_quotes(left.front()));
  const std::vector<std::string> commands = commands_of(app);
  return fmt::format("there is no command {}{}", in_quotes(left.front()),
                     remedy_for(left.front(), commands, "", "; there are " + comma_separated(commands)));
}

/// CLI11's "--json: 1 required TEXT missing" in plain words; everything else as it says it.
std::string plain(const std::string& what) {
  const std::size_t colon = what.find(": 1 required ");
  return colon == std::string::npos ? what : what.substr(0, colon) + " needs a value";
}

/// Where standard output is written line by line, printing to a full one fails at once, and with fewer words.
std::string words_of_output(const std::system_error& error) {
  if (std::ferror(stdout) == 0) return error.what();
  try {
    errno = error.code().value();
    check_standard_output();
  } catch (const std::runtime_error& full) {
    return full.what();
  }
  return error.what();
}

/// The command that is named, or all of them to be listed, or to find the one that was meant: to make all of
/// them takes as long as to read a small move.
void add_commands(CLI::App& app, Command& chosen, std::string_view named, const EditCommand& edit) {
  struct Named {
    std::string_view name;
    void (*add)(CLI::App&, Command&);  ///< null: edit
  };
  constexpr std::array commands{
      Named{"plan", add_plan_command},
      Named{"check", add_check_command},
      Named{"edit", nullptr},
      Named{"run", add_run_command},
      Named{"goto", add_goto_command},
      Named{"home", add_home_command},
      Named{"jog", add_jog_command},
      Named{"dragonframe", add_dragonframe_command},
      Named{"plot", add_plot_command},
      Named{"takes", add_takes_command},
      Named{"import", add_import_command},
      Named{"export", add_export_command},
      Named{"sim-drives", add_sim_drives_command},
      Named{"doctor", add_doctor_command},
      Named{"budget", add_budget_command},
  };
  const bool is_one = std::ranges::find(commands, named, &Named::name) != commands.end();
  for (const Named& command : commands) {
    if (is_one && command.name != named) continue;
    command.add != nullptr ? command.add(app, chosen) : add_edit_command(app, chosen, edit);
  }
}

}  // namespace

int run_command_line(int argc, const char* const* argv, const EditCommand& edit) {
  CLI::App app(
      "Moves camera rigs and puppets the way an animator draws the motion: key positions say where, one "
      "drawn\n"
      "speed curve says how fast, the frame count says how long.",
      "inbetween");
  app.set_version_flag("--version", "inbetween " INBETWEEN_VERSION);
  app.require_subcommand(1);
  app.footer(R"(Files: docs/formats.md describes moves and rigs.
Exit status: 0 done; 1 bad input; 2 wrong usage; 3 a limit would be exceeded; 4 stopped by a fault;
5 a shoot that ended with frames missing.)");
  Command chosen;
  add_commands(app, chosen, argc > 1 ? argv[1] : "", edit);
  const auto wrong_usage = [&](const std::string& what) {
    const std::vector<CLI::App*> commands = app.get_subcommands();
    const std::string command = commands.empty() ? "" : commands.front()->get_name() + " ";
    complain(fmt::format("inbetween: error: {}{} inbetween {}--help", what,
                         what.back() == '?' ? " See" : "; see", command));
    return exit_wrong_usage;
  };
  try {
    int status = 0;
    try {
      app.parse(argc, argv);
      status = chosen();
    } catch (const CLI::Success& asked) {  // --help, --version
      app.exit(asked);
      std::cout.flush();
    }
    check_standard_output();
    return status;
  } catch (const CLI::ParseError& error) {
    const std::string wrong = wrong_word(app);
    return wrong_usage(wrong.empty() ? plain(error.what()) : wrong);
  } catch (const UsageError& error) {
    return wrong_usage(error.what());
  } catch (const LimitError& error) {
    complain(error.what());
    return exit_limit;
  } catch (const PowerLeftError& error) {
    complain(error.what());
    return exit_fault;
  } catch (const std::system_error& error) {
    complain(words_of_output(error));
    return exit_bad_input;
  } catch (const std::exception& error) {
    complain(error.what());
    return exit_bad_input;
  }
}

}  // namespace inbetween
