#include "host_tools/cli/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/cli/command.hpp"
#include "host_tools/files/output_file.hpp"
#include "host_tools/loop/rig_session.hpp"

namespace inbetween {

int run_command_line(int argc, const char* const* argv) {
  CLI::App app(
      "Moves camera rigs and puppets the way an animator draws the motion: key positions say where, one "
      "drawn\n"
      "speed curve says how fast, the frame count says how long.",
      "inbetween");
  app.set_version_flag("--version", "inbetween " INBETWEEN_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Files: docs/formats.md describes moves and rigs.\n"
      "Exit status: 0 done; 1 bad input; 2 wrong usage; 3 a limit would be exceeded; 4 stopped by a fault.");
  Command chosen;
  add_plan_command(app, chosen);
  add_check_command(app, chosen);
  add_run_command(app, chosen);
  add_goto_command(app, chosen);
  add_home_command(app, chosen);
  add_jog_command(app, chosen);
  add_sim_drives_command(app, chosen);
  add_budget_command(app, chosen);
  const auto wrong_usage = [&](const std::string& what) {
    const std::vector<CLI::App*> commands = app.get_subcommands();
    const std::string command = commands.empty() ? "" : commands.front()->get_name() + " ";
    complain(fmt::format("inbetween: error: {}; see inbetween {}--help", what, command));
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
    return wrong_usage(error.what());
  } catch (const UsageError& error) {
    return wrong_usage(error.what());
  } catch (const LimitError& error) {
    complain(error.what());
    return exit_limit;
  } catch (const PowerLeftError& error) {
    complain(error.what());
    return exit_fault;
  } catch (const std::exception& error) {
    complain(error.what());
    return exit_bad_input;
  }
}

}  // namespace inbetween
