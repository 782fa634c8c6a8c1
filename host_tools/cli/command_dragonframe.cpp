#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "drivers/linux/host_port.hpp"
#include "drivers/linux/interrupt_watch.hpp"
#include "drivers/linux/key_terminal.hpp"
#include "host_tools/cli/command.hpp"
#include "host_tools/cli/run_screen.hpp"
#include "host_tools/cli/setup_arguments.hpp"
#include "host_tools/hosted/host_session.hpp"
#include "host_tools/reference/axis_positions.hpp"
#include "host_tools/rig/rig_watch.hpp"

namespace inbetween {
namespace {

struct DragonframeArguments {
  SetupArguments setup;
  std::string device;
  std::string protocol;
  double share = transit_share;
  bool yes = false;
};

/// The state of the connection, and the last things that happened below it.
class HostNotes {
 public:
  HostNotes(RunScreen& screen, bool is_shown) : screen_(screen), is_shown_(is_shown) {}
  void tell(const std::string& state, const std::vector<std::string>& events) {
    for (const std::string& event : events) {
      if (!is_shown_) fmt::print(stderr, "{}\n", event);
      events_.push_back(event);
    }
    constexpr std::size_t shown = 6;
    if (events_.size() > shown) {
      events_.erase(events_.begin(), events_.end() - static_cast<std::ptrdiff_t>(shown));
    }
    if (!is_shown_) return;
    std::vector<std::string> notes{state};
    notes.insert(notes.end(), events_.rbegin(), events_.rend());
    screen_.tell(std::move(notes));
  }

 private:
  RunScreen& screen_;
  bool is_shown_;
  std::vector<std::string> events_;
};

int dragonframe(const DragonframeArguments& arguments) {
  const RigWatch watch(arguments.setup.rig);
  const RigFile rig = read_rig(arguments.setup.rig);
  if (!rig.dragonframe) {
    throw InputError({rig.path, 0, 0},
                     fmt::format("the rig does not say how many steps of Dragonframe make a unit; add "
                                 "[dragonframe] with steps_per_unit = {{ {} = 100.0, ... }}",
                                 rig.axes.front().name));
  }
  RigReference reference = reference_of(rig, arguments.setup.positions, arguments.setup.simulated);
  HostSessionOptions options{
      .protocol = arguments.protocol == "dmc" ? HostProtocol::dmc : HostProtocol::dfmoco,
      .consent = arguments.yes ? Consent::given : Consent::asked,
      .share = arguments.share,
      .session = session_options_of(arguments.setup)};
  HostPort port;
  if (const auto refusal = port.open(arguments.device, baud_of(options.protocol))) {
    throw InputError({arguments.device, 0, 0}, fmt::format("{}; {}", refusal->what, refusal->remedy));
  }
  fmt::print("{}: {} at {}\n", rig.name, arguments.protocol, port.name());
  std::fflush(stdout);
  const InterruptWatch interrupts;
  HostSessionEnd end;
  {
    std::optional<KeyTerminal> terminal;
    if (KeyTerminal::is_there()) terminal.emplace();
    RunScreen screen(
        fmt::format("{}{}, for Dragonframe", rig.name, arguments.setup.simulated ? ", simulated" : ""), rig);
    HostNotes notes(screen, terminal && screen.has_terminal());
    options.tell = [&](const std::string& state, const std::vector<std::string>& events) {
      notes.tell(state, events);
    };
    if (terminal) {
      options.session.audience.keys = [&] { return terminal->read(); };
      options.session.audience.status = [&](const RunSnapshot& now) { screen.show(now); };
    }
    options.session.audience.interrupted = &InterruptWatch::asked;
    options.session.audience.rig_has_changed = [&] { return watch.has_changed(); };
    end = give_to_host(rig, port, reference, options);
  }
  release_lost_terminal();
  fmt::print("{}: {}\n  late ticks {}; woken after {:.0f} us (99 %), {:.0f} us (worst)\n", rig.name,
             end.reason, end.late_ticks, end.latency.p99_us, end.latency.max_us);
  std::vector<std::size_t> axes(rig.axes.size());
  for (std::size_t a = 0; a < axes.size(); ++a) axes[a] = a;
  if (!end.positions.empty()) print_positions(rig, reference, axes, end.positions);
  return end.is_done ? 0 : exit_fault;
}

int dragonframe_command(const DragonframeArguments& arguments) {
  check_setup_usage(arguments.setup);
  if (!arguments.yes && !KeyTerminal::is_there()) {
    throw UsageError("nobody is at a terminal who could agree; add --yes");
  }
  if (arguments.setup.allow_jitter && arguments.share > jitter_share) {
    throw UsageError("with --allow-jitter --speed is 0.1 at most");
  }
  if (arguments.setup.allow_jitter && !arguments.setup.simulated) {
    throw UsageError("a host plays at its own speed, for which --allow-jitter has no bound; leave it out");
  }
  return dragonframe(arguments);
}

void describe_dragonframe(CLI::App& app, DragonframeArguments& arguments) {
  add_setup_options(app, arguments.setup, false);
  app.add_option("--device", arguments.device,
                 "a serial port, pty:NAME for a program on this machine, or tcp:127.0.0.1:PORT for tests")
      ->required();
  app.add_option("--protocol", arguments.protocol, "dmc or dfmoco, as Dragonframe is told")
      ->required()
      ->check(CLI::IsMember({"dmc", "dfmoco"}));
  app.add_option("--speed", arguments.share, "the share of their limits that the axes may use, but for a run")
      ->check(between(0.001, 1.0))
      ->capture_default_str();
  app.add_flag("--yes", arguments.yes, "agree to whoever connects");
  app.footer(
      R"(Is Dragonframe's motion control: the axes of the rig, in its order, are the motors 1, 2 and so on. The
section [dragonframe] of the rig says how many steps of the host make one unit of each.

Nothing moves until somebody agrees: Enter, once a host is connected. A stop, by the host or by Esc, and the end
of the connection take that back. Space and Esc stop, q and Ctrl-C leave. One host at a time has the rig.

Motors go one by one, along the uploaded move and to the start of a run as slowly as in goto and run: with
--speed times their limits at most, and no faster than the host has set. A run plays at its own speed, and is proven
before it is accepted: it keeps every limit of the rig, pre-roll and post-roll included, and can be stopped
everywhere. What is refused is answered with the code for it, and the terminal says why. docs/dragonframe.md says
message by message what is supported.

Exit status: 0 left; 1 refused; 4 stopped by a fault.

Examples:
  inbetween dragonframe --rig rig.toml --device /dev/ttyGS0 --protocol dmc
  inbetween dragonframe --rig rig.toml --device pty:/tmp/rig --protocol dfmoco --sim)");
}

}  // namespace

void add_dragonframe_command(CLI::App& program, Command& chosen) {
  add_command(program, chosen, {"dragonframe", "Be Dragonframe's motion control"}, describe_dragonframe,
              dragonframe_command);
}

}  // namespace inbetween
