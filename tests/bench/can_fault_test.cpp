// Faults of the drives and of the bus in a move over the kernel's CAN, and what all axes do then
// (docs/faults.md).
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "tests/support/bus_scene.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace can_fault_test {

using testing::HasSubstr;

/// In the midst of the move, which lasts eight seconds.
constexpr std::string_view in_motion = "after_motion = 4";
const std::vector<std::string> all{"slide", "pan", "tilt"};

std::string fault(std::string_view axis, std::string_view what, std::string_view more = in_motion) {
  return fmt::format("[[fault]]\naxis = \"{}\"\nwhat = \"{}\"\n{}\n", axis, what, more);
}

BusScene scene_with(const std::string& faults) {
  return BusScene(BusSceneOptions{.faults = faults});
}

/// Status 4 and what is wrong with which axis, in words.
void expect_told(const BusScene& scene, std::string_view axis, std::string_view words) {
  EXPECT_EQ(scene.run.status, 4) << scene.run.err;
  EXPECT_THAT(scene.run.out, HasSubstr(fmt::format("axis \"{}\": {}", axis, words)));
}

/// The rig was not switched on, and it is said why; no drive minds that nothing follows.
void expect_refused_at_arming(const BusScene& scene, std::string_view axis, std::string_view words) {
  expect_told(scene, axis, words);
  for (const std::string& name : all) EXPECT_TRUE(scene.targets(name).empty()) << name << " was switched on";
  scene.expect_quiet();
}

// docs/faults.md 18. First more than a bus of 1 Mbit/s carries that is meant for nobody, then as much as it
// carries that is for us. Work takes no time on this clock: the loop waits for none of it, and what it takes
// in a tick is bounded; can_loop_test counts.
TEST(CanFault, AFloodDoesNotMakeTheLoopLate) {
  const BusScene noise("sleep 5; cangen can0 -g 0 -I 123 -L 8 -n 5000");
  EXPECT_EQ(noise.run.status, 0) << noise.run.err;
  EXPECT_THAT(noise.run.out, HasSubstr("late ticks 0;"));
  const BusScene babble =
      scene_with(fault("tilt", "flood", "after_motion = 3\nfor = 0.5\nframes_per_s = 5000"));
  EXPECT_EQ(babble.run.status, 0) << babble.run.err;
  EXPECT_THAT(babble.run.out, HasSubstr("late ticks 0;"));
}

// docs/faults.md 18
TEST(CanFault, AFloodInWhichFramesOfOursAreLostIsAStopAndTheLoopIsNotLate) {
  const BusScene scene =
      scene_with(fault("tilt", "flood", "after_motion = 4\nfor = 0.2\nframes_per_s = 60000"));
  EXPECT_EQ(scene.run.status, 4) << scene.run.err;
  EXPECT_THAT(scene.run.out, HasSubstr("late ticks 0;"));
  scene.expect_stop_on_path(all);
}

// docs/faults.md 19
TEST(CanFault, AFewShortOrDoubleFramesAreForgiven) {
  for (const char* what : {"short-frames", "duplicate-frames"}) {
    const BusScene scene = scene_with(fault("pan", what, "after_motion = 4\ncount = 2"));
    EXPECT_NE(scene.fault_ns(), 0);
    EXPECT_EQ(scene.run.status, 0) << what << "\n" << scene.run.out << scene.run.err;
  }
}

// docs/faults.md 19
TEST(CanFault, ShortFramesNowAndThenAreAStopOfAllOnThePath) {
  std::string faults;
  for (int i = 0; i < 10; ++i) {
    faults += fault("pan", "short-frames", fmt::format("after_motion = {:.2f}\ncount = 1", 3.6 + 0.04 * i));
  }
  const BusScene scene = scene_with(faults);
  expect_told(scene, "pan", "too many frames of the drive are short, unknown or come twice");
  scene.expect_stop_on_path(all, 2);
}

