#include "host_tools/cli/scene_export.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "host_tools/cli/command.hpp"
#include "host_tools/cli/progress_bar.hpp"
#include "host_tools/cli/take_arguments.hpp"
#include "host_tools/cli/take_table.hpp"
#include "host_tools/scene/axis_rows.hpp"
#include "host_tools/scene/gltf_writer.hpp"
#include "host_tools/scene/line_test.hpp"
#include "host_tools/scene/rig_scene.hpp"
#include "host_tools/scene/usda_writer.hpp"
#include "host_tools/takes/taken_rig.hpp"
#include "host_tools/text/output_file.hpp"

namespace inbetween {
namespace {

/// What moves, and what of it.
struct MovedRig {
  RigFile rig;
  std::shared_ptr<const Kinematics> kinematics;
  AxisRows rows;
};

MovedRig rig_of_plan(const SceneExport& arguments, const ExchangeWords& words) {
  if (!arguments.rig) throw UsageError("--rig is required: whose camera moves");
  if (arguments.exchange.is_measured) throw UsageError("--measured is for a take; add --take N");
  const Plan plan = make_plan(arguments.from, arguments.rig, Solver::closed_form,
                              {.turns = arguments.turns, .frames = frame_range_argument(arguments.frames)});
  return {
      *plan.rig(), plan.kinematics(),
      rows_of_plan(plan, {.fps = words.fps, .phase = words.phase.value_or(ShutterPhase::frame_boundary)})};
}

MovedRig rig_of_take(const SceneExport& arguments, const ExchangeWords& words) {
  if (arguments.rig || arguments.frames || arguments.turns || words.fps || words.phase) {
    throw UsageError(
        "a take has the rig, the frames, the rate and the phase that it was played with; leave out --rig, "
        "--frames, --turns, --fps and --phase");
  }
  TakeStore store(named_takes_file(arguments.from), TakeStore::Access::read);
  const std::int64_t number = *arguments.exchange.take;
  const RecordedPositions positions =
      arguments.exchange.is_measured ? RecordedPositions::actual : RecordedPositions::told;
  const Take take = store.read_head(number);
  TakenRig taken = rig_of(take);
  return {std::move(taken.rig), std::move(taken.kinematics), rows_of_take(store, number, positions)};
}

double metres_per_unit(MoveUnit unit) {
  const auto size = converted(1, unit, AxisUnit::m);
  if (!size) throw UsageError("--unit: the unit of a scene is a length: mm, cm, m, in or ft");
  return *size;
}

UsdaChoices choices_of(const ExchangeWords& words, SceneFormat format) {
  if (!words.axes.empty() || !words.counts.empty())
    throw UsageError("a scene has the links of the rig; leave out --axis and --count");
  UsdaChoices choices{.up = words.up.value_or(UpAxis::z)};
  for (const UnitWord& word : words.units) {
    if (word.column) throw UsageError("a scene has one unit of length; write --unit cm, say");
    choices.metres_per_unit = metres_per_unit(word.unit);
  }
  const bool is_gltf = format != SceneFormat::usda;
  if (is_gltf && (words.up == UpAxis::z || choices.metres_per_unit != 1))
    throw UsageError("glTF has metres and y up; leave out --unit and --up");
  return choices;
}

void print_summary(std::FILE* out, const SceneExport& arguments, SceneFormat format, const RigScene& made,
                   const std::optional<GltfRounding>& rounding) {
  const AnimatedScene& scene = made.scene;
  const double degrees = 180 / std::numbers::pi;
  if (arguments.to != "-") {
    fmt::print(out, "{}: {} rows, {} a second, of {} links and the camera {}, {}\n", arguments.to, scene.rows,
               to_string(scene.fps), scene.nodes.size() - 1,
               in_quotes(scene.nodes[static_cast<std::size_t>(scene.camera.node)].name), to_string(format));
  }
  fmt::print(out,
             "  between two rows, on straight lines and by slerp, the camera is within {:.2g} mm and {:.2g} "
             "degrees of the motion\n",
             scene.between.place_m * 1000, scene.between.turn_rad * degrees);
  if (rounding) {
    fmt::print(out,
               "  float32 moves the camera by {:.1g} mm and {:.1g} degrees, links by {:.1g} mm and {:.1g} "
               "degrees, times by {:.1g} s\n",
               rounding->camera_m * 1000, rounding->camera_rad * degrees, rounding->joint_m * 1000,
               rounding->joint_rad * degrees, rounding->time_s);
  }
  for (const std::string& line : made.told) fmt::print(out, "  {}\n", line);
  if (!scene.camera.lens) {
    fmt::print(
        out, "  the rig has no [lens] at this tip: {}\n",
        rounding ? "the camera has the angle of view of 50 mm before 36 x 24 mm, since glTF has none without"
                 : "focal length, focus and sensor are those of the other program");
  }
  fmt::print(out, "  the path, the keys and the speed curve are in the move only: keep it\n");
}

constexpr std::size_t max_pictures = 100'000;

/// Its pictures are numbered as the frames are, so that a player shows them in their order.
void draw_line_test(const AnimatedScene& scene, const std::string& folder) {
  const LineTest test(scene);
  ProgressBar bar;
  for (std::size_t row = 0; row < scene.rows; ++row) {
    const std::int64_t frame = scene.first_frame + static_cast<std::int64_t>(row);
    const std::string name = fmt::format("frame_{:05}.png", frame);
    test.draw(row, std::filesystem::path(folder) / name);
    bar.show(static_cast<double>(row + 1) / static_cast<double>(scene.rows), name);
  }
}

void make_folder(const std::string& folder, bool may_overwrite) {
  std::error_code error;
  const bool is_used = std::filesystem::exists(folder, error) && !std::filesystem::is_empty(folder, error);
  if (is_used && !may_overwrite)
    throw InputError(
        {folder},
        "is there already, and not empty; add --over to write over its pictures, or name another folder");
  std::filesystem::create_directories(folder, error);
  if (error)
    throw InputError({folder}, fmt::format("cannot be made ({}); name another folder", error.message()));
}

}  // namespace

int export_scene(const SceneExport& arguments, SceneFormat format) {
  ExchangeArguments exchange = arguments.exchange;
  exchange.format.reset();  // it is this one
  const ExchangeWords words = exchange_words_of(exchange);
  const UsdaChoices choices = choices_of(words, format);
  const bool is_take = exchange.take.has_value();
  refuse_outputs_in_one_place(
      {{"MOVE", is_take ? named_takes_file(arguments.from) : arguments.from}, {"--rig", arguments.rig}},
      {{"--to", arguments.to}});
  if (arguments.line_test) make_folder(*arguments.line_test, exchange.may_overwrite);
  refuse_to_overwrite(arguments.to, exchange.may_overwrite);
  check_output(arguments.to);
  const MovedRig moved = is_take ? rig_of_take(arguments, words) : rig_of_plan(arguments, words);
  if (!moved.kinematics) {
    throw InputError(
        {moved.rig.path},
        "the rig has no [kinematics], so that nobody knows where its camera is; name its URDF file "
        "there, or export a .chan file and say with --axis which axis is tx, ty, tz, rx, ry and rz");
  }
  const Tip& tip = camera_tip(moved.rig, *moved.kinematics, arguments.tip);
  const RigScene made = scene_of_rig(moved.rig, *moved.kinematics, tip, moved.rows);
  if (arguments.line_test && made.scene.rows > max_pictures) {
    throw InputError({moved.rows.name},
                     fmt::format("{} pictures are more than {}; take a part of the move with --frames",
                                 made.scene.rows, max_pictures));
  }
  std::string text;
  std::optional<GltfRounding> rounding;
  if (format == SceneFormat::usda) {
    text = write_usda(made.scene, choices);
  } else {
    GltfText written = write_gltf(made.scene, format == SceneFormat::glb ? GltfForm::binary : GltfForm::text);
    text = std::move(written.bytes);
    rounding = written.rounding;
  }
  write_output(arguments.to, [&](std::FILE* out) { std::fwrite(text.data(), 1, text.size(), out); });
  if (arguments.line_test) {
    draw_line_test(made.scene, *arguments.line_test);
    fmt::print("{}: {} of the path, the links and what the camera sees\n", *arguments.line_test,
               counted(static_cast<std::int64_t>(made.scene.rows), "picture"));
  }
  print_summary(summary_stream(arguments.to == "-"), arguments, format, made, rounding);
  return 0;
}

}  // namespace inbetween
