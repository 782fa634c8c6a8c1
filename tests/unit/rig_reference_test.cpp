// Which axes know where they are, from one run to the next.
#include "host_tools/reference/rig_reference.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host_tools/rig/simulated_hardware.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace rig_reference_test {

using testing::AllOf;
using testing::HasSubstr;

/// A homed slide and a focus that its operator sets, both on steps, a crane whose CAN drive knows where it
/// is, and one whose drive does not.
const std::string four_axes = rig_text(
    {{.name = "slide",
      .min = 0,
      .max = 800,
      .max_velocity = 100,
      .max_acceleration = 250,
      .more =
          R"(home = { chip = "gpio", line = 23, active = "high", direction = "negative", fast = 40, slow = 4, back_off = 10, at = -5 })",
      .drive = R"(type = "step-dir", chip = "gpio", step = 17, dir = 27, steps_per_unit = 80)"},
     axis_text("focus", "deg", {0, 270}, {.velocity = 100}, R"(reference = "operator")",
               R"(type = "step-dir", chip = "gpio", step = 19, dir = 26, steps_per_unit = 10)"),
     axis_text("crane", "deg", {-90, 90}, {.velocity = 10, .acceleration = 10}, R"(reference = "drive")",
               cia402_text(1)),
     axis_text("swing", "deg", {-90, 90}, {.velocity = 10, .acceleration = 10}, R"(reference = "operator")",
               cia402_text(2))},
    {.name = "four", .rate_hz = 250, .more = bus_can0});

constexpr std::size_t slide = 0, focus = 1, crane = 2, swing = 3;

std::vector<std::size_t> unreferenced_of(const RigReference& reference) {
  std::vector<std::size_t> axes;
  for (std::size_t a = 0; a < 4; ++a) {
    if (!reference.is_referenced(a)) axes.push_back(a);
  }
  return axes;
}

/// The rig and the file of its positions; a run is one RigReference after another.
struct Stage {
  RigFile rig = parse_rig(four_axes, "rig.toml");
  TemporaryFolder folder;
  std::string file = (folder.path() / "state" / "four.positions").string();

  [[nodiscard]] RigReference reference() const { return {rig, file}; }
  void say(const std::vector<std::pair<std::size_t, double>>& positions) const {
    RigReference reference = this->reference();
    for (const auto& [axis, position] : positions) reference.stands_at(axis, position);
  }
  [[nodiscard]] std::vector<std::size_t> unreferenced() const { return unreferenced_of(reference()); }
};

/// What drives tell that rest.
std::vector<DriveState> resting(const std::vector<double>& positions) {
  std::vector<DriveState> states;
  for (const double position : positions) states.push_back({.actual = position, .is_on = true});
  return states;
}

/// The drives, tick by tick.
struct Ticks {
  RigDrives& drives;
  std::vector<DriveState> states = std::vector<DriveState>(4);
  std::int64_t now_ns = 0;

  void tick(const std::vector<Setpoint>& setpoints) {
    now_ns += 4'000'000;
    drives.read(states, now_ns);
    drives.write(setpoints, now_ns);
  }
};

