#include "host_tools/cli/shoot_arguments.hpp"

#include <fmt/format.h>

#include <string_view>

#include "host_tools/cli/command.hpp"
#include "host_tools/cli/setup_arguments.hpp"

namespace inbetween {
namespace {

/// Reads a shutter such as "0..180", in degrees of a frame.
Shutter shutter_of(const std::string& text) {
  const std::size_t dots = text.find("..");
  const auto open = number_of(std::string_view(text).substr(0, dots));
  const auto close =
      dots == std::string::npos ? std::nullopt : number_of(std::string_view(text).substr(dots + 2));
  if (!open || !close || !(*open >= -360 && *open < *close && *close <= 360 && *close - *open <= 360)) {
    throw UsageError(
        fmt::format("--shutter {}: not two angles; write OPEN..CLOSE in degrees of a frame, for "
                    "example 0..180, within -360..360 and at most 360 apart",
                    in_quotes(text)));
  }
  return {*open / 360, *close / 360};
}

void refuse_shoot_arguments(const ShootArguments& arguments) {
  if (arguments.settle || arguments.exposure || !arguments.still.empty()) {
    throw UsageError("--settle, --exposure and --still belong to --step or --shutter");
  }
  if (arguments.shoot_log) throw UsageError("--shoot-log belongs to --step or --shutter");
  if (arguments.resume) throw UsageError("--resume belongs to --step or --shutter");
}

}  // namespace

std::optional<ShootOptions> shoot_options(const ShootArguments& arguments) {
  if (!arguments.is_shot()) {
    refuse_shoot_arguments(arguments);
    return std::nullopt;
  }
  if (arguments.resume && (!arguments.shoot_log || *arguments.shoot_log == "-")) {
    throw UsageError("--resume goes on with a shoot by its log; name it with --shoot-log FILE");
  }
  ShootOptions options;
  options.frames = frame_range_argument(arguments.frames);
  options.log = arguments.shoot_log;
  if (arguments.settle) options.settle_s = *arguments.settle;
  if (arguments.exposure) options.exposure_s = *arguments.exposure;
  if (!arguments.shutter) {
    if (arguments.still.empty()) return options;
    throw UsageError("without --shutter every axis stands still; leave out --still");
  }
  if (!arguments.exposure) throw UsageError("--shutter needs --exposure SECONDS: how long it is open");
  options.shutter = shutter_of(*arguments.shutter);
  options.still = arguments.still;
  return options;
}

void add_shoot_options(CLI::App& command, ShootArguments& arguments) {
  command.add_flag("--step", arguments.step,
                   "stop motion: on every frame go there, settle, signal the camera and wait");
  command.add_option("--shutter", arguments.shutter,
                     "go-motion: OPEN..CLOSE in degrees of a frame; the rig moves while the shutter is open");
  command.add_option("--exposure", arguments.exposure, "seconds of the camera's signal (0.1 with --step)")
      ->check(between(0.001, 3600.0));
  command.add_option("--settle", arguments.settle, "seconds at rest before the camera's signal (0.5)")
      ->check(between(0.0, 600.0));
  command.add_option("--still", arguments.still, "an axis that stands still while the shutter is open")
      ->expected(1)
      ->take_all();
  command.add_option("--shoot-log", arguments.shoot_log,
                     "add a line for each exposure to this file (CSV; - is standard output)");
  command.add_flag(
      "--resume", arguments.resume,
      "go on with the shoot whose log --shoot-log names, on the first frame that it does not have");
  for (const char* name :
       {"--step", "--shutter", "--exposure", "--settle", "--still", "--shoot-log", "--resume"}) {
    command.get_option(name)->group("Stop motion and go-motion");
  }
}

}  // namespace inbetween
