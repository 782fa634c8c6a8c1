#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "drivers/linux/interrupt_watch.hpp"
#include "drivers/linux/key_terminal.hpp"
#include "host_tools/cli/command.hpp"
#include "host_tools/cli/setup_arguments.hpp"
#include "host_tools/motions/home.hpp"
#include "host_tools/motions/transit.hpp"
#include "host_tools/rig/rig_watch.hpp"

namespace inbetween {
namespace {

struct HomeArguments {
  SetupArguments setup;
  std::vector<std::string> axes;
};

void print_outside(const RigFile& rig, const std::vector<std::size_t>& axes,
                   const std::vector<double>& positions, const std::string& as_arguments) {
  for (const std::size_t a : axes) {
    const RigAxis& axis = rig.axes[a];
    if (positions[a] >= axis.min && positions[a] <= axis.max) continue;
    fmt::print("  {} is outside its limits {}; {}\n", axis.name, range_in_words(axis),
               remedy_outside(rig, a, positions[a], as_arguments));
  }
}

int home_command(const HomeArguments& arguments) {
  check_setup_usage(arguments.setup);
  const RigWatch watch(arguments.setup.rig);
  const RigFile rig = read_rig(arguments.setup.rig);
  const std::vector<std::size_t> axes = home_axes(rig, arguments.axes);
  RigReference reference = reference_of(rig, arguments.setup.positions, arguments.setup.simulated);
  const InterruptWatch interrupts;
  SessionOptions options = session_options_of(arguments.setup);
  options.audience.interrupted = &InterruptWatch::asked;
  options.audience.rig_has_changed = [&] { return watch.has_changed(); };
  std::optional<KeyTerminal> terminal;
  if (KeyTerminal::is_there() && !arguments.setup.fast) {
    terminal.emplace();
    options.audience.keys = [&] { return terminal->read(); };
    std::vector<std::string> names;
    std::string parks;
    for (const std::size_t a : axes) {
      const RigAxis& axis = rig.axes[a];
      names.push_back(axis.name);
      if (axis.park)
        parks += fmt::format("; {} parks at {:g} {}", axis.name, *axis.park, to_string(axis.unit));
    }
    fmt::print(stderr, "homing {}{}; Esc stops\n", comma_separated(names), parks);
  }
  const SetupEnd end = home(rig, axes, reference, options);
  release_lost_terminal();
  fmt::print("{}: {}\n", rig.name, end.reason);
  if (!end.positions.empty()) print_positions(rig, reference, axes, end.positions);
  if (end.is_done) print_outside(rig, axes, end.positions, options.as_arguments);
  return end.is_done ? 0 : exit_fault;
}

void describe(CLI::App& app, HomeArguments& arguments) {
  app.add_option("AXIS", arguments.axes, "the axes to home (all that have a `home`)");
  add_setup_options(app, arguments.setup, true);
  app.footer(
      R"(The axes home together, as the `home` of each says: fast to the switch, back off it, and slowly onto
its edge, which is at the position `at`. Nothing moves faster than `fast`. Once all are home those that have a
`park` go to that position, together and at a tenth of their limits at most. Where an axis rests afterwards is
kept for the next command.

Axes whose CiA 402 drive homes them (`by = "drive"`) come first, one after the other, while no other drive of
the rig has power. Such a drive moves by itself, by its own switches and method, and takes no targets until it
is off again.

If one fails (its switch or home is not reached, stuck, chattering; a limit switch, an emergency stop), all axes stop,
and those that were not home by then do not know where they are. It says which failed, why, and what to do.
Esc, q and Ctrl-C stop it too.

Exit status: 0 home; 1 refused; 4 stopped before its end.

Examples:
  inbetween home --rig rig.toml
  inbetween home --rig rig.toml slide pan
  inbetween home --rig rig.toml --sim --fast --from slide=300)");
}

}  // namespace

void add_home_command(CLI::App& program, Command& chosen) {
  add_command(program, chosen, {"home", "Let axes find their homes"}, describe, home_command);
}

}  // namespace inbetween
