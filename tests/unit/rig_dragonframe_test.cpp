// What a rig is to Dragonframe.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "host_tools/motions/lone_axis.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace rig_dragonframe_test {

std::string rig_with(const std::string& section, std::size_t axes = 2) {
  std::vector<AxisText> texts;
  for (std::size_t a = 0; a < axes; ++a) {
    texts.push_back({.name = a == 0 ? "pan" : a == 1 ? "tilt" : "axis" + std::to_string(a)});
  }
  return rig_text(texts, {.more = section});
}

TEST(RigDragonframe, HasStepsForEveryAxisInTheOrderOfTheRig) {
  const std::string section = "[dragonframe]\nsteps_per_unit = { tilt = -50, pan = 100.5 }\n";
  const RigFile rig = parse_rig(rig_with(section), "rig.toml");
  ASSERT_TRUE(rig.dragonframe);
  EXPECT_THAT(rig.dragonframe->steps_per_unit, testing::ElementsAre(100.5, -50));
  EXPECT_FALSE(parse_rig(rig_with(""), "rig.toml").dragonframe) << "a rig needs none";
  EXPECT_FALSE(lone_axis(rig, 1).dragonframe) << "of one axis alone it would be another rig";
}

TEST(RigDragonframe, RefusesWhatIsNoSteps) {
  const auto section = [](const std::string& steps) {
    return rig_with("[dragonframe]\nsteps_per_unit = " + steps + "\n");
  };
  expect_refused(parse_rig, section("{ pan = 100, tilt = @0 }"), {"steps_per_unit.tilt is 0"});
  expect_refused(parse_rig, section("@{ pan = 100 }"), {"no number for axis \"tilt\"", "tilt = 100.0"});
  expect_refused(parse_rig, section("{ pan = 100, tilt = 100, yaw = @100 }"), {"is of no axis of the rig"});
  expect_refused(parse_rig, section("{ pan = 100, tilt = @10_000_000 }"),
                 {"200 mm would be more steps than 32 bits hold", "at most"});
  expect_refused(parse_rig, rig_with("@[dragonframe]\nsteps_per_unit = { pan = 1 }\n", 33),
                 {"33 axes", "up to 32"});
}

}  // namespace rig_dragonframe_test
}  // namespace inbetween
