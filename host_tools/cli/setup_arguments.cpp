#include "host_tools/cli/setup_arguments.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <system_error>

#include "host_tools/cli/command.hpp"
#include "host_tools/reference/position_file.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

void add_setup_options(CLI::App& command, SetupArguments& arguments, bool can_be_fast) {
  command.add_option("--rig", arguments.rig, "the rig: axes, limits, drives and the ticks per second")
      ->required();
  command.add_flag("--sim", arguments.simulated, "simulate every axis of the rig; no hardware is touched");
  if (can_be_fast) {
    command.add_flag("--fast", arguments.fast,
                     "simulated: on a virtual clock, as fast as it can be computed");
  }
  command
      .add_option("--from", arguments.from,
                  "AXIS=POSITION, where a simulated axis stands before (0, or the limit next to it)")
      ->expected(1)
      ->take_all();
  command.add_option("--positions", arguments.positions,
                     "where the positions of the axes are kept (on a rig: a file of its own under\n"
                     "$XDG_STATE_HOME, in a simulation: nowhere)");
  command.add_flag("--allow-jitter", arguments.allow_jitter,
                   "move a real rig without real-time rights, at a tenth of its limits at most");
}

void check_setup_usage(const SetupArguments& arguments) {
  static_cast<void>(positions_of(arguments.from));
  if (arguments.simulated) {
    if (arguments.allow_jitter) throw UsageError("--allow-jitter is for a real rig; leave out --sim");
    return;
  }
  if (arguments.fast) throw UsageError("--fast is for a simulated rig; add --sim");
  if (!arguments.from.empty()) {
    throw UsageError("--from is for a simulated rig: real drives tell where they stand; add --sim");
  }
}

SessionOptions session_options_of(const SetupArguments& arguments) {
  const std::string positions = arguments.positions ? " --positions " + *arguments.positions : "";
  return {.simulated = arguments.simulated,
          .fast = arguments.fast,
          .allow_jitter = arguments.allow_jitter,
          .standing = positions_of(arguments.from),
          .as_arguments = (arguments.simulated ? " --sim" : "") + positions};
}

void print_positions(const RigFile& rig, const RigReference& reference, const std::vector<std::size_t>& axes,
                     const std::vector<double>& positions) {
  for (const std::size_t a : axes) {
    const RigAxis& axis = rig.axes[a];
    fmt::print("  {:<16}{:>12.4f} {}{}\n", axis.name, positions[a], to_string(axis.unit),
               reference.is_referenced(a) ? "" : "  (unreferenced)");
  }
}

std::optional<double> number_of(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(number)) return std::nullopt;
  return number;
}

std::map<std::string, double> positions_of(const std::vector<std::string>& texts,
                                           const std::string& argument) {
  std::map<std::string, double> positions;
  for (const std::string& text : texts) {
    const std::size_t sign = text.rfind('=');
    const auto position =
        sign == std::string::npos ? std::nullopt : number_of(std::string_view(text).substr(sign + 1));
    if (!position) {
      throw UsageError(fmt::format("{} {}: not a position; write AXIS=POSITION, for example pan=-20",
                                   argument, in_quotes(text)));
    }
    if (!positions.emplace(text.substr(0, sign), *position).second) {
      throw UsageError(fmt::format("{} {}: the axis has a position already", argument, in_quotes(text)));
    }
  }
  return positions;
}

}  // namespace inbetween
