#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

#include "host_tools/cli/budget.hpp"
#include "host_tools/cli/command.hpp"

namespace inbetween {
namespace {

int budget_command(const BudgetCapacity& capacity) {
  if (capacity.locks > capacity.keys) {
    throw UsageError(
        fmt::format("--locks {} is more than --keys {}; raise --keys", capacity.locks, capacity.keys));
  }
  print_budget(capacity, stdout);
  return 0;
}

void describe(CLI::App& app, BudgetCapacity& capacity) {
  const auto add_count = [&](const char* name, std::int32_t& count, std::int32_t min, std::int32_t max,
                             const char* what) {
    app.add_option(name, count, what)->check(between(min, max))->capture_default_str();
  };
  add_count("--keys", capacity.keys, 1, largest_budget.keys, "keys of a track");
  add_count("--axes", capacity.axes, 1, largest_budget.axes, "axes of a track");
  add_count(
      "--control-values", capacity.control_values, 1, largest_budget.control_values,
      "control values of the speed curve; locked keys may refine a drawn one, to twice as many and more");
  add_count("--frames", capacity.frames, 1, largest_budget.frames, "frames of the move");
  add_count("--locks", capacity.locks, 0, largest_budget.locks,
            "keys with a frame, a hold or a break of their own");
  add_count("--rate", capacity.rate_hz, 1, largest_budget.rate_hz, "ticks of a CAN bus in a second");
  app.add_option("--delta", capacity.delta, "largest relative error of the speed")
      ->capture_default_str()
      ->check([](const std::string& text) {
        constexpr double min = Precision::smallest_delta;
        double delta = 0;
        const double above = largest_budget.delta;
        const bool known = CLI::detail::lexical_cast(text, delta) && delta >= min && delta < above;
        return known ? "" : fmt::format("{} is not in the range {:g} to below {:g}", text, min, above);
      });
  app.footer(
      R"(Five tables: the bytes that the caller of the core provides for every object of a move of that
capacity (the same on every processor); the worst stack of every public function on two microcontrollers,
added up from what the compiler says; the instructions that a tick of three axes takes there, counted in an
emulator; the bytes of two programs for these, one that solves a move and one that plays a table of
`inbetween plan --trajectory`. These three are limits, which the tests of the project hold. The last is the
load of a CAN bus with a CiA 402 drive for each axis: the bits of its cyclic frames, with all the stuffing
bits that there can be.

Examples:
  inbetween budget                                           8 keys, 3 axes, 240 frames
  inbetween budget --keys 100 --axes 16 --control-values 40 --frames 5000
  inbetween budget --delta 1e-4                              coarser, in less memory
  inbetween budget --axes 8 --rate 500                       eight drives on a bus, 500 ticks a second)");
}

}  // namespace

void add_budget_command(CLI::App& program, Command& chosen) {
  add_command(program, chosen, {"budget", "Say what a move takes of a machine: memory, stack, instructions"},
              describe, budget_command);
}

}  // namespace inbetween
