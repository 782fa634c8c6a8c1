// Networks whose row is of points in space: an eyebrow of three points, each on a lever of two joints.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/plan/plan.hpp"
#include "tests/support/oracle_network.hpp"
#include "tests/support/places.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/run_program.hpp"

namespace inbetween {
namespace row_of_points_test {

constexpr std::array<double, 3> roots_m = {0.010, 0.030, 0.048};
constexpr double radian = std::numbers::pi / 180;

const std::filesystem::path rig_path = in_checkout("examples/brow/rig.toml");
const std::string raise = file_contents(in_checkout("examples/brow/raise.toml"));

Plan planned(const std::string& text, const std::string& name = "file.toml") {
  const RigFile rig = read_rig_file(rig_path);
  return {
      parse_move(text, name), rig, {.kinematics = std::make_shared<const Kinematics>(read_kinematics(rig))}};
}

/// Where a point is (m), by the angles of its lever.
struct InPlane {
  double x = 0;
  double z = 0;
};
InPlane place_of(double root, const AxisMotion& swing, const AxisMotion& bend) {
  const double first = swing.position * radian;
  const double second = first + bend.position * radian;
  return {root + 0.03 * std::cos(first) + 0.025 * std::cos(second),
          0.03 * std::sin(first) + 0.025 * std::sin(second)};
}

/// x or z of the row of the example, by Coons' formula.
oracle::NetworkOracle row_by_formula(const Plan& plan, std::size_t coordinate) {
  const MoveTrack& track = plan.move().tracks.front();
  std::vector<oracle::NetworkAxis> row;
  for (std::size_t point = 0; point < roots_m.size(); ++point) {
    oracle::NetworkAxis& axis = row.emplace_back();
    axis.place = track.network->places.at(point);
    for (const MoveKey& key : track.keys) {
      axis.keys.at.push_back(key.at.at(3 * point + coordinate));
      axis.keys.frames.push_back(*key.frame);
    }
    for (const DrawnAxis& drawn : track.network->drawn) {
      if (drawn.axis != 3 * point + coordinate) continue;
      axis.drawn.emplace();
      axis.drawn->at.assign(drawn.at.begin(), drawn.at.end());
      axis.drawn->frames.assign(drawn.frames.begin(), drawn.frames.end());
    }
  }
  return oracle::NetworkOracle(std::move(row));
}

TEST(RowOfPoints, TheTipOfEveryLeverIsWhereTheCoonsPatchHasItsPoint) {
  const Plan plan = planned(raise);
  const oracle::NetworkOracle x = row_by_formula(plan, 0);
  const oracle::NetworkOracle z = row_by_formula(plan, 2);
  std::vector<AxisMotion> axes(plan.axes().size());
  double off = 0;
  for (int part = 0; part <= 23 * 48; ++part) {  // none of them where the joints are solved
    plan.tracks().front().track().motion({part / 23, part % 23 / 23.0}, axes);
    for (std::size_t point = 0; point < roots_m.size(); ++point) {
      const InPlane at = place_of(roots_m.at(point), axes[2 * point], axes[2 * point + 1]);
      const long double frame = part / 23.0L;
      off = std::max(off, std::hypot(at.x - static_cast<double>(x.at(point, frame, 0)),
                                     at.z - static_cast<double>(z.at(point, frame, 0))));
    }
  }
  fmt::print("the points are within {:.3g} m\n", off);
  // 1e-7 of the shortest path of a point, and the rounding of a motor's angle.
  EXPECT_LE(off, 1e-7 * 0.02);
  ASSERT_TRUE(plan.accuracy(0).has_value());
  EXPECT_LE(off, plan.accuracy(0)->off_m + 1e-15) << "the bound that is printed is none";
}

TEST(RowOfPoints, ItRestsAtBothEndsAndNothingSteps) {
  const Plan plan = planned(raise);
  std::vector<AxisMotion> axes(plan.axes().size());
  for (const std::int32_t frame : {0, 48}) {
    const std::uint8_t steps = plan.tracks().front().track().motion({frame, 0}, axes);
    static_cast<void>(steps);
    for (const AxisMotion& axis : axes) {
      EXPECT_EQ(axis.velocity, 0) << frame;
      EXPECT_EQ(axis.acceleration, 0) << frame;
    }
  }
}

TEST(RowOfPoints, APointThatAKeyLeavesOutIsOnItsCurveAndOneThatIsNotDrawnStaysWhereItWas) {
  const Plan plan = planned(with(raise, "inner = [11, 0, 47], middle = [30, 0, 51]", "middle = [30, 0, 51]"));
  const MoveKey& key = plan.move().tracks.front().keys.at(1);
  EXPECT_THAT(key.at, testing::ElementsAre(0.010, 0, 0.040, 0.030, 0, 0.051, 0.049, 0, 0.044));
}

TEST(RowOfPoints, AKeyMayNameADrawnPointOnItsCurveAndNotBesideIt) {
  planned(with(raise, "middle = [30, 0, 51]", "middle = [30, 0, 51], outer = [49, 0, 44]"));
  expect_refused([](const std::string& text, const std::string& name) { planned(text, name); },
                 with(raise, "middle = [30, 0, 51]", "middle = [30, 0, 51], outer = [49, 0, @44.5]"),
                 {"frame 14", "key 1", "\"outer.z\"", "0.0445", "0.044", "0.0005 away"});
}

TEST(RowOfPoints, AFileDrawsAPointByThreeColumnsInTheirUnits) {
  const std::filesystem::path folder = testing::TempDir();
  std::ofstream(folder / "hand.csv") << "frame,outer.x (mm),outer.y,outer.z (m)\n0,48,0,0.038\n8,48,0,0.042\n"
                                        "14,49,0,0.044\n20,49,0,0.041\n26,48,0,0.043\n34,47,0,0.038\n"
                                        "48,47,0,0.039\n";
  const std::size_t begin = raise.find("[track.drawn]");
  const std::string text = raise.substr(0, begin) + "[track.drawn]\nouter = \"hand.csv\"\n";
  const Plan from_file = planned(text, folder / "file.toml");
  const Plan from_points = planned(raise);
  const MoveTrack& read = from_file.move().tracks.front();
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_EQ(read.network->drawn.at(c).frames,
              from_points.move().tracks.front().network->drawn.at(c).frames);
    EXPECT_EQ(read.network->drawn.at(c).at, from_points.move().tracks.front().network->drawn.at(c).at);
  }
  std::ofstream(folder / "hand.csv") << "frame,outer.x,outer.y,outer.z\n0,48,0,38\n8,48,,38\n48,48,0,38\n";
  try {
    planned(text, folder / "file.toml");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("frame 8 has one of outer.x and outer.y alone"));
  }
}

