#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "drivers/linux/interrupt_watch.hpp"
#include "drivers/linux/key_terminal.hpp"
#include "host_tools/cli/agreement.hpp"
#include "host_tools/cli/command.hpp"
#include "host_tools/cli/progress_bar.hpp"
#include "host_tools/cli/setup_arguments.hpp"
#include "host_tools/loop/rig_session.hpp"
#include "host_tools/motions/go_to.hpp"
#include "host_tools/reference/axis_positions.hpp"
#include "host_tools/rig/rig_watch.hpp"

namespace inbetween {
namespace {

struct GotoArguments {
  SetupArguments setup;
  std::vector<std::string> targets, set_zero, stands_at;
  double share = 0.1;
  bool yes = false;
};

/// Writes the positions that the operator gives into the position file. Nothing moves.
int say_where_axes_stand(const GotoArguments& arguments) {
  std::vector<std::string> said = arguments.stands_at;
  said.reserve(said.size() + arguments.set_zero.size());
  for (const std::string& name : arguments.set_zero) said.push_back(name + "=0");
  const RigFile rig = read_rig(arguments.setup.rig);
  std::vector<GoTarget> stands;
  for (const auto& [name, position] : positions_of(said, "--stands-at")) {
    const std::size_t a = axis_named(rig, name);
    if (rig.axes[a].reference == Reference::by_drive) {
      throw InputError(rig.axes[a].place,
                       fmt::format("axis {}: its drive says where it is; set its position in the drive, or "
                                   "write reference = \"operator\" in the rig",
                                   in_quotes(name)));
    }
    if (rig.axes[a].drive_home) {
      throw InputError(
          rig.axes[a].place,
          fmt::format("axis {}: its drive counts from its home; use inbetween home", in_quotes(name)));
    }
    if (position < rig.axes[a].min || position > rig.axes[a].max) {
      throw InputError(
          rig.axes[a].place,
          fmt::format(
              "axis {} cannot stand at {:.15g} {}, outside {}; say where it stands, or correct min and "
              "max in the rig",
              in_quotes(name), position, to_string(rig.axes[a].unit), range_in_words(rig.axes[a])));
    }
    stands.push_back({.axis = a, .position = position});
  }
  RigReference reference = reference_of(rig, arguments.setup.positions, arguments.setup.simulated);
  for (const GoTarget& axis : stands) {
    reference.stands_at(axis.axis, axis.position);
    fmt::print("{}: stands at {:g} {}\n", rig.axes[axis.axis].name, axis.position,
               to_string(rig.axes[axis.axis].unit));
  }
  return 0;
}

int go(const GotoArguments& arguments) {
  const RigWatch watch(arguments.setup.rig);
  const RigFile rig = read_rig(arguments.setup.rig);
  const std::vector<GoTarget> targets = go_targets(rig, positions_of(arguments.targets, "goto"));
  RigReference reference = reference_of(rig, arguments.setup.positions, arguments.setup.simulated);
  const InterruptWatch interrupts;
  ProgressBar bar;
  GoOptions options{.share = arguments.share, .session = session_options_of(arguments.setup)};
  options.session.audience.interrupted = &InterruptWatch::asked;
  options.session.audience.rig_has_changed = [&] { return watch.has_changed(); };
  options.session.audience.progress = [&](std::int64_t tick, std::int64_t last) {
    bar.show(static_cast<double>(tick) / static_cast<double>(last),
             fmt::format("{:.1f} s", static_cast<double>(tick) / rig.rate_hz));
  };
  std::optional<KeyTerminal> terminal;
  if (KeyTerminal::is_there() && !arguments.setup.fast) {
    terminal.emplace();
    options.session.audience.keys = [&] { return terminal->read(); };
  }
  options.session.audience.confirm = [&](const std::string& question) {
    if (!arguments.yes) return agrees(*terminal, question);
    fmt::print(stderr, "{}\n", question);
    return true;
  };
  const SetupEnd end = go_to(rig, targets, reference, options);
  release_lost_terminal();
  fmt::print("{}: {}\n", rig.name, end.reason);
  std::vector<std::size_t> axes;
  axes.reserve(targets.size());
  for (const GoTarget& target : targets) axes.push_back(target.axis);
  if (!end.positions.empty()) print_positions(rig, reference, axes, end.positions);
  return end.is_done ? 0 : exit_fault;
}

int goto_command(const GotoArguments& arguments) {
  check_setup_usage(arguments.setup);
  const bool says = !arguments.set_zero.empty() || !arguments.stands_at.empty();
  if (says) {
    if (!arguments.targets.empty()) {
      throw UsageError("first say where axes stand, then let them go; write two commands");
    }
    if (arguments.setup.simulated && !arguments.setup.positions) {
      throw UsageError("a simulation keeps no positions; name a file with --positions");
    }
    return say_where_axes_stand(arguments);
  }
  if (arguments.targets.empty()) {
    throw UsageError("AXIS=POSITION is required, or --set-zero, or --stands-at");
  }
  static_cast<void>(positions_of(arguments.targets, "goto"));
  if (!arguments.yes && (arguments.setup.fast || !KeyTerminal::is_there())) {
    throw UsageError("nobody is at a terminal who could agree; add --yes");
  }
  if (arguments.setup.allow_jitter && arguments.share > jitter_share) {
    throw UsageError("with --allow-jitter --speed is 0.1 at most; lower it");
  }
  return go(arguments);
}

void describe(CLI::App& app, GotoArguments& arguments) {
  app.add_option("AXIS=POSITION", arguments.targets, "axes, and where they go, in the unit of each");
  add_setup_options(app, arguments.setup, true);
  app.add_option("--speed", arguments.share,
                 "the share of their velocity, acceleration and jerk that the axes may use")
      ->check(between(0.001, 1.0))
      ->capture_default_str();
  app.add_flag("--yes", arguments.yes, "agree that the axes move");
  app.add_option("--set-zero", arguments.set_zero, "axes that stand at 0 now; nothing moves");
  app.add_option("--stands-at", arguments.stands_at, "AXIS=POSITION, where axes stand now; nothing moves");
  app.footer(
      R"(Says what moves from where to where and how long it takes, and goes there after somebody agreed: with
Enter on a terminal, with --yes in a script. The axes move together on a straight line, from rest to rest,
inside their soft limits. Esc, q and Ctrl-C stop them on it. An axis that stands outside its limits comes in,
and only in, at --speed 0.1 at most.

An axis that does not know where it is does not go anywhere: home it, or bring it to its mark with jog and say
so with --set-zero. What is said is kept until the axis moves, and from then on where it rests; an axis that
was moving when the power was cut has to be told again, and so has one whose drive then tells another place:
most drives forget turns without power. An axis that its drive knows (reference = "drive") is refused.

Exit status: 0 there; 1 refused; 3 outside the limits; 4 stopped on the way.

Examples:
  inbetween goto --rig rig.toml pan=0 tilt=-15
  inbetween goto --rig rig.toml slide=250 --speed 0.5 --yes
  inbetween goto --rig rig.toml --set-zero focus
  inbetween goto --rig rig.toml --stands-at focus=120
  inbetween goto --rig rig.toml pan=20 --sim --fast --from pan=-10 --yes)");
}

}  // namespace

void add_goto_command(CLI::App& program, Command& chosen) {
  add_command(program, chosen, {"goto", "Bring axes to positions, or say where they stand"}, describe,
              goto_command);
}

}  // namespace inbetween
