// inbetween export and import of scenes as their users meet them.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "tests/support/oracle_scene.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace scene_command_test {

using testing::AllOf;
using testing::HasSubstr;

class SceneCommand : public testing::Test {
 protected:
  [[nodiscard]] std::string in_folder(const std::string& name) const { return folder_.path() / name; }
  [[nodiscard]] ProgramRun run(const std::string& command, const std::string& from, const std::string& to,
                               std::vector<std::string> more, const std::string& rig) const {
    std::vector<std::string> words = {command, from, "--to", in_folder(to)};
    if (!rig.empty()) words.insert(words.end(), {"--rig", rig});
    words.insert(words.end(), more.begin(), more.end());
    return run_program(words);
  }
  [[nodiscard]] ProgramRun export_crane(const std::string& to,
                                        const std::vector<std::string>& more = {}) const {
    return run("export", in_checkout("examples/crane/over_the_table.toml"), to, more, crane_);
  }
  [[nodiscard]] ProgramRun import_to_crane(const std::string& from,
                                           const std::vector<std::string>& more = {}) const {
    return run("import", in_folder(from), "back.toml", more, crane_);
  }

  TemporaryFolder folder_;
  std::string crane_ = in_checkout("examples/crane/rig.toml");
  std::string slider_ = in_checkout("examples/camera_rig.toml");
};

TEST_F(SceneCommand, WhatGoesOutComesBackAsTheSameMove) {
  for (const char* file : {"a.gltf", "a.glb", "a.usda"}) {
    const ProgramRun out = export_crane(file);
    ASSERT_EQ(out.status, 0) << out.err;
    EXPECT_THAT(out.out, AllOf(HasSubstr("289 rows, 24 a second, of 10 links and the camera \"camera_view\""),
                               HasSubstr("within 0.24 mm and 0.01 degrees of the motion")));
    const ProgramRun back = import_to_crane(file, {"--over"});
    ASSERT_EQ(back.status, 0) << back.err;
    EXPECT_THAT(back.out, AllOf(HasSubstr("288 frames of track, swing, boom, pan, tilt, roll at 24 fps"),
                                HasSubstr("camera goes where \"camera_view\" goes: on the rows within ")));
    EXPECT_THAT(file_contents(in_folder("back.csv")), HasSubstr("\n144,"));
  }
}

TEST_F(SceneCommand, ACameraBecomesKeysAndSaysHowFarTheTipIsFromIt) {
  ASSERT_EQ(export_crane("a.glb", {"--frames", "0..48"}).status, 0);
  const ProgramRun fitted = import_to_crane("a.glb", {"--fit", "0.1"});
  ASSERT_EQ(fitted.status, 0) << fitted.err;
  EXPECT_THAT(fitted.out, AllOf(HasSubstr("17 of 294 numbers"),
                                HasSubstr("on the rows within 0.2 mm and 0.002 degrees")));
  EXPECT_THAT(file_contents(in_folder("back.toml")), HasSubstr("speed "));
}

TEST_F(SceneCommand, ASpikeIsNamedBeforeTheRigMoves) {
  ASSERT_EQ(export_crane("a.usda", {"--frames", "0..48"}).status, 0);
  std::string text = file_contents(in_folder("a.usda"));
  const std::string row = "24: (";  // of the track, which is first in the file
  const std::size_t at = text.find(row) + row.size();
  const std::size_t end = text.find(',', at);
  text.replace(at, end - at, fmt::format("{}", std::stod(text.substr(at, end - at)) + 0.3));
  std::ofstream(in_folder("a.usda")) << text;
  const ProgramRun spike = import_to_crane("a.usda");
  EXPECT_EQ(spike.status, 0) << spike.err;
  EXPECT_THAT(spike.err,
              AllOf(HasSubstr("off the motion around it on frame 24"), HasSubstr("--without-spikes")));
  const ProgramRun smooth = import_to_crane("a.usda", {"--smooth", "0.01", "--without-spikes", "--over"});
  EXPECT_EQ(smooth.status, 0) << smooth.err;
  EXPECT_THAT(smooth.err, HasSubstr("it follows that motion instead"));
}

TEST_F(SceneCommand, ATakeIsASceneOfWhereTheCameraWas) {
  const ProgramRun played = run_program({"run", in_checkout("examples/crane/over_the_table.toml"), "--rig",
                                         crane_, "--sim", "--fast", "--takes-in", in_folder("takes.db")});
  ASSERT_EQ(played.status, 0) << played.err;
  const auto exported = [&](const std::string& to, const std::vector<std::string>& more) {
    const ProgramRun out = run("export", in_folder("takes.db"), to, more, "");
    EXPECT_EQ(out.status, 0) << out.err;
    return OracleUsd(file_contents(in_folder(to)));
  };
  const OracleUsd measured = exported("measured.usda", {"--take", "1", "--measured"});
  const OracleUsd told = exported("told.usda", {"--take", "1"});
  ASSERT_EQ(export_crane("asked.usda").status, 0);
  const OracleUsd asked(file_contents(in_folder("asked.usda")));
  const auto apart = [](const OracleUsd& a, const OracleUsd& b) {
    double most = 0;
    for (int frame = 0; frame <= 288; ++frame) {
      const OraclePose one = a.pose("camera_view", frame), other = b.pose("camera_view", frame);
      for (std::size_t i = 0; i < 3; ++i)
        most = std::max(most, std::fabs(one.position[i] - other.position[i]));
    }
    return most;
  };
  // A frame lies between two ticks of 4 ms on a straight line. Simulated drives are a tick late, at 1.5 m/s.
  EXPECT_LE(apart(told, asked), 2e-5);
  EXPECT_LE(apart(measured, asked), 7e-3);
  EXPECT_GE(apart(measured, told), 3e-3);
  const ProgramRun wrong = run("export", in_folder("takes.db"), "c.usda", {"--take", "1"}, crane_);
  EXPECT_EQ(wrong.status, 2);
  EXPECT_THAT(wrong.err, HasSubstr("a take has the rig, the frames, the rate"));
}