std::string refusal(const RigReference& reference, std::vector<std::size_t> axes) {
  try {
    reference.refuse_unreferenced(axes);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(RigReference, ARigThatWasNeverUsedKnowsOnlyWhatItsDrivesTell) {
  const Stage stage;
  EXPECT_EQ(stage.unreferenced(), (std::vector{slide, focus, swing}));
  EXPECT_EQ(file_contents(stage.file), "") << "reading writes nothing";
}

TEST(RigReference, WithoutAFileEveryAxisIsWhereItStands) {
  const RigFile rig = parse_rig(four_axes, "rig.toml");
  RigReference reference(rig);
  EXPECT_TRUE(unreferenced_of(reference).empty());
  EXPECT_EQ(reference.position(slide), std::nullopt);
  SimulatedHardware hardware(rig, {1, 2, 3, 4});
  RigDrives drives(rig, hardware);
  reference.place(drives);
  reference.about_to_move(std::vector{slide});
  reference.at_rest(drives, resting({5, 2, 3, 4}), false);
  EXPECT_TRUE(unreferenced_of(reference).empty());
}

TEST(RigReference, WhatIsSaidIsKnownInTheNextRunAndToTheDrives) {
  const Stage stage;
  stage.say({{slide, 120}, {focus, 0}, {swing, -30}});
  EXPECT_TRUE(stage.unreferenced().empty());
  SimulatedHardware hardware(stage.rig, {7, 7, 7, 7});
  RigDrives drives(stage.rig, hardware);
  stage.reference().place(drives);
  drives.enable();
  Ticks loop{drives};
  for (int i = 0; i < 2000 && !(loop.states[swing].is_on && loop.states[crane].is_on); ++i) loop.tick({});
  EXPECT_EQ(loop.states[slide].actual, 120);
  EXPECT_EQ(loop.states[focus].actual, 0);
  EXPECT_EQ(loop.states[crane].actual, 7) << "its drive knows";
  EXPECT_EQ(loop.states[swing].actual, -30);
}

// docs/faults.md 47
TEST(RigReference, AnAxisThatMovedWhenTheProgramEndedIsUnreferenced) {
  const Stage stage;
  stage.say({{slide, 120}, {focus, 0}, {swing, -30}});
  {
    RigReference reference = stage.reference();
    reference.about_to_move(std::vector{slide, crane});
  }
  EXPECT_EQ(stage.unreferenced(), std::vector{slide}) << "the others have not moved";
  EXPECT_THAT([&] { stage.reference().refuse_unreferenced(std::vector{slide}); },
              testing::ThrowsMessage<InputError>(HasSubstr("it was moving")));
}

TEST(RigReference, AfterRestAnAxisIsWhereItsDriveTells) {
  const Stage stage;
  stage.say({{slide, 120}, {focus, 0}, {swing, -30}});
  {
    RigReference reference = stage.reference();
    SimulatedHardware hardware(stage.rig, {120, 0, 0, -30});
    RigDrives drives(stage.rig, hardware);
    reference.about_to_move(std::vector{slide, crane, swing});
    reference.at_rest(drives, resting({55.0125, 99, 10, -20.5}), false);
  }
  EXPECT_TRUE(stage.unreferenced().empty());
  EXPECT_EQ(stage.reference().position(slide), 55.0125);
  EXPECT_EQ(stage.reference().position(focus), 0) << "it was not to move";
  EXPECT_EQ(stage.reference().position(crane), std::nullopt) << "its drive tells";
  EXPECT_EQ(stage.reference().position(swing), -20.5);
}

TEST(RigReference, AnUnreferencedAxisThatMovesStaysUnreferenced) {
  const Stage stage;
  stage.say({{slide, 120}});
  {
    RigReference reference = stage.reference();
    SimulatedHardware hardware(stage.rig, {120, 0, 0, 0});
    RigDrives drives(stage.rig, hardware);
    reference.about_to_move(std::vector{slide, focus});
    reference.at_rest(drives, resting({121, 3, 0, 0}), false);
    EXPECT_FALSE(reference.is_referenced(focus));
  }
  EXPECT_EQ(stage.unreferenced(), (std::vector{focus, swing}));
}

// docs/faults.md 28: whatever lost its power may have been moved by hand.
TEST(RigReference, WithoutPowerAnAxisThatNothingReportsIsLost) {
  const Stage stage;
  stage.say({{slide, 120}, {focus, 0}, {swing, -30}});
  {
    RigReference reference = stage.reference();
    SimulatedHardware hardware(stage.rig, {120, 0, 0, -30});
    RigDrives drives(stage.rig, hardware);
    reference.about_to_move(std::vector{slide, swing});
    reference.at_rest(drives, resting({55, 0, 0, -20}), true);
  }
  EXPECT_EQ(stage.unreferenced(), std::vector{slide});
  EXPECT_EQ(stage.reference().position(swing), -20) << "its drive has counted on";
}

TEST(RigReference, AnAxisWhoseDriveIsOutOfReachIsLost) {
  const Stage stage;
  stage.say({{slide, 120}, {focus, 0}, {swing, -30}});
  {
    RigReference reference = stage.reference();
    SimulatedHardware hardware(stage.rig, {120, 0, 0, -30});
    RigDrives drives(stage.rig, hardware);
    std::vector<DriveState> states = resting({120, 0, 0, -20});
    states[swing].condition = DriveCondition::unreachable;
    reference.about_to_move(std::vector{swing});
    reference.at_rest(drives, states, false);
  }
  EXPECT_EQ(stage.unreferenced(), std::vector{swing});
}

TEST(RigReference, AnAxisThatHasLostItsStepsIsLost) {
  const Stage stage;
  stage.say({{slide, 120}, {focus, 0}, {swing, -30}});
  {
    RigReference reference = stage.reference();
    SimulatedHardware hardware(stage.rig, {120, 0, 0, -30});
    RigDrives drives(stage.rig, hardware);
    reference.place(drives);
    reference.about_to_move(std::vector{slide});
    drives.enable();
    Ticks loop{drives};
    for (int i = 0; i < 2000 && !loop.states[slide].is_on; ++i) loop.tick({});
    for (int i = 0; i < 10; ++i) {
      loop.tick({{.position = 120 + 0.2 * i, .velocity = 50}, {.position = 0}, {}, {.position = -30}});
    }
    loop.tick({});  // in the middle of its motion nothing is sent any more
    loop.tick({});
    ASSERT_TRUE(drives.has_lost_position(slide));
    reference.at_rest(drives, loop.states, false);
  }
  EXPECT_EQ(stage.unreferenced(), std::vector{slide});
  EXPECT_EQ(stage.reference().position(focus), 0) << "it was not to move";
}

// docs/faults.md 24
TEST(RigReference, AnAxisWhoseDriveHasStartedAnewIsLostAndNotRunAgain) {
  const Stage stage;
  stage.say({{slide, 120}, {focus, 0}, {swing, -30}});
  {
    RigReference reference = stage.reference();
    const FaultScript faults = parse_fault_script("[[fault]]\naxis = \"swing\"\nwhat = \"reboot\"\nat = 4\n",
                                                  "faults.toml", stage.rig);
    SimulatedHardware hardware(stage.rig, {120, 0, 0, -30}, faults);
    RigDrives drives(stage.rig, hardware);
    reference.place(drives);
    reference.about_to_move(std::vector{swing});
    drives.enable();
    Ticks loop{drives};
    for (int i = 0; i < 2000 && !drives.has_lost_position(swing); ++i) loop.tick({});
    ASSERT_TRUE(drives.has_lost_position(swing));
    EXPECT_FALSE(drives.has_lost_position(crane));
    reference.at_rest(drives, loop.states, false);
  }
  EXPECT_EQ(stage.unreferenced(), std::vector{swing});
  EXPECT_THAT(refusal(stage.reference(), {swing}), HasSubstr("axis \"swing\" does not know where it is"));
}

// docs/faults.md 24
TEST(RigReference, ADriveThatHasStartedAnewIsNotBelievedAgainThoughItsAxisWasNotToMove) {
  const Stage stage;
  stage.say({{slide, 120}, {focus, 0}, {swing, -30}});
  {
    RigReference reference = stage.reference();
    const FaultScript faults = parse_fault_script("[[fault]]\naxis = \"swing\"\nwhat = \"reboot\"\nat = 4\n",
                                                  "faults.toml", stage.rig);
    SimulatedHardware hardware(stage.rig, {120, 0, 0, -30}, faults);
    RigDrives drives(stage.rig, hardware);
    reference.place(drives);
    reference.about_to_move(std::vector{slide});
    drives.enable();
    Ticks loop{drives};
    for (int i = 0; i < 2000 && !drives.has_lost_position(swing); ++i) loop.tick({});
    ASSERT_TRUE(drives.has_lost_position(swing));
    drives.enable();  // somebody acknowledges what was found, which brings back no turns
    for (int i = 0; i < 2000; ++i) loop.tick({});
    EXPECT_TRUE(drives.has_lost_position(swing));
    reference.at_rest(drives, loop.states, false);
    reference.forget_restarted(drives);
  }
  EXPECT_EQ(stage.unreferenced(), std::vector{swing});
}

TEST(RigReference, WhatIsLostIsUnreferencedUntilSomebodySaysWhereItIs) {
  const Stage stage;
  stage.say({{slide, 120}, {focus, 0}, {swing, -30}});
  stage.reference().is_lost(focus, "its switch was not found");
  EXPECT_EQ(stage.unreferenced(), std::vector{focus});
  stage.say({{focus, 12}});
  EXPECT_TRUE(stage.unreferenced().empty());
}

TEST(RigReference, TheRefusalNamesTheAxisWhyAndWhatToDo) {
  const Stage stage;
  const RigReference reference = stage.reference();
  EXPECT_THAT(refusal(reference, {crane, slide}), AllOf(HasSubstr("rig.toml:5:1: error: axis \"slide\""),
                                                        HasSubstr(stage.file), HasSubstr("inbetween home")));
  EXPECT_THAT(refusal(reference, {swing}), AllOf(HasSubstr("\"swing\""), HasSubstr("--set-zero")));
  EXPECT_EQ(refusal(reference, {crane}), "");
}

TEST(RigReference, WhereNothingCanBeWrittenNothingMayMove) {
  const Stage stage;
  const TemporaryFile in_the_way("state", "a file where a folder should be");
  RigReference reference(stage.rig, in_the_way.path().string() + "/four.positions");
  EXPECT_THROW(reference.about_to_move(std::vector{slide}), std::runtime_error);
  EXPECT_NO_THROW(reference.about_to_move(std::vector{crane})) << "nothing is kept of it";
}

TEST(RigReference, NobodySaysWhereAnAxisIsThatItsDriveKnows) {
  const Stage stage;
  RigReference reference = stage.reference();
  EXPECT_THROW(reference.stands_at(crane, 0), std::logic_error);
  EXPECT_THROW(reference.is_lost(crane, "?"), std::logic_error);
}

// docs/faults.md 42
TEST(RigReference, OneAtATimeHasAFileByWhateverNameItHasIt) {
  const Stage stage;
  const std::filesystem::path folder = stage.folder.path();
  std::filesystem::create_directory(folder / "state");
  std::filesystem::create_directory_symlink(folder / "state", folder / "link");
  {
    const RigReference first = reference_of(stage.rig, stage.file, false);
    for (const std::string& name : {stage.file, (folder / "link" / "four.positions").string(),
                                    (folder / "link" / ".." / "state" / "four.positions").string()}) {
      EXPECT_THAT([&] { reference_of(stage.rig, name, true); },
                  testing::ThrowsMessage<InputError>(
                      name + ": error: another inbetween uses these positions; end it first"));
    }
    EXPECT_NO_THROW(reference_of(stage.rig, stage.file + "2", false)) << "another file";
    EXPECT_NO_THROW(reference_of(stage.rig, std::nullopt, true)) << "no file";
  }
  EXPECT_NO_THROW(reference_of(stage.rig, stage.file, false)) << "the first has ended";
}

}  // namespace rig_reference_test
}  // namespace inbetween
