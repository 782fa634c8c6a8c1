// `inbetween export` where the file is a scene: the rig and its camera, as glTF or USD.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "host_tools/cli/exchange_arguments.hpp"
#include "host_tools/scene/scene_format.hpp"

namespace inbetween {

struct SceneExport {
  std::string from, to;  // a move, or with ExchangeArguments::take a file of takes; "-" is standard output
  std::optional<std::string> rig, frames;
  std::optional<std::string> tip;  // the one that carries the camera
  std::optional<std::int32_t> turns;
  std::optional<std::string> line_test;  // a folder for a picture of each row, beside `to`
  ExchangeArguments exchange;
};

/// Writes it, prints a summary with what is off and what the format does not hold, and returns the exit
/// status. Throws InputError and UsageError.
int export_scene(const SceneExport& arguments, SceneFormat format);

}  // namespace inbetween