// docs/faults.md 19
TEST(CanFault, DoubleFramesAreAStopOfAllOnThePath) {
  const BusScene scene = scene_with(fault("pan", "duplicate-frames"));
  expect_told(scene, "pan", "too many frames of the drive are short, unknown or come twice");
  scene.expect_stop_on_path(all);
  scene.expect_quiet();
}

// docs/faults.md 20
TEST(CanFault, WhenADriveIsNotHeardAllStopOnThePath) {
  const BusScene scene =
      scene_with(fault("tilt", "lose-frames", "after_motion = 4\ndirection = \"from-drive\""));
  expect_told(scene, "tilt", "the drive has stopped telling where it is");
  scene.expect_stop_on_path(all);
}

// docs/faults.md 20
TEST(CanFault, WhenADriveDoesNotHearTheOthersStopOnThePath) {
  const BusScene scene =
      scene_with(fault("tilt", "lose-frames", "after_motion = 4\ndirection = \"to-drive\""));
  expect_told(scene, "tilt", "");
  scene.expect_stop_on_path({"slide", "pan"});
  EXPECT_NEAR(scene.last_velocity("tilt"), 0, 1) << "by its own watchdog";
}

// docs/faults.md 21
TEST(CanFault, ALostHeartbeatStopsAllOnThePath) {
  // A little earlier than the others, for it is found 100 to 150 ms later, where the tilt is nearly at its
  // end.
  const BusScene scene = scene_with(fault("slide", "lose-heartbeat", "after_motion = 3.9"));
  expect_told(scene, "slide", "the heartbeat of the drive has stopped");
  scene.expect_stop_on_path(all);
  scene.expect_quiet();
}

// docs/faults.md 22
TEST(CanFault, WithoutTheFirstHeartbeatNothingIsSwitchedOn) {
  const BusScene scene = scene_with(fault("pan", "lose-heartbeat", "at = 0"));
  expect_refused_at_arming(scene, "pan", "the first heartbeat of the drive never came");
}

// docs/faults.md 23
TEST(CanFault, AnEmergencyStopsTheOthersOnThePathAndIsSaidInWords) {
  const BusScene scene = scene_with(fault("tilt", "emergency", "after_motion = 4\ncode = 0x2310"));
  expect_told(scene, "tilt", "");
  EXPECT_THAT(scene.run.out, HasSubstr("EMCY 2310, "));
  scene.expect_stop_on_path({"slide", "pan"});
  EXPECT_NEAR(scene.last_velocity("tilt"), 0, 1) << "by the ramp of its fault";
  scene.expect_let_go({"tilt"});
}

// docs/faults.md 24
TEST(CanFault, ADriveThatStartsAnewStopsTheOthersOnThePath) {
  const BusScene scene = scene_with(fault("tilt", "reboot"));
  expect_told(scene, "tilt", "the drive has started anew; look at its supply, then find its reference again");
  scene.expect_stop_on_path({"slide", "pan"});
  scene.expect_quiet();
}

// docs/faults.md 25
TEST(CanFault, AnAxisThatSticksStopsTheOthersOnThePath) {
  const BusScene scene = scene_with(fault("tilt", "stick"));
  EXPECT_EQ(scene.run.status, 4) << scene.run.err;
  EXPECT_THAT(scene.run.out, HasSubstr("axis \"tilt\""));
  scene.expect_stop_on_path({"slide", "pan"}, 2.5);
  EXPECT_NE(scene.last_state("tilt"), "operation enabled");
}

// docs/faults.md 25
TEST(CanFault, ADriveThatDoesNotWatchItsFollowingErrorIsRefused) {
  expect_refused_at_arming(scene_with(fault("pan", "no-window", "")), "pan",
                           "the drive does not watch its following error");
}

// docs/faults.md 26
TEST(CanFault, ADriveThatIgnoresItsTargetMakesTimeStandStillForAll) {
  const BusScene scene = scene_with(fault("slide", "ignore-target"));
  expect_told(scene, "slide", "the drive does not follow its target (statusword bit 12)");
  scene.expect_stop_on_path(all);
  scene.expect_quiet();
}