TEST(RowOfPoints, WhatIsNoRowOfPointsIsRefusedAtItsPlace) {
  const std::vector<std::array<std::string, 3>> cases = {
      {"space   = [\"inner\", \"middle\", \"outer\"]", "space   = @\"inner\"", "a network has a row of them"},
      {"\"middle\", \"outer\"]\nelbow", "@\"inner\", \"outer\"]\nelbow", "name each point of the row once"},
      {"network = true", "@network = false", ""},
      {"elbow   = \"down\"", "elbow = \"down\"\naim = @[0, 0, 0]", "the points of a row look nowhere"},
      {"inner = [10, 0, 40], ", "", "leaves out point \"inner\""},
      {"inner = [10, 0, 40]", "inner = @[10, 40]", "write three"},
      {"inner = [10, 0, 40]", "@inne = [10, 0, 40]", "did you mean \"inner\""},
      {"places  = [0, 0.5, 1]", "places  = @[0, 0.5, 0.7, 1]",
       "has 4 numbers; write 3, one for each of its points"},
      {"at = [48, 0, 42]", "at = @[48, 42]", "write three"},
      {"frame = 14, at = { ", "frame = 14, roll = @3, at = { ", "the points of a row look nowhere"},
      {"timing  = \"frames\"", "timing  = \"frames\"\ndistance = @\"inner\"", "remove distance"},
  };
  for (const auto& [from, to, word] : cases) {
    std::string text = with(raise, from, to);
    if (text.find('@') == std::string::npos)
      text = with(text, "{ frame = 0,  at = {", "{ frame = 0,  at = @{");
    if (word.empty()) text = with(text, "@network = false", "network = false");
    if (word.empty()) text = with(text, "space   = [", "space   = @[");
    expect_refused([](const std::string& one, const std::string& name) { planned(one, name); }, text,
                   {word.empty() ? "add network = true" : word});
  }
}

