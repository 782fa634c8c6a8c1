// The files in examples/: read, solved, and fit for the rigs that they were made for.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/motions/run.hpp"
#include "host_tools/plan/plan.hpp"
#include "tests/support/golden_table.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"

namespace inbetween {
namespace examples_test {

namespace fs = std::filesystem;

const fs::path examples = in_checkout("examples");

struct ForARig {
  std::string move, rig;
};
const std::vector<ForARig> for_rigs = {{"reveal", "camera_rig"},         {"reveal", "odrive_rig"},
                                       {"reveal", "moteus_rig"},         {"reveal", "motor_rig"},
                                       {"nod", "puppet_head"},           {"nod_once", "puppet_head"},
                                       {"blink", "puppet_head"},         {"look_around", "puppet_head"},
                                       {"jaw", "puppet_head"},           {"slide_and_pan", "slider_rig"},
                                       {"track_and_focus", "mixed_rig"}, {"turntable", "turntable_rig"},
                                       {"rack_focus", "gantry_rig"},     {"fish", "fish_rig"},
                                       {"mouth", "mouth_rig"},           {"storyboard", "camera_rig"}};

fs::path file(const std::string& name) {
  return examples / (name + ".toml");
}

bool is_rig(const fs::path& path) {
  return std::any_of(for_rigs.begin(), for_rigs.end(),
                     [&](const ForARig& example) { return path == file(example.rig); });
}

std::vector<std::string> names(bool of_rigs) {
  std::vector<std::string> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(examples)) {
    if (entry.path().extension() == ".toml" && is_rig(entry.path()) == of_rigs) {
      found.push_back(entry.path().stem().string());
    }
  }
  return found;
}

Plan plan_for_rig(const ForARig& example) {
  return {read_move_file(file(example.move)), read_rig_file(file(example.rig)), {}};
}

bool has_drawn_speed(const std::string& name) {
  const MoveFile move = read_move_file(file(name));
  return std::ranges::all_of(move.tracks, [](const MoveTrack& track) {
    return track.timing == Timing::speed && !track.ease_corners && !track.periodic &&
           std::ranges::none_of(track.keys,
                                [](const MoveKey& key) { return key.frame || key.hold || key.ease; });
  });
}

TEST(Examples, EveryMoveIsSolvedByBothSolversAndKeepsTheInvariants) {
  const std::vector<std::string> moves = names(false);
  EXPECT_GE(moves.size(), 5U);
  for (const std::string& name : moves) {
    for (const Solver solver : {Solver::closed_form, Solver::runge_kutta}) {
      // The paper's solver integrates a drawn speed, one K for the whole move.
      if (solver == Solver::runge_kutta && !has_drawn_speed(name)) continue;
      const Plan plan(read_move_file(file(name)), std::nullopt, {.solver = solver});
      for (const SolvedTrack& solved : plan.tracks()) {
        EXPECT_TRUE(check_invariants(solved.track(), solved.table())) << name;
      }
    }
  }
}

TEST(Examples, EveryRigIsRead) {
  const std::vector<std::string> rigs = names(true);
  std::set<std::string> used;
  for (const ForARig& example : for_rigs) used.insert(example.rig);
  EXPECT_EQ(rigs.size(), used.size());
  for (const std::string& name : rigs) EXPECT_FALSE(read_rig_file(file(name)).axes.empty()) << name;
}

TEST(Examples, EveryMoveWithADrawnSpeedHasAGoldenTable) {
  std::vector<std::string> drawn = names(false);
  std::erase_if(drawn, [](const std::string& name) { return !has_drawn_speed(name); });
  EXPECT_THAT(drawn, testing::UnorderedElementsAreArray(golden_examples()));
}

TEST(Examples, ANodABlinkAJawAndATurntableTakeAtMostTenLinesAndFitTheirRig) {
  for (const ForARig& example : for_rigs) {
    if (has_drawn_speed(example.move)) continue;
    const std::string text = file_contents(file(example.move).string());
    const std::ptrdiff_t max_lines = example.move == "storyboard" ? 20 : 10;
    EXPECT_LE(std::ranges::count(text, '\n'), max_lines) << example.move;
    const CheckReport report = check(plan_for_rig(example));
    EXPECT_TRUE(report.fits()) << example.move << ": " << report.refusals.front().message();
    for (const CheckedStep& step : report.steps) EXPECT_EQ(step.velocity, 0) << example.move;
  }
}

TEST(Examples, MovesForRigsAreSmoothOrTheirActionsOverlap) {
  for (const ForARig& example : for_rigs) {
    for (const MoveTrack& track : read_move_file(file(example.move)).tracks) {
      EXPECT_TRUE(track.spline == Spline::smooth || has_overlap(track)) << example.move;
    }
  }
}

TEST(Examples, ARigOnStepperDriversHasAllThatItNeedsToBeFoundAndStopped) {
  const RigFile slider = read_rig_file(file("slider_rig"));
  ASSERT_EQ(slider.axes.size(), 2U);
  for (const RigAxis& axis : slider.axes) {
    EXPECT_TRUE(std::holds_alternative<StepDirDrive>(axis.drive) && axis.home) << axis.name;
  }
  EXPECT_TRUE(slider.emergency_stop && slider.camera);
  const RigFile mixed = read_rig_file(file("mixed_rig"));
  ASSERT_EQ(mixed.axes.size(), 2U);
  EXPECT_TRUE(std::holds_alternative<Cia402Drive>(mixed.axes[0].drive));
  EXPECT_TRUE(std::holds_alternative<StepDirDrive>(mixed.axes[1].drive));
}

TEST(Examples, MovesForRigsStartAndEndAtRestUnlessTheyGoRound) {
  for (const ForARig& example : for_rigs) {
    const Plan plan = plan_for_rig(example);
    if (plan.move().tracks.front().periodic) continue;
    for (const SolvedTrack& solved : plan.tracks()) {
      const auto axes = static_cast<std::size_t>(solved.track().path().axis_count());
      std::vector<AxisMotion> motion(axes);
      for (const std::int32_t frame : {0, plan.move().frames}) {
        solved.track().motion({frame, 0}, motion);
        for (const AxisMotion& axis : motion) {
          EXPECT_EQ(axis.velocity, 0) << example.move << ", frame " << frame;
          EXPECT_EQ(axis.acceleration, 0) << example.move << ", frame " << frame;
        }
      }
    }
  }
}

TEST(Examples, MovesForRigsMeasureDistanceInOneUnitOrSayWhatCounts) {
  for (const ForARig& example : for_rigs) {
    EXPECT_THAT(plan_for_rig(example).warnings(), testing::IsEmpty()) << example.move;
  }
}

TEST(Examples, MovesForRigsStayInsideTheLimitsOfEveryAxis) {
  for (const ForARig& example : for_rigs) {
    const Plan plan = plan_for_rig(example);
    const RunReport report = run(plan, {.simulated = true, .fast = true});  // throws beyond a position
    EXPECT_EQ(report.ending, Ending::finished) << example.move;
    for (const PlanAxis& axis : plan.axes()) {
      if (!axis.track) continue;
      const Track& track = plan.tracks()[*axis.track].track();
      std::vector<AxisMotion> motion(plan.move().tracks[*axis.track].axes.size());
      const RigAxis& limits = plan.rig()->axes[static_cast<std::size_t>(&axis - plan.axes().data())];
      for (std::int32_t frame = 0; frame < plan.move().frames; ++frame) {
        for (const double fraction : {0.0, 0.25, 0.5, 0.75}) {
          track.motion({frame, fraction}, motion);
          EXPECT_LE(std::abs(motion[axis.track_axis].velocity), limits.max_velocity) << axis.name << frame;
          EXPECT_LE(std::abs(motion[axis.track_axis].acceleration), limits.max_acceleration)
              << axis.name << frame;
          if (limits.max_jerk) {
            EXPECT_LE(std::abs(motion[axis.track_axis].jerk), *limits.max_jerk) << axis.name << frame;
          }
        }
      }
    }
  }
}

}  // namespace examples_test
}  // namespace inbetween