// docs/faults.md 26. Bit 12 comes back, and nothing catches up.
TEST(CanFault, ADriveThatIgnoredItsTargetForAWhileDoesNotCatchUp) {
  // Of the slow axis: a fast one would be beyond its window for the following error by then, or nearly.
  const BusScene scene = scene_with(fault("tilt", "ignore-target", "after_motion = 4\nfor = 0.04"));
  expect_told(scene, "tilt", "the drive does not follow its target (statusword bit 12)");
  scene.expect_stop_on_path(all);
}

// docs/faults.md 26
TEST(CanFault, ADriveInAnotherModeStopsAllOnThePath) {
  const BusScene scene = scene_with(fault("pan", "wrong-mode", "after_motion = 4\nmode = 1"));
  expect_told(scene, "pan", "the drive is in another mode of operation than it was told");
  scene.expect_stop_on_path(all);
  scene.expect_quiet();
}

// docs/faults.md 27
TEST(CanFault, AnAxisThatIsNotWhereTheMoveStartsIsAnErrorAndNothingMoves) {
  const BusScene scene(BusSceneOptions{.standing = {{"slide", 60}, {"pan", -50}, {"tilt", -4}}});
  EXPECT_EQ(scene.run.status, 1) << scene.run.out;
  EXPECT_THAT(scene.run.err,
              HasSubstr("axis \"pan\" of the rig is not where the move starts; bring it there, "
                        "or agree to let it go there slowly (--yes)"));
  EXPECT_FALSE(scene.targets("pan").empty()) << "it was switched on, to know where it is";
  scene.expect_no_motion();
  scene.expect_quiet();
}

// docs/faults.md 28. Pressed in motion, moved while it is off, released: the next run sees where it is.
TEST(CanFault, AReleasedEmergencyStopResumesNothingAndPositionsAreReadAgain) {
  const BusScene scene(BusSceneOptions{
      .during = "sleep 5; kill -USR1 $run; sleep 3; kill -USR2 $run || true; sleep 1; wait $run || true; "
                "second=0; " +
                BusScene::run_command() + " || second=$?; echo second $second",
      .faults = fault("tilt", "move-by-hand", "after_motion = 6.5\nto = 20")});
  EXPECT_EQ(scene.run.status, 4) << scene.run.err;
  EXPECT_THAT(scene.run.out, HasSubstr("the emergency stop is pressed"));
  EXPECT_THAT(scene.run.out, HasSubstr("second 1"));
  EXPECT_THAT(scene.run.err, HasSubstr("of the rig is not where the move starts"));
  for (const std::string& axis : all) {
    std::vector<double> since;
    for (const BusScene::Target& target : scene.targets(axis)) {
      if (target.at_ns >= scene.fault_ns()) since.push_back(target.counts);
    }
    ASSERT_FALSE(since.empty()) << axis << " was not switched on again";
    EXPECT_THAT(since, testing::Each(since.front())) << axis << " was sent away from where it stood";
    if (axis == "tilt") {
      EXPECT_NEAR(since.front(), 20 * 4000, 1) << "it was moved by hand";
    }
  }
  scene.expect_let_go();
}

// One drive does not take the order to switch off. It is named, and its own watchdogs see to it.
TEST(CanFault, ADriveThatDoesNotSwitchOffIsNamedAndKeepsItsWatchdogs) {
  const BusScene scene = scene_with(fault("pan", "stay-on"));
  expect_told(scene, "pan", "the drive did not tell that it is switched off; take its power away");
  EXPECT_THAT(scene.emergencies("pan"), testing::Not(testing::IsEmpty())) << "its watchdog has ended it";
  EXPECT_EQ(scene.last_state("pan"), "switch-on disabled");
  for (const char* axis : {"slide", "tilt"}) {
    EXPECT_THAT(scene.emergencies(axis), testing::IsEmpty()) << axis;
    EXPECT_EQ(scene.last_state(axis), "switch-on disabled") << axis;
  }
}

