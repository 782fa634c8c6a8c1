// What `plan` shows of the tips of an articulated rig: JSON, CSV, picture. By the program itself.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "tests/support/example_joints.hpp"
#include "tests/support/oracle_kinematics.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"
#include "tests/support/urdf_text.hpp"

namespace inbetween {
namespace tip_output_test {

using Json = nlohmann::json;
using testing::HasSubstr;
using testing::SizeIs;

const std::string move_file = in_checkout("examples/crane/over_the_table.toml");
const std::string rig_file = in_checkout("examples/crane/rig.toml");
constexpr double degree = 0.017453292519943295;

Json plan(const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {"plan", move_file, "--rig", rig_file, "--json", "-"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const ProgramRun run = run_program(arguments);
  EXPECT_EQ(run.status, 0) << run.err;
  return Json::parse(run.out);
}

std::vector<double> column(const Json& axes, const char* what, std::size_t row) {
  std::vector<double> numbers;
  for (const Json& axis : axes) numbers.push_back(axis.at(what).at(row).get<double>());
  return numbers;
}

void expect_near(const Json& found, const double* expected, double error) {
  ASSERT_THAT(found, SizeIs(3));
  for (std::size_t d = 0; d < 3; ++d) EXPECT_NEAR(found[d].get<double>(), expected[d], error);
}

void expect_the_path_of_the_camera(const Json& json) {
  ASSERT_THAT(json.at("tips"), SizeIs(1));
  const Json& tip = json.at("tips")[0];
  EXPECT_EQ(tip.at("name"), "camera");
  EXPECT_EQ(tip.at("unit"), "m");
  const OracleTree oracle(joints_of_crane());
  const std::size_t rows = json.at("axes")[0].at("position").size();
  ASSERT_THAT(tip.at("position"), SizeIs(rows));
  for (std::size_t row = 0; row < rows; row += 7) {
    const auto positions = column(json.at("axes"), "position", row);
    const OraclePose pose = oracle.pose(7, positions);
    const OracleLinkMotion motion = oracle.motion(7, positions, column(json.at("axes"), "velocity", row),
                                                  column(json.at("axes"), "acceleration", row));
    expect_near(tip.at("position").at(row), pose.position.data(), 1e-9);
    expect_near(tip.at("velocity").at(row), motion.velocity.data(), 1e-9);
    expect_near(tip.at("acceleration").at(row), motion.acceleration.data(), 1e-9);
    expect_near(tip.at("x_axis").at(row), pose.columns[0].data(), 1e-9);
    expect_near(tip.at("y_axis").at(row), pose.columns[1].data(), 1e-9);
    expect_near(tip.at("z_axis").at(row), pose.columns[2].data(), 1e-9);
  }
}

TEST(TipOutput, TheJsonHasThePathOfTheCamera) {
  expect_the_path_of_the_camera(plan({}));
}

TEST(TipOutput, AndItsPathPerTick) {
  expect_the_path_of_the_camera(plan({"--per", "tick"}));
}

TEST(TipOutput, TheCsvHasAColumnForEachDirection) {
  const Json json = plan({});
  const ProgramRun run = run_program({"plan", move_file, "--rig", rig_file, "--csv", "-"});
  std::istringstream lines(run.out);
  std::string line;
  std::getline(lines, line);
  EXPECT_THAT(line, testing::EndsWith(",roll (deg),camera x (m),camera y (m),camera z (m)"));
  for (const Json& at : json.at("tips")[0].at("position")) {
    ASSERT_TRUE(std::getline(lines, line));
    EXPECT_THAT(line, testing::EndsWith(fmt::format(",{},{},{}", at[0].get<double>(), at[1].get<double>(),
                                                    at[2].get<double>())));
  }
}

TEST(TipOutput, EveryArticulatedExampleIsPlannedAndKeepsItsLimits) {
  for (const auto& [folder, move, tips] :
       {std::tuple("crane", "over_the_table", 1U), std::tuple("arm", "reach_over", 1U),
        std::tuple("marionette", "walk", 4U), std::tuple("orrery", "one_year", 4U),
        std::tuple("logo", "fly_in", 5U), std::tuple("brow", "raise", 3U)}) {
    const std::string path = in_checkout(fmt::format("examples/{}/{}.toml", folder, move));
    const std::string rig = in_checkout(fmt::format("examples/{}/rig.toml", folder));
    const ProgramRun planned = run_program({"plan", path, "--rig", rig, "--json", "-"});
    EXPECT_THAT(Json::parse(planned.out).at("tips"), SizeIs(tips)) << planned.err;
    const ProgramRun checked = run_program({"check", path, "--rig", rig});
    EXPECT_EQ(checked.status, 0) << checked.out << checked.err;
    const TemporaryFile picture("picture.svg", "");
    EXPECT_EQ(run_program({"plan", path, "--rig", rig, "--plot", picture.path().string()}).status, 0);
    EXPECT_GT(std::filesystem::file_size(picture.path()), 50'000U);
  }
}

/// Of tip `index` on every row, its place.
std::vector<std::array<double, 3>> path_of(const Json& json, std::size_t index) {
  return json.at("tips").at(index).at("position").get<std::vector<std::array<double, 3>>>();
}

TEST(TipOutput, ThePartsOfAHierarchyMoveWithWhatTheyHangOn) {
  const auto planned = [](const std::string& folder, const std::string& move) {
    return Json::parse(run_program({"plan", in_checkout("examples/" + folder + "/" + move), "--rig",
                                    in_checkout("examples/" + folder + "/rig.toml"), "--json", "-"})
                           .out);
  };
  const Json year = planned("orrery", "one_year.toml");
  const auto earth = path_of(year, 1);
  const auto moon = path_of(year, 2);
  double highest = 0;
  for (std::size_t row = 0; row < earth.size(); ++row) {
    EXPECT_NEAR(std::hypot(earth[row][0], earth[row][1], earth[row][2]), 0.6, 1e-12);
    EXPECT_NEAR(std::hypot(moon[row][0] - earth[row][0], moon[row][1] - earth[row][1], moon[row][2]), 0.12,
                1e-12);
    highest = std::max(highest, moon[row][2]);
  }
  EXPECT_NEAR(highest, 0.12 * std::sin(0.4), 1e-3) << "its orbit leans the same way all the year";
  // At the end the letters stand in a line, under a bar that has flown 2.4 m.
  const Json logo = planned("logo", "fly_in.toml");
  for (std::size_t letter = 0; letter < 5; ++letter) {
    const double below = letter % 4 == 0 ? 0.4 : 0.3;
    EXPECT_NEAR(path_of(logo, letter).back()[0], 2.4 + 0.3 * (static_cast<double>(letter) - 2), 1e-9);
    EXPECT_NEAR(path_of(logo, letter).back()[2], 0.8 + 0.7 - below, 1e-9);
  }
}

TEST(TipOutput, ARigWithoutKinematicsHasNoTips) {
  const ProgramRun run = run_program({"plan", in_checkout("examples/reveal.toml"), "--rig",
                                      in_checkout("examples/camera_rig.toml"), "--json", "-"});
  EXPECT_FALSE(Json::parse(run.out).contains("tips"));
}

TEST(TipOutput, ATipWhoseAxisIsInNoTrackIsNamedAndLeftOut) {
  const TemporaryFile move("pan_only.toml",
                           "name = \"m\"\nfps = 24\nframes = 48\n[[track]]\naxes = [\"pan\"]\n"
                           "keys = [ { at = [0] }, { at = [20] } ]\nspeed = [0, 0, 10, 0, 0]\n");
  const ProgramRun run = run_program({"plan", move.path().string(), "--rig", rig_file, "--json", "-"});
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.err,
              HasSubstr("rig.toml:7:8: warning: the path of \"camera\" is not shown: it hangs on axis "
                        "\"track\", which is in no track; give that a track with one key"));
  EXPECT_THAT(Json::parse(run.out).at("tips"), SizeIs(0));
}

TEST(TipOutput, ThePictureShowsTheTip) {
  const TemporaryFile with_tip("with_tip.svg", "");
  const TemporaryFile without_rig("without_rig.svg", "");
  EXPECT_EQ(run_program({"plan", move_file, "--rig", rig_file, "--plot", with_tip.path().string()}).status,
            0);
  EXPECT_EQ(run_program({"plan", move_file, "--plot", without_rig.path().string()}).status, 0);
  EXPECT_GT(std::filesystem::file_size(with_tip.path().string()),
            std::filesystem::file_size(without_rig.path().string()) + 20'000);
}

TEST(TipOutput, AJointThatTheRigDoesNotMoveIsRefusedByEveryCommand) {
  const TemporaryFile urdf("bad.urdf", "<robot><link name=\"a\"/>\n<link/></robot>");
  const TemporaryFile rig("bad_rig.toml",
                          "name = \"r\"\nrate_hz = 100\n[kinematics]\nurdf = \"" + urdf.path().string() +
                              "\"\ntip = \"a\"\n[[axis]]\nname = \"pan\"\nunit = \"deg\"\nmin = -1\nmax = 1\n"
                              "max_velocity = 1\nmax_acceleration = 1\nunpowered = \"holds\"\n"
                              "drive = { type = \"pipe\", path = \"p\", counts_per_unit = 1 }\n");
  for (const char* command : {"plan", "check", "run"}) {
    const ProgramRun run = run_program({command, move_file, "--rig", rig.path().string()});
    EXPECT_EQ(run.status, 1);
    EXPECT_THAT(run.err, HasSubstr("bad.urdf:2: error: <link> has no name"));
  }
}

/// A rig for the arm, each axis in a unit of its own, and a move of all of them.
struct ArmFiles {
  std::string rig, move;
  std::vector<std::string> axes;

  ArmFiles(const UrdfText& urdf, const std::string& urdf_path, std::mt19937_64& random) {
    rig = fmt::format("name = \"arm\"\nrate_hz = 100\n[kinematics]\nurdf = \"{}\"\ntip = \"{}\"\n", urdf_path,
                      urdf.tip);
    std::string names;
    std::vector<double> reach;
    for (const UrdfTextJoint& joint : urdf.joints) {
      if (joint.mimics) continue;
      const bool slides = joint.type == "prismatic";
      const bool in_small = std::uniform_int_distribution<int>(0, 1)(random) == 0;
      const double units = slides ? (in_small ? 1000 : 1) : (in_small ? 1 / degree : 1);
      reach.push_back(units * std::min(-joint.lower, joint.upper));
      rig += fmt::format(
          "[[axis]]\nname = \"{}\"\nunit = \"{}\"\nmin = {}\nmax = {}\nmax_velocity = {}\nmax_acceleration = "
          "{}\ndrive = {{ type = \"pipe\", path = \"p\", counts_per_unit = 1.0 }}\n",
          joint.name, slides ? (in_small ? "mm" : "m") : (in_small ? "deg" : "rad"),
          0.99 * units * joint.lower, 0.99 * units * joint.upper, 5 * units, 50 * units);
      axes.push_back(joint.name);
      names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", joint.name);
    }
    move = fmt::format("name = \"m\"\nfps = 24\nframes = 96\n[[track]]\naxes = [{}]\nkeys = [\n", names);
    for (const double share : {-0.5, 0.5, 0.1}) {
      std::string at;
      for (const double r : reach) at += fmt::format("{}{}", at.empty() ? "" : ", ", share * r);
      move += fmt::format("  {{ at = [{}] }},\n", at);
    }
    move += "]\nspeed = [0, 0, 10, 10, 0, 0]\n";
  }
};

TEST(TipOutput, AnyArmOfSixOrSevenJointsIsPlannedAndCheckedOrRefusedInOneLine) {
  int planned = 0;
  for (const unsigned seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
    std::mt19937_64 random(seed);
    const UrdfText arm = random_urdf(random, 6 + seed % 2);
    const TemporaryFile urdf("arm.urdf", arm.text);
    const ArmFiles files(arm, urdf.path().string(), random);
    const TemporaryFile rig("arm_rig.toml", files.rig);
    const TemporaryFile move("arm_move.toml", files.move);
    for (const char* command : {"plan", "check"}) {
      const ProgramRun run =
          run_program({command, move.path().string(), "--rig", rig.path().string(), "--json", "-"});
      SCOPED_TRACE(fmt::format("seed {}, {}: {}", seed, command, run.err));
      EXPECT_THAT(run.status, testing::AnyOf(0, 1, 3));
      if (run.status == 1) {
        EXPECT_THAT(run.err, HasSubstr("error: "));
        EXPECT_EQ(std::ranges::count(run.err, '\n'), 1);
      } else if (std::string(command) == "plan") {
        ++planned;
        EXPECT_THAT(Json::parse(run.out).at("tips").at(0).at("position"), SizeIs(97));
      }
    }
  }
  EXPECT_EQ(planned, 6) << "the limits of these rigs are within those of the joints";
}

/// Keys in the world, on the way that the tip takes in the planned move of the joints; looking as it does
/// there or anyhow.
std::string move_in_space(const Json& planned, const UrdfText& arm, const std::vector<std::string>& axes,
                          bool looks) {
  std::string names;
  for (const std::string& axis : axes) names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", axis);
  std::string near;
  for (const Json& axis : planned.at("axes")) {
    const auto name = axis.at("name").get<std::string>();
    if (std::ranges::find(axes, name) == axes.end()) continue;
    near += fmt::format("{}{} = {}", near.empty() ? "" : ", ", name, axis.at("position")[28].get<double>());
  }
  std::string keys;
  const Json& tip = planned.at("tips")[0];
  for (const std::size_t row : {28U, 32U, 36U}) {
    keys += fmt::format("  {{ at = {}", tip.at("position")[row].dump());
    if (looks) {
      std::array<double, 3> aim{};
      for (std::size_t d = 0; d < 3; ++d) {
        aim.at(d) = tip.at("position")[row][d].get<double>() + 2 * tip.at("x_axis")[row][d].get<double>();
      }
      const double roll =
          std::atan2(tip.at("y_axis")[row][2].get<double>(), tip.at("z_axis")[row][2].get<double>());
      keys += fmt::format(", aim = [{}, {}, {}], roll = {}", aim[0], aim[1], aim[2], roll / degree);
    }
    keys += " },\n";
  }
  return fmt::format(
      "name = \"m\"\nfps = 24\nframes = 96\n[[track]]\naxes = [{}]\nspace = \"{}\"\nnear = {{ {} }}\nkeys = "
      "[\n{}]\n"
      "speed = [0, 0, 10, 10, 0, 0]\n",
      names, arm.tip, near, keys);
}

/// Plans the keys in space with no more axes than move the tip: the refusal names one that does not.
ProgramRun run_in_space(const char* command, const Json& planned, const UrdfText& arm, const ArmFiles& files,
                        const std::string& rig, bool looks) {
  std::vector<std::string> axes = files.axes;
  for (;;) {
    const TemporaryFile move("arm_move.toml", move_in_space(planned, arm, axes, looks));
    ProgramRun run = run_program({command, move.path().string(), "--rig", rig, "--json", "-"});
    const std::size_t at = run.err.find(" does not move ");
    if (at == std::string::npos || axes.empty()) return run;
    std::erase_if(
        axes, [&](const std::string& axis) { return run.err.substr(0, at).ends_with("\"" + axis + "\""); });
  }
}

TEST(TipOutput, AnyArmFollowsKeysInTheWorldOrIsRefusedInOneLine) {
  int followed = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    std::mt19937_64 random(seed);
    const UrdfText arm = random_urdf(random, 6 + seed % 2);
    const TemporaryFile urdf("arm.urdf", arm.text);
    const ArmFiles files(arm, urdf.path().string(), random);
    const TemporaryFile rig("arm_rig.toml", files.rig);
    const TemporaryFile move("arm_move.toml", files.move);
    const Json planned = Json::parse(
        run_program({"plan", move.path().string(), "--rig", rig.path().string(), "--json", "-"}).out);
    for (const char* command : {"plan", "check"}) {
      const ProgramRun run = run_in_space(command, planned, arm, files, rig.path().string(), seed % 4 < 2);
      SCOPED_TRACE(fmt::format("seed {}, {}: {}", seed, command, run.err));
      EXPECT_THAT(run.status, testing::AnyOf(0, 1, 3));
      if (run.status == 1) {
        EXPECT_THAT(run.err, HasSubstr("error: "));
        EXPECT_EQ(std::ranges::count(run.err, '\n'), 1);
      } else if (std::string(command) == "plan") {
        ++followed;
        const Json found = Json::parse(run.out);
        const Json& path = found.at("tips").at(0).at("position");
        for (std::size_t d = 0; d < 3; ++d) {
          EXPECT_NEAR(path.front()[d].get<double>(),
                      planned.at("tips")[0].at("position")[28][d].get<double>(), 1e-6);
          EXPECT_NEAR(path.back()[d].get<double>(), planned.at("tips")[0].at("position")[36][d].get<double>(),
                      1e-6);
        }
      }
    }
  }
  EXPECT_GE(followed, 5) << "others end at a range or out of reach";
}

}  // namespace tip_output_test
}  // namespace inbetween
