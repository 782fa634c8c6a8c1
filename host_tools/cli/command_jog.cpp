#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "drivers/linux/interrupt_watch.hpp"
#include "drivers/linux/key_terminal.hpp"
#include "drivers/linux/monotonic_clock.hpp"
#include "host_tools/cli/command.hpp"
#include "host_tools/cli/held_keys.hpp"
#include "host_tools/cli/measured_scale.hpp"
#include "host_tools/cli/run_screen.hpp"
#include "host_tools/cli/setup_arguments.hpp"
#include "host_tools/cli/taught_keys.hpp"
#include "host_tools/loop/rig_session.hpp"
#include "host_tools/motions/jog.hpp"
#include "host_tools/reference/axis_positions.hpp"
#include "host_tools/rig/rig_watch.hpp"

namespace inbetween {
namespace {

constexpr double default_share = 0.1;

struct JogArguments {
  SetupArguments setup;
  std::string axis;
  double share = default_share;
  std::optional<std::string> device;
  double reach = jog_reach_share;
  std::optional<std::string> teach;
  std::vector<std::string> axes_of_new;
  std::optional<double> measure;
  bool yes = false;
};

void print_steps(const RigFile& rig, const std::vector<std::size_t>& axes, const RigReference& reference) {
  for (const std::size_t a : axes) {
    const RigAxis& axis = rig.axes[a];
    fmt::print(stderr, "  {:<16}steps of {:g} {}{}\n", axis.name, fmt::join(jog_increments(axis), ", "),
               to_string(axis.unit), reference.is_referenced(a) ? "" : "; unreferenced: no limits, slow");
  }
  if (axes.size() < rig.axes.size()) fmt::print(stderr, "  nothing is sent to the other drives of the rig\n");
}

int measure(const JogArguments& arguments) {
  if (arguments.device || arguments.teach) {
    throw UsageError("--measure moves the axis once; leave out --device and --teach");
  }
  if (!(std::fabs(*arguments.measure) > 0))
    throw UsageError("--measure is 0; write how far the axis is to move");
  if (arguments.share > default_share) throw UsageError("with --measure --speed is 0.1 at most");
  if (!arguments.yes && !KeyTerminal::is_there()) {
    throw UsageError("nobody is at a terminal who could agree; add --yes");
  }
  return measure_scale(arguments.setup, {.axis = arguments.axis,
                                         .distance = *arguments.measure,
                                         .share = arguments.share,
                                         .yes = arguments.yes});
}

int jog_command(const JogArguments& arguments) {
  check_setup_usage(arguments.setup);
  if (arguments.measure) return measure(arguments);
  if (arguments.yes) throw UsageError("--yes is for --measure");
  if (!KeyTerminal::is_there()) throw UsageError("jog needs somebody at a terminal; use goto in a script");
  if (arguments.setup.allow_jitter && arguments.share > jitter_share) {
    throw UsageError("with --allow-jitter --speed is 0.1 at most");
  }
  if (!arguments.axes_of_new.empty() && !arguments.teach)
    throw UsageError("--axes is for a new move; add --teach");
  std::optional<HeldKeys> held;
  if (arguments.device) held.emplace(*arguments.device);
  const RigWatch watch(arguments.setup.rig);
  const RigFile rig = read_rig(arguments.setup.rig);
  const std::size_t selected = axis_named(rig, arguments.axis);
  RigReference reference = reference_of(rig, arguments.setup.positions, arguments.setup.simulated);
  std::optional<TaughtKeys> teaching;
  if (arguments.teach) teaching.emplace(*arguments.teach, arguments.axes_of_new, rig, reference);
  const std::vector<std::size_t> axes = jogged_axes(rig, selected, reference);
  print_steps(rig, axes, reference);
  RigFile shown = rig;
  if (axes.size() == 1) shown.axes = {rig.axes[selected]};
  const InterruptWatch interrupts;
  JogOptions options{.share = arguments.share,
                     .reach = arguments.reach,
                     .has_device = held.has_value(),
                     .session = session_options_of(arguments.setup)};
  SetupEnd end;
  {
    KeyTerminal terminal;
    RunScreen screen(fmt::format("{}{}, by hand", rig.name, arguments.setup.simulated ? ", simulated" : ""),
                     shown);
    options.session.audience.keys = [&] { return terminal.read() + (held ? held->typed() : ""); };
    if (held) {
      options.session.audience.device = [&] { return held->read(MonotonicClock().now_ns()); };
    }
    options.session.audience.interrupted = &InterruptWatch::asked;
    options.session.audience.rig_has_changed = [&] { return watch.has_changed(); };
    options.session.audience.status = [&](const RunSnapshot& now) {
      if (!now.jog) return;
      if (teaching) screen.tell(teaching->shown(now.jog->axis));
      screen.show(now);
    };
    if (teaching) {
      options.teach = [&](TransportKey key, std::size_t axis, const std::vector<double>& positions) {
        teaching->press(key, axis, positions);
      };
    }
    end = jog(rig, selected, reference, options);
  }
  release_lost_terminal();
  fmt::print("{}: {}\n", rig.name, end.reason);
  if (!end.positions.empty()) print_positions(rig, reference, axes, end.positions);
  if (teaching) fmt::print("{}\n", teaching->summary());
  return end.is_done ? 0 : exit_fault;
}

constexpr const char* jog_explanation =
    R"(Left and right, or - and +, move the axis by one step; 1 to 5 choose how long it is, from fine to a hundredth of
the range between its limits, and a count of its drive at least. Up and down choose the axis, any other key stops
it; q, Esc and Ctrl-C leave, and so does a lost terminal. One step at a time: a press while an axis moves does
nothing.

A key that is held moves the axis on after its step, until it is let go or has moved it by the --reach; then it
must be pressed anew. A terminal with kitty's keyboard protocol (kitty, foot, Ghostty, WezTerm and others) tells
when a key is let go. Others, tmux and the console among them, repeat a key that is held: there a press waits
150 ms, a key counts as held once two repeats came at the rate of a keyboard (10 to 120 ms apart), and as let go
150 ms after the last one. The same silence ends it where a release is lost, the terminal hangs or the connection
drops. Keys that come later than they were pressed, all at once, move nothing.

With --device instead the axis moves while right or left, + or - on the keypad, or the cross of a game pad is
held, and rests as soon as its limits allow when it is let go, when the device is unplugged, or when it has
moved by the --reach. It begins from neutral only: after a second key, or a key that was held before, let go of
all. A program that does not look at the device for 150 ms takes it for let go. A detent of a wheel is one step
at once; detents that come while the axis moves are dropped, so that it rests when the wheel does, at the end of
its step. Nobody else hears the device meanwhile: its keys 1 to 5, up, down, q, Esc, Ctrl-C and those below do
what they do on the terminal, by their places on a US keyboard.

With --teach MOVE a key press stores where all axes of a track stand, in the track of the chosen axis: Enter
appends a key, i inserts one before the chosen key, t replaces the chosen key, n and p choose the next and the
previous one, u takes the last one back. Where the key before or behind stands already, nearer than a thousandth
of its range on every axis, it asks first: the same key again stores it. Each is written at once, and comments
stay. A file that somebody else changes meanwhile is read again and never overwritten. Keys of a track with
timing = "frames" can be replaced only, since a new one would need its frame; keys in the world, and of axes
that count round (wrap), are edited in the file. An unreferenced axis has no position to store. Whether the move
fits, check says.

With --measure DISTANCE nothing is moved by keys: put a mark where the axis stands, agree, measure how far it has
gone, and write that in its unit. The command says what to write into the rig. A drive that takes and tells
positions in one wrong scale cannot find that out by itself.

Axes stay inside their soft limits. One that stands outside moves inwards only, at a tenth of its velocity at
most until this command ends. An unreferenced axis (one that does not know where it is) has none: it
moves at a tenth of the share at most, and alone: where AXIS is one nothing is sent to the other drives of the
rig, and up and down choose nothing. Bring it to its mark, and say so with inbetween goto --set-zero.

Exit status: 0 left, by whichever key; 1 refused; 4 stopped by something else.

Examples:
  inbetween jog --rig rig.toml focus
  inbetween jog --rig rig.toml pan --speed 0.02
  inbetween jog --rig rig.toml pan --device /dev/input/by-id/usb-pad-event-joystick
  inbetween jog --rig rig.toml slide --teach move.toml
  inbetween jog --rig rig.toml slide --measure 100
  inbetween jog --rig rig.toml pan --sim --from pan=30)";

void describe(CLI::App& app, JogArguments& arguments) {
  app.add_option("AXIS", arguments.axis, "the axis to begin with")->required();
  add_setup_options(app, arguments.setup, false);
  app.add_option("--speed", arguments.share,
                 "the share of their limits that axes use meanwhile; a stop may use all of them")
      ->check(between(0.001, 1.0))
      ->capture_default_str();
  app.add_option("--device", arguments.device,
                 "a keyboard, game pad or jog wheel of /dev/input: its left and right move the axis while\n"
                 "they are held, its wheel moves it a step a detent");
  app.add_option("--reach", arguments.reach,
                 "the share of its range that a key that is held moves an axis at most, then it must be\n"
                 "pressed anew")
      ->check(between(0.001, 1.0))
      ->capture_default_str();
  app.add_option("--teach", arguments.teach,
                 "the move whose keys are stored where the rig stands; the first key makes a new one");
  app.add_option("--axes", arguments.axes_of_new,
                 "with --teach and a new move: its axes, with commas between; all of the rig unless said\n"
                 "otherwise")
      ->delimiter(',')
      ->allow_extra_args(false);
  app.add_option(
      "--measure", arguments.measure,
      "a distance, in the unit of the axis: it moves by it, once and slowly, then asks what you have\n"
      "measured, and says by what its scale is wrong");
  app.add_flag("--yes", arguments.yes, "with --measure: agree that the axis moves");
  app.footer(jog_explanation);
}

}  // namespace

void add_jog_command(CLI::App& program, Command& chosen) {
  add_command(program, chosen, {"jog", "Move axes by hand, step by step"}, describe, jog_command);
}

}  // namespace inbetween
