#include <CLI/CLI.hpp>

#include "host_tools/cli/command.hpp"

namespace inbetween {
namespace {

void describe(CLI::App& app, EditArguments& arguments) {
  app.add_option("MOVE", arguments.move, "the move: a TOML file with keys, a speed curve and a frame count")
      ->required();
  app.add_option("--rig", arguments.rig, "the rig: gives the axes units and limits");
  app.add_option("--port", arguments.port,
                 "the port on this machine (0: that of the last launch, or any that is free)")
      ->check(between(0, 65535))
      ->capture_default_str();
  app.add_flag("--no-browser", arguments.no_browser, "print the address only");
  app.footer(
      R"(Serves one page to a browser on this machine and opens it: the path with its keys, the speed curve with the
limits above it, the frames, and a preview. The page solves the move itself, with the same numbers as plan.
Nothing here moves a rig.

Saving changes in the file what was edited; comments, order and everything else stay. Where somebody else has
changed the file meanwhile, the page says so and keeps both versions. What was not saved comes back with the page,
and a page that is open goes on when the program is started again. docs/editor.md is the manual.

A motion of another program that is dropped on the page becomes a move beside this one, with the questions of
inbetween import; it needs --rig.

Whoever has read the printed address can edit the move while the program runs: it has the key of the move, which
stays the same. Key and port are kept in $XDG_STATE_HOME/inbetween, or in ~/.local/state/inbetween.

scripts/demo builds the page with the program, and the Debian package has it.

Examples:
  inbetween edit move.toml --rig rig.toml
  inbetween edit move.toml --port 8080 --no-browser    from another machine: ssh -L 8080:127.0.0.1:8080)");
}

}  // namespace

void add_edit_command(CLI::App& program, Command& chosen, const EditCommand& edit) {
  add_command(program, chosen, {"edit", "Edit a move in the browser: its path, its speed curve, its frames."},
              describe, edit);
}

}  // namespace inbetween
