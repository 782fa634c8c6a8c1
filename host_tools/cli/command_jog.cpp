#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <numeric>
#include <string>
#include <vector>

#include "drivers/linux/interrupt_watch.hpp"
#include "drivers/linux/key_terminal.hpp"
#include "host_tools/cli/command.hpp"
#include "host_tools/cli/setup_arguments.hpp"
#include "host_tools/loop/jitter.hpp"
#include "host_tools/motions/jog.hpp"
#include "host_tools/reference/axis_positions.hpp"
#include "host_tools/rig/rig_watch.hpp"

namespace inbetween {
namespace {

struct JogArguments {
  SetupArguments setup;
  std::string axis;
  double share = 0.1;
};

void print_speeds(const RigFile& rig, const RigReference& reference, double share) {
  for (std::size_t a = 0; a < rig.axes.size(); ++a) {
    const RigAxis& axis = rig.axes[a];
    const bool is_referenced = reference.is_referenced(a);
    const double speed =
        jog_speed(axis, is_referenced ? share : unreferenced_jog_share * share, 1.0 / rig.rate_hz);
    fmt::print(stderr, "  {:<16}{:>10.3f} {}/s{}\n", axis.name, speed, to_string(axis.unit),
               is_referenced ? "" : ", unreferenced: no limits, a short way at once");
  }
}

int jog_command(const JogArguments& arguments) {
  check_setup_usage(arguments.setup);
  if (!KeyTerminal::is_there()) throw UsageError("jog needs somebody at a terminal; use goto in a script");
  if (arguments.setup.allow_jitter && arguments.share > jitter_share) {
    throw UsageError("with --allow-jitter --speed is 0.1 at most");
  }
  const RigWatch watch(arguments.setup.rig);
  const RigFile rig = read_rig(arguments.setup.rig);
  const std::size_t selected = axis_named(rig, arguments.axis);
  RigReference reference = reference_of(rig, arguments.setup.positions, arguments.setup.simulated);
  print_speeds(rig, reference, arguments.share);
  const InterruptWatch interrupts;
  JogOptions options{.share = arguments.share, .session = session_options_of(arguments.setup)};
  SetupEnd end;
  {
    KeyTerminal terminal;
    ProgressBar bar;
    options.session.audience.keys = [&] { return terminal.read(); };
    options.session.audience.interrupted = &InterruptWatch::asked;
    options.session.audience.rig_has_changed = [&] { return watch.has_changed(); };
    options.session.audience.status = [&](const RunSnapshot& now) {
      if (now.jog) bar.show(now.share, status_line(now));
    };
    end = jog(rig, selected, reference, options);
  }
  release_lost_terminal();
  fmt::print("{}: {}\n", rig.name, end.reason);
  std::vector<std::size_t> all(end.positions.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  print_positions(rig, reference, all, end.positions);
  return end.is_done ? 0 : exit_fault;
}

void describe(CLI::App& app, JogArguments& arguments) {
  app.add_option("AXIS", arguments.axis, "the axis to begin with")->required();
  add_setup_options(app, arguments.setup, false);
  app.add_option("--speed", arguments.share,
                 "the share of their velocity at which axes move, if they can stop from it (0.001 to 1)")
      ->check(CLI::Range(0.001, 1.0))
      ->capture_default_str();
  app.footer(
      R"(Hold to run: the axis moves while left or right, or - or +, is held, and rests within 200 ms after
the key came for the last time. Up and down choose the axis, any other key stops it; q, Esc and Ctrl-C leave,
and so does a lost terminal. The first press is a nudge until the terminal begins to repeat it. Where an axis
cannot stop in that time from the speed that is asked for it is slower; the speeds are listed at the start.

Axes stay inside their soft limits. An unreferenced axis (one that does not know where it is) has none: it
moves at a tenth of the share at most, and a hundredth of the way between its limits until the key is let go
and pressed again. Bring it to its mark, and say so with inbetween goto --set-zero.

Exit status: 0 left; 1 refused; 4 stopped by something else.

Examples:
  inbetween jog --rig rig.toml focus
  inbetween jog --rig rig.toml pan --speed 0.02
  inbetween jog --rig rig.toml pan --sim --from pan=30)");
}

}  // namespace

void add_jog_command(CLI::App& program, Command& chosen) {
  add_command(program, chosen, {"jog", "Move axes by hand, as long as a key is held"}, describe, jog_command);
}

}  // namespace inbetween
