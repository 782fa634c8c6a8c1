// What a rig says about the lens of its camera.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "host_tools/rig_model/rig_file.hpp"
#include "tests/support/places.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace rig_lens_test {

using testing::ElementsAre;

const std::string lens =
    "focal_length_mm = 35\nsensor_mm = [23.6, 15.7]\nresolution_px = [6000, 4000]\ndistance_m = 0.8\n";

std::string rig_with(const std::string& lens_text, const std::string& tip = R"("camera")") {
  return rig_text({{.name = "pan", .unit = "deg"}},
                  {.more = "[kinematics]\nurdf = \"r.urdf\"\ntip = " + tip + "\n[lens]\n" + lens_text});
}

TEST(RigLens, IsReadWithTheTipThatThereIs) {
  const RigFile rig = parse_rig(rig_with(lens), "rig.toml");
  ASSERT_TRUE(rig.lens);
  EXPECT_EQ(rig.lens->focal_length_mm, 35);
  EXPECT_THAT(rig.lens->sensor_mm, ElementsAre(23.6, 15.7));
  EXPECT_THAT(rig.lens->resolution_px, ElementsAre(6000, 4000));
  EXPECT_EQ(rig.lens->distance_m, 0.8);
  EXPECT_EQ(rig.lens->tip, "camera");
  EXPECT_EQ(rig.lens->place.line, 6U);
  EXPECT_FALSE(parse_rig(rig_text({{.name = "pan"}}), "rig.toml").lens) << "a rig needs none";
}

TEST(RigLens, IsAtTheTipThatItNames) {
  const std::string two = R"(["hook", "camera"])";
  EXPECT_EQ(parse_rig(rig_with(lens + "tip = \"camera\"\n", two), "rig.toml").lens->tip, "camera");
  expect_refused(parse_rig, with(rig_with(lens, two), "[lens]", "@[lens]"),
                 {"does not say at which tip", R"(tip = "hook", one of "hook", "camera")"});
  expect_refused(parse_rig, rig_with(lens + "tip = @\"hand\"\n", two),
                 {R"("hand", which is no tip of [kinematics])", R"("hook", "camera")"});
}

TEST(RigLens, WithoutJointsIsNowhere) {
  expect_refused(parse_rig, rig_text({{.name = "pan"}}, {.more = "@[lens]\n" + lens}),
                 {"without [kinematics]", "add [kinematics], or leave it out"});
}

TEST(RigLens, HasNumbersThatALensMayHave) {
  const auto refuse = [](const std::string& from, const std::string& to, std::string_view words) {
    expect_refused(parse_rig, with(rig_with(lens), from, to), {words});
  };
  refuse("= 35", "= @0", "focal_length_mm is 0; write a number above 0");
  refuse("= 35", "= @20_000", "focal_length_mm");
  refuse("= 0.8", "= @-1", "distance_m");
  refuse("[23.6, 15.7]", "@[23.6]", "write sensor_mm = [36.0, 24.0], width and height");
  refuse("[23.6, 15.7]", "[23.6, @0]", "sensor_mm[1] is 0");
  refuse("[6000, 4000]", "[@6000.5, 4000]", "resolution_px[0]");
  refuse("[6000, 4000]", "@[1, 2, 3]", "resolution_px");
  refuse("sensor_mm", "@sensor", "sensor_mm");
  refuse("[lens]\nfocal_length_mm = 35", "@[lens]", "focal_length_mm = 50.0");
}

TEST(RigLens, OfTheCraneIsAtItsCamera) {
  EXPECT_EQ(read_rig_file(in_checkout("examples/crane/rig.toml")).lens.value().tip, "camera");
}

}  // namespace rig_lens_test
}  // namespace inbetween
