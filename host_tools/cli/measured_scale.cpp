#include "host_tools/cli/measured_scale.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iostream>
#include <optional>
#include <string_view>
#include <variant>

#include "drivers/linux/interrupt_watch.hpp"
#include "drivers/linux/key_terminal.hpp"
#include "host_tools/cli/agreement.hpp"
#include "host_tools/cli/command.hpp"
#include "host_tools/motions/go_to.hpp"
#include "host_tools/reference/axis_positions.hpp"
#include "host_tools/rig/rig_watch.hpp"

namespace inbetween {
namespace {

struct Scale {
  std::string_view field;
  double value;
};
Scale scale_in_file(const Drive& drive) {
  return std::visit(
      [](const auto& its) -> Scale {
        if constexpr (requires { its.turns_per_unit; })
          return {"turns_per_unit", its.turns_per_unit};
        else if constexpr (requires { its.steps_per_unit; })
          return {"steps_per_unit", its.steps_per_unit};
        else
          return {"counts_per_unit", its.counts_per_unit};
      },
      drive);
}

void refuse_calibrated(const RigAxis& axis) {
  if (!axis.calibration) return;
  throw InputError(
      axis.place,
      fmt::format("{}: its calibration says how far it moves; correct the marks in it", named(axis)));
}

double read_answer(const RigAxis& axis) {
  std::string line;
  if (!std::getline(std::cin, line)) {
    throw InputError(axis.place,
                     "nobody said what was measured; the axis has moved, and its file is unchanged");
  }
  const std::optional<double> measured = number_of(line);
  if (!measured || *measured == 0) {
    throw InputError(axis.place,
                     fmt::format("{} is no length; measure again and write a number such as 12.5, "
                                 "negative if it went the other way",
                                 in_quotes(line)));
  }
  return *measured;
}

}  // namespace

std::string scale_in_words(const RigAxis& axis, double distance, double measured) {
  // Closer nobody measures with a rule.
  constexpr double close = 0.005;
  const double factor = measured / distance;
  if (std::fabs(factor - 1) <= close) {
    return fmt::format("{}: its scale is right within what was measured ({:.4g} of {:.4g} {})", named(axis),
                       measured, distance, to_string(axis.unit));
  }
  const Scale scale = scale_in_file(axis.drive);
  return fmt::format(
      "{} moves {:.4g} times as far as it is told; write {} = {:.8g} in its drive, instead of {:.8g}, "
      "and measure again",
      named(axis), factor, scale.field, scale.value / factor, scale.value);
}

int measure_scale(const SetupArguments& setup, const MeasureArguments& arguments) {
  const RigWatch watch(setup.rig);
  const RigFile rig = read_rig(setup.rig);
  const std::size_t axis = axis_named(rig, arguments.axis);
  refuse_calibrated(rig.axes[axis]);
  RigReference reference = reference_of(rig, setup.positions, setup.simulated);
  const InterruptWatch interrupts;
  SetupEnd end;
  {
    std::optional<KeyTerminal> terminal;
    if (KeyTerminal::is_there()) terminal.emplace();
    GoOptions options{.share = arguments.share, .session = session_options_of(setup)};
    if (terminal) options.session.audience.keys = [&] { return terminal->read(); };
    options.session.audience.interrupted = &InterruptWatch::asked;
    options.session.audience.rig_has_changed = [&] { return watch.has_changed(); };
    options.session.audience.confirm = [&](const std::string& question) {
      const std::string all = question + "\nmark where it stands now, to measure how far it goes";
      if (!arguments.yes) return agrees(*terminal, all);
      fmt::print(stderr, "{}\n", all);
      return true;
    };
    end = go_by(rig, axis, arguments.distance, reference, options);
  }
  release_lost_terminal();
  fmt::print("{}: {}\n", rig.name, end.is_done ? "the axis has moved" : end.reason);
  if (!end.positions.empty()) print_positions(rig, reference, {axis}, end.positions);
  if (!end.is_done) return exit_fault;
  fmt::print(stderr, "How far has it gone, in {}? ", to_string(rig.axes[axis].unit));
  fmt::print("{}\n", scale_in_words(rig.axes[axis], arguments.distance, read_answer(rig.axes[axis])));
  return 0;
}

}  // namespace inbetween
