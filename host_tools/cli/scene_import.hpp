// `inbetween import` where the file is a scene: one of its nodes moves a tip of the rig.
#pragma once

#include <optional>
#include <string>

#include "host_tools/cli/exchange_arguments.hpp"
#include "host_tools/exchange/baked_table.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/scene/scene_format.hpp"
#include "host_tools/scene/scene_poses.hpp"

namespace inbetween {

struct SceneArguments {
  std::optional<std::string> node, tip, place;
  std::optional<double> scale, turn_deg;
  [[nodiscard]] bool is_said() const { return node || tip || place || scale || turn_deg; }
};
/// Adds --node, --tip, --place, --scale and --turn.
void add_scene_options(CLI::App& app, SceneArguments& arguments);

/// A scene, and what of it a rig plays.
struct SceneMotion {
  SceneFile scene;
  std::size_t node = 0;
  ScenePlacement placement = {};
  SceneRows rows = {};
  BakedTable table = {};                // of the axes of the rig, or of tx ty tz pan tilt roll
  std::optional<std::string> tip = {};  // that is solved for; nothing where columns are named with --axis
};
/// Throws InputError and UsageError.
SceneMotion read_scene_motion(const std::string& file, SceneFormat format, const SceneArguments& arguments,
                              const ExchangeWords& words, const RigFile& rig);

/// Solves the move that was written and prints how far the tip is from the scene, on the rows and between.
void print_scene_miss(const SceneMotion& motion, const std::string& move, const std::string& rig);

}  // namespace inbetween