TEST_F(SceneCommand, ALineTestIsAPictureForEachFrameAndAScene) {
  const auto line_test = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"export",      in_checkout("examples/crane/over_the_table.toml"),
                                      "--rig",       crane_,
                                      "--frames",    "100..104",
                                      "--line-test", in_folder("pictures")};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(words);
  };
  const ProgramRun out = line_test({});
  ASSERT_EQ(out.status, 0) << out.err;
  EXPECT_THAT(out.out, HasSubstr("5 pictures of the path, the links and what the camera sees"));
  std::vector<std::string> pictures;
  for (const char* name : {"frame_00100.png", "frame_00102.png", "frame_00104.png"}) {
    pictures.push_back(file_contents(in_folder("pictures") + "/" + name));
    EXPECT_EQ(pictures.back().substr(1, 3), "PNG") << name;
  }
  EXPECT_NE(pictures[0], pictures[1]);
  EXPECT_NE(pictures[1], pictures[2]);
  EXPECT_EQ(file_contents(in_folder("pictures") + "/frame_00105.png"), "");
  const OracleGltf scene(file_contents(in_folder("pictures") + "/scene.glb"));
  EXPECT_EQ(scene.times().size(), 5U);
  EXPECT_THAT(line_test({}).err, HasSubstr("is there already, and not empty; add --over"));
  EXPECT_EQ(line_test({"--over"}).status, 0);
  EXPECT_THAT(line_test({"--to", in_folder("a.glb")}).err, HasSubstr("--line-test has its own files"));
}

TEST_F(SceneCommand, WhatASceneHasNotIsWrongUsage) {
  const auto wrong = [&](const std::string& to, const std::vector<std::string>& more) {
    const ProgramRun run = export_crane(to, more);
    EXPECT_EQ(run.status, 2) << run.err;
    return run.err;
  };
  EXPECT_THAT(wrong("a.glb", {"--up", "z"}), HasSubstr("glTF has metres and y up"));
  EXPECT_THAT(wrong("a.glb", {"--unit", "cm"}), HasSubstr("glTF has metres and y up"));
  EXPECT_THAT(wrong("a.usda", {"--unit", "deg"}), HasSubstr("the unit of a scene is a length"));
  EXPECT_THAT(wrong("a.usda", {"--axis", "tx=track"}), HasSubstr("leave out --axis and --count"));
  EXPECT_THAT(wrong("a.usda", {"--rolls"}), HasSubstr("leave out --rolls"));
  EXPECT_THAT(wrong("a.usda", {"--decimals", "3"}), HasSubstr("leave out --decimals"));
  EXPECT_THAT(wrong("a.csv", {"--tip", "camera"}), HasSubstr("--tip is for a scene"));
  EXPECT_THAT(wrong("a.glb", {"--format", "obj"}), HasSubstr("record, gltf, glb, usda"));
}

TEST_F(SceneCommand, ARigWithoutKinematicsHasNoCameraInSpace) {
  const ProgramRun out = run("export", in_checkout("examples/reveal.toml"), "a.glb", {}, slider_);
  EXPECT_EQ(out.status, 1);
  EXPECT_THAT(
      out.err,
      HasSubstr(
          "the rig has no [kinematics], so that nobody knows where its camera is; name its URDF file there"));
  ASSERT_EQ(export_crane("a.glb").status, 0);
  const ProgramRun in = run("import", in_folder("a.glb"), "back.toml", {}, slider_);
  EXPECT_EQ(in.status, 1);
  EXPECT_THAT(in.err, HasSubstr("say it with --axis tx=AXIS, and of ty, tz, pan, tilt and roll"));
  const ProgramRun columns =
      run("import", in_folder("a.glb"), "back.toml",
          {"--axis", "tx=slide", "--axis", "pan=pan", "--scale", "0.4", "--place", "-0.5,0,0"}, slider_);
  EXPECT_EQ(columns.status, 0) << columns.err;
  EXPECT_THAT(columns.out, HasSubstr("288 frames of slide, pan, tilt at 24 fps"));
}

TEST_F(SceneCommand, WhatIsSaidOfSceneIsForScenes) {
  ASSERT_EQ(export_crane("a.glb").status, 0);
  EXPECT_THAT(import_to_crane("a.glb", {"--place", "1,2"}).err,
              HasSubstr("--place \"1,2\": write three numbers in metres"));
  EXPECT_THAT(import_to_crane("a.glb", {"--up", "z"}).err, HasSubstr("leave out --up, --phase and --count"));
  EXPECT_THAT(import_to_crane("a.glb", {"--rate-hz", "250"}).err,
              HasSubstr("leave out what is said of tables"));
  EXPECT_THAT(import_to_crane("a.glb", {"--node", "hat"}).err, HasSubstr("there is no node \"hat\""));
  EXPECT_THAT(import_to_crane("a.glb", {"--place", "0,0,50"}).err,
              HasSubstr("on frame 0 the rig comes no nearer to the scene than"));
  EXPECT_THAT(import_to_crane("a.csv", {"--node", "hat"}).err, HasSubstr("is no scene (.gltf, .glb, .usda)"));
  EXPECT_THAT(import_to_crane("a.usdz").err,
              HasSubstr("this is USD in an archive, by its ending; take USD as text"));
}

}  // namespace scene_command_test
}  // namespace inbetween
