#include "host_tools/cli/scene_import.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>
#include <vector>

#include "host_tools/cli/command.hpp"
#include "host_tools/joints/kinematics.hpp"
#include "host_tools/scene/gltf_reader.hpp"
#include "host_tools/scene/rig_poses.hpp"
#include "host_tools/scene/rig_scene.hpp"
#include "host_tools/scene/scene_bounds.hpp"
#include "host_tools/scene/usda_reader.hpp"
#include "host_tools/text/text_file.hpp"

namespace inbetween {
namespace {

/// "1.2,0,-0.5", in metres.
Vector3 place_of_words(const std::string& words) {
  std::array<double, 3> numbers{};
  std::string_view rest = words;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::size_t comma = rest.find(',');
    const bool is_last = i + 1 == numbers.size();
    const std::string word(rest.substr(0, comma));
    const bool is_right = (comma == std::string_view::npos) == is_last &&
                          CLI::detail::lexical_cast(word, numbers.at(i)) && std::fabs(numbers.at(i)) <= 1e6;
    if (!is_right)
      throw UsageError(
          fmt::format("--place {}: write three numbers in metres, such as 1.2,0,0.5", in_quotes(words)));
    rest.remove_prefix(is_last ? rest.size() : comma + 1);
  }
  return {numbers[0], numbers[1], numbers[2]};
}

SceneFile read_scene(const std::string& file, SceneFormat format) {
  if (format == SceneFormat::usda) return read_usda(read_text_file(file, max_usda_bytes), file);
  return read_gltf(read_text_file(file, max_gltf_bytes), file);
}

void refuse_options_of_tables(const ExchangeWords& words) {
  if (!words.counts.empty() || words.up || words.phase) {
    throw UsageError(
        "a scene says what is up, and a row of it is a moment; leave out --up, --phase and --count");
  }
}

}  // namespace

void add_scene_options(CLI::App& app, SceneArguments& arguments) {
  app.add_option("--node", arguments.node, "of a scene: the camera or object that is taken, by name or path")
      ->type_name("NAME");
  app.add_option("--tip", arguments.tip, "of the rig: the tip that goes where the node of the scene goes")
      ->type_name("TIP");
  app.add_option("--scale", arguments.scale, "of a scene: how large it stands on the stage, about its origin")
      ->check(between(1e-6, 1e6))
      ->type_name("FACTOR");
  app.add_option("--place", arguments.place,
                 "of a scene: where its origin stands on the stage, in metres, z up")
      ->type_name("X,Y,Z");
  app.add_option("--turn", arguments.turn_deg,
                 "of a scene: degrees by which it is turned about up, counterclockwise from above")
      ->check(between(-360.0, 360.0))
      ->type_name("DEG");
}

SceneMotion read_scene_motion(const std::string& file, SceneFormat format, const SceneArguments& arguments,
                              const ExchangeWords& words, const RigFile& rig) {
  refuse_options_of_tables(words);
  const bool is_by_columns = !words.axes.empty();
  if (is_by_columns && arguments.tip) throw UsageError("--tip solves for all axes; leave it or --axis out");
  SceneMotion motion{.scene = read_scene(file, format)};
  motion.placement = {.scale = arguments.scale.value_or(1), .turn_deg = arguments.turn_deg.value_or(0)};
  if (arguments.place) motion.placement.place = place_of_words(*arguments.place);
  motion.node = chosen_node(motion.scene, arguments.node);
  motion.rows = rows_of_node(motion.scene, motion.node, motion.placement, words.fps);
  if (is_by_columns) {
    motion.table = table_of_poses(motion.scene, motion.rows);
    return motion;
  }
  if (!rig.kinematics) {
    throw InputError(
        {rig.path},
        "the rig has no [kinematics], so that nobody knows which axes move its camera; say it with "
        "--axis tx=AXIS, and of ty, tz, pan, tilt and roll, or name its URDF file there");
  }
  const Kinematics kinematics = read_kinematics(rig);
  const Tip& tip = camera_tip(rig, kinematics, arguments.tip);
  motion.tip = tip.name;
  motion.table = axes_of_poses(rig, kinematics, tip, motion.scene, motion.rows);
  return motion;
}

void print_scene_miss(const SceneMotion& motion, const std::string& move, const std::string& rig) {
  const Plan plan = make_plan(move, rig, Solver::closed_form);
  const Kinematics& kinematics = *plan.kinematics();
  const Tip& tip = camera_tip(*plan.rig(), kinematics, motion.tip);
  const StagedNode staged(motion.scene, motion.node, motion.placement);
  std::vector<double> of_move(plan.motion().axis_count());
  std::vector<double> coordinates(kinematics.tree().coordinate_count(), 0);
  std::vector<Pose> poses(kinematics.tree().joints().size());
  PoseMiss on_rows, between;
  constexpr int places = 8;  // of each stretch between two rows, the first on a row
  const auto steps = static_cast<std::int64_t>(motion.rows.poses.size() - 1) * places;
  for (std::int64_t step = 0; step <= steps; ++step) {
    const double share = static_cast<double>(step % places) / places;
    plan.motion().positions({static_cast<std::int32_t>(step / places), share}, of_move);
    for (const PlanAxis& axis : plan.axes()) {
      if (!axis.track) continue;
      const auto in_rig = std::ranges::find(plan.rig()->axes, axis.name, &RigAxis::name);
      coordinates[static_cast<std::size_t>(in_rig - plan.rig()->axes.begin())] = of_move[axis.move_axis];
    }
    if (!kinematics.tree().poses(coordinates, poses)) continue;
    const Pose wanted = staged.at(motion.rows.code(static_cast<double>(step) / places));
    const PoseMiss miss = miss_of(poses[static_cast<std::size_t>(tip.link)], wanted);
    PoseMiss& worst = step % places == 0 ? on_rows : between;
    worst.place_m = std::max(worst.place_m, miss.place_m);
    worst.turn_rad = std::max(worst.turn_rad, miss.turn_rad);
  }
  constexpr double degrees = 180 / std::numbers::pi;
  fmt::print(
      "  {} goes where {} goes: on the rows within {:.1g} mm and {:.1g} degrees, at {} places between each "
      "two rows within {:.2g} mm and {:.2g} degrees\n",
      tip.name, in_quotes(motion.scene.nodes[motion.node].name), on_rows.place_m * 1000,
      on_rows.turn_rad * degrees, places - 1, between.place_m * 1000, between.turn_rad * degrees);
}

}  // namespace inbetween