/// A row of two points, on these axes.
std::string row_of_two(const std::string& axes, const std::string& first, const std::string& second) {
  return fmt::format(
      "name = \"two\"\nfps = 24\nframes = 24\n[[track]]\naxes = [{0}]\nspace = [\"{1}\", \"{2}\"]\n"
      "elbow = \"down\"\nunit = \"mm\"\nnetwork = true\ntiming = \"frames\"\n"
      "keys = [{{ frame = 0, at = {{ {1} = [10, 0, 40] }} }}, {{ frame = 24, at = {{ {1} = [11, 0, 41] }} "
      "}}]\n"
      "[track.drawn]\n{2} = [{{ frame = 0, at = [30, 0, 40] }}, {{ frame = 24, at = [31, 0, 41] }}]\n",
      axes, first, second);
}

TEST(RowOfPoints, EachPointHasAxesOfItsOwnAndEachAxisAPoint) {
  const auto refuse = [](const std::string& text, std::string_view word) {
    expect_refused([](const std::string& one, const std::string& name) { planned(one, name); }, text, {word});
  };
  const std::string axes = R"("inner_swing", "inner_bend", "middle_swing", "middle_bend")";
  planned(row_of_two(axes, "inner", "middle"));
  refuse(with(row_of_two(axes, "inner", "brow"), "space = [", "space = @["), "the rig has no tip \"brow\"");
  refuse(row_of_two(axes + ", @\"outer_bend\"", "inner", "middle"),
         "axis \"outer_bend\" moves no point of the row");
  refuse(with(row_of_two(R"("inner_swing", "inner_bend", "middle_swing")", "inner", "middle"), "space = [",
              "space = @["),
         "axis \"middle_bend\" moves \"middle\" and is not in this track");
  std::string text = file_contents(rig_path.string());
  const RigFile rig = parse_rig(with(text, "\"middle\", \"outer\"", "\"inner_reach\""), rig_path.string());
  expect_refused(
      [&](const std::string& one, const std::string& name) {
        Plan(parse_move(one, name), rig,
             {.kinematics = std::make_shared<const Kinematics>(read_kinematics(rig))});
      },
      row_of_two("@\"inner_swing\", \"inner_bend\"", "inner", "inner_reach"),
      {"axis \"inner_swing\" moves \"inner\" and \"inner_reach\"", "axes of its own"});
}

TEST(RowOfPoints, WhatTheJointsCannotReachIsToldWithFrameKeyAndAxis) {
  expect_refused(
      [](const std::string& text, const std::string& name) { planned(text, name); },
      with(raise, "{ frame = 14, at = { inner = [11, 0, 47]", "{ frame = 14, at = { inner = [11, 0, 60]")
          .insert(raise.find("{ frame = 0,"), "@"),
      {"frame 12.", "\"inner\" cannot get there", "beyond what axis \"inner_bend\" lets it reach"});
}

}  // namespace row_of_points_test
}  // namespace inbetween
