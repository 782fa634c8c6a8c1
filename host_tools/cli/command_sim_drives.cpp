#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "drivers/linux/interrupt_watch.hpp"
#include "host_tools/cli/command.hpp"
#include "host_tools/cli/setup_arguments.hpp"
#include "host_tools/motions/sim_drives.hpp"
#include "host_tools/rig/fault_script.hpp"
#include "host_tools/text/output_file.hpp"

namespace inbetween {
namespace {

struct SimDrivesArguments {
  std::string rig;
  std::vector<std::string> from;
  std::optional<std::string> faults;
  std::optional<std::string> record;
};

int sim_drives_command(const SimDrivesArguments& arguments) {
  refuse_outputs_in_one_place({{"--rig", arguments.rig}, {"--faults", arguments.faults}},
                              {{"--record", arguments.record}});
  const InterruptWatch interrupts;
  SimDrivesOptions options{.standing = positions_of(arguments.from), .interrupted = &InterruptWatch::asked};
  options.ready = [] { fmt::print(stderr, "the drives have power; Ctrl-C ends them\n"); };
  const RigFile rig = read_rig(arguments.rig);
  if (arguments.faults) options.faults = read_fault_script(*arguments.faults, rig);
  if (!arguments.record) {
    run_sim_drives(rig, options);
    return 0;
  }
  check_output(*arguments.record);
  write_output(*arguments.record, [&](std::FILE* file) {
    options.record = file;
    run_sim_drives(rig, options);
  });
  return 0;
}

void describe(CLI::App& app, SimDrivesArguments& arguments) {
  app.add_option("--rig", arguments.rig, "the rig: its buses must be there and up, vcan for example")
      ->required();
  app.add_option("--from", arguments.from,
                 "AXIS=POSITION, where an axis stands (0, or as near as its limits allow)")
      ->expected(1)
      ->take_all();
  app.add_option("--faults", arguments.faults, "a script of what goes wrong with them, and when");
  app.add_option("--record", arguments.record,
                 "the targets that the drives apply: axis, nanoseconds, counts or turns");
  app.footer(
      R"(Runs until Ctrl-C. Each drive boots, is set up, enabled and watched over as a real one is: it stops
by itself when the program that moves it falls silent.

On a machine without CAN:
  ip link add can0 type vcan && ip link set can0 up
  inbetween sim-drives --rig rig.toml &
  inbetween run move.toml --rig rig.toml
Where the kernel has no vcan, sim/bench/run gives a kernel that has; docs/bench.md shows how.)");
}

}  // namespace

void add_sim_drives_command(CLI::App& program, Command& chosen) {
  add_command(program, chosen,
              {"sim-drives", "Simulate the CAN drives of a rig as a process that speaks on its buses"},
              describe, sim_drives_command);
}

}  // namespace inbetween