// docs/faults.md 29
TEST(CanFault, ADriveThatWouldRunOnAloneIsRefused) {
  expect_refused_at_arming(scene_with(fault("slide", "no-watchdog", "")), "slide",
                           "the drive would run on if this program died");
}

/// A drive whose object has this value and cannot be told another.
std::string fixed(std::string_view axis, unsigned index, unsigned sub, unsigned value) {
  return fault(axis, "fixed-object", fmt::format("object = {}\nsub = {}\nvalue = {}", index, sub, value));
}

// docs/faults.md 29. Its setpoint timeout is in order; that does not notice a host that hangs while it sends.
TEST(CanFault, ADriveWhoseHeartbeatConsumerCannotBeSetIsRefused) {
  const BusScene scene = scene_with(fixed("slide", 0x1016, 1, 0));
  expect_refused_at_arming(scene, "slide", "the drive would run on if this program died");
  EXPECT_THAT(scene.run.out,
              HasSubstr("(object 1016h:1 is 0 (0h), not 8323192 (7F0078h); 0601 0002h: the object "
                        "can only be read)"));
}

// docs/faults.md 29
TEST(CanFault, ADriveThatDoesNotSayWhatItDoesWithoutThisProgramIsRefused) {
  const BusScene scene = scene_with(fault("pan", "no-object", "object = 0x6007"));
  expect_refused_at_arming(scene, "pan", "the drive does not say what it does if this program dies");
  EXPECT_THAT(scene.run.out, HasSubstr("write on_host_lost = \"stops\" for the axis"));
}

TEST(CanFault, ADriveThatFallsSilentWhileItIsSetUpIsSaidToBeSilent) {
  const BusScene scene = scene_with(fault("pan", "silent-object", "object = 0x605C"));
  expect_refused_at_arming(scene, "pan", "the drive did not answer while it was set up");
  EXPECT_THAT(scene.run.out, HasSubstr("(object 605Ch:0; 0504 0000h: no answer in time)"));
}

// What the profile does not ask for may be missing, and what is right already need not be written.
TEST(CanFault, ADriveWithFewerObjectsPlaysTheWholeMove) {
  std::string faults = fixed("slide", 0x6085, 0, 1'200'000) + fixed("pan", 0x1006, 0, 0) +
                       fixed("tilt", 0x605A, 0, 6) + fixed("pan", 0x6007, 0, 1);
  for (const int index : {0x605A, 0x605B, 0x605C, 0x605D}) {
    faults += fault("pan", "no-object", fmt::format("object = {}", index));
  }
  const BusScene scene = scene_with(faults);
  EXPECT_EQ(scene.run.status, 0) << scene.run.out << scene.run.err;
}

// docs/faults.md 23
TEST(CanFault, AFaultFromBeforeTheRunIsToldByItsCode) {
  const BusScene scene = scene_with(fault("pan", "emergency", "code = 0x7305\nat = 0"));
  EXPECT_EQ(scene.run.status, 4) << scene.run.err;
  EXPECT_THAT(scene.run.out,
              HasSubstr("axis \"pan\": the fault of the drive cannot be reset (error 7305h, the "
                        "incremental encoder); remove its cause"));
  scene.expect_no_motion();
}

// docs/faults.md 50
TEST(CanFault, TwoDevicesWithOneNumberAreFoundBeforeEitherHasPower) {
  const TemporaryFolder folder;
  const std::string err = (folder.path() / "second.txt").string();
  const BusScene scene({.who = "inbetween sim-drives --rig '" + BusScene::rig() + "' 2>" + err +
                               " & second=$!\nuntil_true grep -q power " + err + "\n"});
  EXPECT_EQ(scene.run.status, 4) << scene.run.err;
  EXPECT_THAT(scene.run.out, HasSubstr("two devices answer to its node number; give each device"));
  scene.expect_no_motion();
}

}  // namespace can_fault_test
}  // namespace inbetween
