#include "host_tools/rig/fault_script.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>

#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace fault_script_test {

using Kind = DriveTrouble::Kind;

const RigFile& rig() {
  static const RigFile parsed = parse_rig(
      rig_text(
          {{.name = "lamp", .unit = "unit"}, {.name = "pan", .unit = "deg", .drive = cia402_text(1, -1000)}},
          {.rate_hz = 250, .more = bus_can0}),
      "rig.toml");
  return parsed;
}

FaultScript parse(std::string_view text, const std::string& file) {
  return parse_fault_script(text, file, rig());
}

std::string fault(std::string_view what, std::string_view more) {
  return fmt::format("[[fault]]\naxis = \"pan\"\nwhat = \"{}\"\n{}\n", what, more);
}

ScriptedFault only(std::string_view what, std::string_view more) {
  const FaultScript script = parse(fault(what, more), "file.toml");
  EXPECT_EQ(script.faults.size(), 1U);
  return script.faults.front();
}

void refused(std::string_view what, std::string_view more, std::initializer_list<std::string_view> words) {
  expect_refused(parse, fault(what, more), words);
}

TEST(FaultScript, ARunawayRunsInUnitsOfItsAxisAndAnotherScaleNeedsADriveWithTwo) {
  EXPECT_EQ(only("run-away", "at = 1\nspeed = 60").trouble.place, -60'000);
  refused("other-scale", "ratio = @1.25", {"ratio", "needs an axis with a cubemars drive"});
}

TEST(FaultScript, EveryWordIsATroubleOfTheDrive) {
  const std::map<std::string, std::pair<std::string, Kind>> words{
      {"short-frames", {"at = 1", Kind::shorten}},
      {"duplicate-frames", {"at = 1", Kind::duplicate}},
      {"lose-heartbeat", {"at = 1", Kind::lose_heartbeat}},
      {"emergency", {"at = 1\ncode = 1", Kind::emergency}},
      {"stick", {"at = 1", Kind::stick}},
      {"run-away", {"at = 1\nspeed = 60", Kind::run_away}},
      {"blind", {"at = 1", Kind::blind}},
      {"reboot", {"at = 1", Kind::reboot}},
      {"move-by-hand", {"at = 1\nto = 2", Kind::put_by_hand}},
      {"ignore-target", {"at = 1", Kind::ignore_target}},
      {"wrong-mode", {"at = 1\nmode = 1", Kind::wrong_mode}},
      {"foreign-sender", {"at = 1", Kind::foreign_sender}},
      {"flood", {"at = 1\nframes_per_s = 1", Kind::flood}},
      {"stay-on", {"at = 1", Kind::stay_on}},
      {"switched-off", {"at = 1", Kind::switched_off}},
      {"no-home", {"at = 1", Kind::no_home}},
      {"homing-error", {"at = 1", Kind::homing_error}},
      {"no-window", {"", Kind::no_window}},
      {"no-watchdog", {"", Kind::no_watchdog}},
      {"no-object", {"object = 0x6007", Kind::no_object}},
      {"fixed-object", {"object = 0x6007\nvalue = 0", Kind::fixed_object}},
      {"silent-object", {"object = 0x6007", Kind::silent_object}},
  };
  for (const auto& [word, of] : words) {
    const ScriptedFault fault = only(word, of.first);
    EXPECT_EQ(fault.trouble.kind, of.second) << word;
    EXPECT_EQ(fault.what, word);
    EXPECT_EQ(fault.axis, 1U);
    EXPECT_FALSE(fault.is_after_motion);
    EXPECT_EQ(fault.trouble.at_ns, of.first.starts_with("at") ? 1'000'000'000 : 0);
  }
  const std::string from = "at = 1\ndirection = \"from-drive\"";
  EXPECT_EQ(only("lose-frames", from).trouble.kind, Kind::lose_sent);
  EXPECT_EQ(only("lose-frames", with(from, "from", "to")).trouble.kind, Kind::lose_heard);
}

TEST(FaultScript, TimesAreNanosecondsAndPositionsCounts) {
  const ScriptedFault stick = only("stick", "after_motion = 2.5\nfor = 0.1");
  EXPECT_TRUE(stick.is_after_motion);
  EXPECT_EQ(stick.trouble.at_ns, 2'500'000'000);
  EXPECT_EQ(stick.trouble.for_ns, 100'000'000);
  EXPECT_EQ(only("stick", "at = 0").trouble.for_ns, DriveTrouble{}.for_ns) << "for good";
  EXPECT_EQ(only("short-frames", "at = 0\ncount = 3").trouble.frames, 3);
  EXPECT_EQ(only("short-frames", "at = 0").trouble.frames, DriveTrouble{}.frames);
  EXPECT_EQ(only("move-by-hand", "at = 0\nto = 12.5").trouble.place, -12'500);
  EXPECT_EQ(only("emergency", "at = 0\ncode = 0x2310").trouble.value, 0x2310);
  EXPECT_EQ(only("wrong-mode", "at = 0\nmode = -1").trouble.value, -1);
  EXPECT_EQ(only("flood", "at = 0\nframes_per_s = 5000").trouble.value, 5000);
}

TEST(FaultScript, FaultsAreInTheOrderOfTheFile) {
  const FaultScript script =
      parse(fault("stick", "at = 2") + fault("reboot", "at = 1") + fault("stick", "at = 0"), "file.toml");
  ASSERT_EQ(script.faults.size(), 3U);
  EXPECT_EQ(script.faults[0].what, "stick");
  EXPECT_EQ(script.faults[1].what, "reboot");
  EXPECT_EQ(script.path, "file.toml");
}

TEST(FaultScript, AnEmptyFile) {
  expect_refused(parse, "@", {"the file is empty", "[[fault]]"});
}

TEST(FaultScript, NoFault) {
  expect_refused(parse, "fault = @[]", {"fault is empty"});
}

TEST(FaultScript, ASingleTable) {
  expect_refused(parse, "@[fault]\naxis = \"pan\"", {"fault is a single table"});
}

TEST(FaultScript, AnUnknownField) {
  expect_refused(parse, "@faults = 1", {"did you mean \"fault\"?"});
  refused("stick", "at = 1\n@axes = 1", {"a fault has no field \"axes\"", "did you mean \"axis\"?"});
}

TEST(FaultScript, AnUnknownWord) {
  expect_refused(parse, "[[fault]]\naxis = \"pan\"\nwhat = @\"sticks\"\nat = 1",
                 {"what is \"sticks\"", "\"stick\"", "or \"silent-object\""});
  expect_refused(parse, "@[[fault]]\naxis = \"pan\"\nat = 1", {"a fault has no what"});
}

TEST(FaultScript, AnAxisThatTheRigDoesNotHave) {
  const std::string stick = "[[fault]]\nwhat = \"stick\"\nat = 1\n";
  expect_refused(parse, stick + "axis = @\"tilt\"", {"axis is \"tilt\"", "its axes are \"lamp\", \"pan\""});
  expect_refused(parse, "@" + stick, {"a fault has no axis"});
}

TEST(FaultScript, AnAxisWhoseDriveIsNotSimulatedWithIt) {
  expect_refused(parse, "[[fault]]\nwhat = \"stick\"\nat = 1\naxis = @\"lamp\"",
                 {"axis is \"lamp\", whose drive is not simulated", "with a CAN drive"});
}

TEST(FaultScript, NoTime) {
  expect_refused(parse, "@" + fault("stick", ""), {"a fault has no at; add after_motion = 2.0"});
}

TEST(FaultScript, TwoTimes) {
  refused("stick", "at = 1\nafter_motion = @1", {"beside at", "one of the two"});
}

TEST(FaultScript, ATimeForWhatADriveIs) {
  refused("no-window", "at = @1", {"at does not belong to what = \"no-window\"; leave it out"});
  refused("no-watchdog", "after_motion = @1", {"does not belong"});
}

TEST(FaultScript, ATimeThatIsNone) {
  refused("stick", "at = @-1", {"at is -1", "from 0 to 86400"});
  refused("stick", "after_motion = @nan", {"after_motion is nan"});
  refused("stick", "at = 0\nfor = @inf", {"for is inf"});
  refused("stick", "at = 0\nfor = @0", {"for is 0", "leave it out"});
  refused("stick", "at = 0\nfor = @1e-12", {"for is 0", "leave it out"});
}

TEST(FaultScript, AnExtentOfWhatHappensOnce) {
  refused("reboot", "at = 0\nfor = @1", {"for does not belong"});
  refused("stick", "at = 0\ncount = @1", {"count does not belong"});
}

TEST(FaultScript, TwoExtents) {
  refused("short-frames", "at = 0\nfor = 1\ncount = @2", {"beside for", "one of the two"});
}

TEST(FaultScript, ACountOutOfRange) {
  refused("short-frames", "at = 0\ncount = @0", {"count is 0", "from 1 to 1000000"});
}

TEST(FaultScript, AFieldOfAnotherFault) {
  for (const char* field :
       {"direction = @\"to-drive\"", "code = @1", "to = @1", "mode = @1", "frames_per_s = @1"}) {
    refused("stick", fmt::format("at = 0\n{}", field), {"does not belong to what = \"stick\""});
  }
}

TEST(FaultScript, AFieldThatIsMissing) {
  const auto has_no = [](std::string_view what, std::string_view field) {
    expect_refused(parse, "@" + fault(what, "at = 0"), {fmt::format("a fault has no {}; add", field)});
  };
  has_no("lose-frames", "direction");
  has_no("emergency", "code");
  has_no("move-by-hand", "to");
  has_no("wrong-mode", "mode");
  has_no("flood", "frames_per_s");
}

TEST(FaultScript, ADirectionThatIsNone) {
  refused("lose-frames", "at = 0\ndirection = @\"both\"", {"\"from-drive\" or \"to-drive\""});
}

TEST(FaultScript, ACodeOutOfRange) {
  refused("emergency", "at = 0\ncode = @0", {"code is 0"});
  refused("emergency", "at = 0\ncode = @0x10000", {"code is 65536"});
}

TEST(FaultScript, APositionThatTheDriveCannotCountTo) {
  refused("move-by-hand", "at = 0\nto = @3e6", {"-3000000000 counts of the drive", "within 2147483647"});
}

TEST(FaultScript, AModeOutOfRange) {
  refused("wrong-mode", "at = 0\nmode = @128", {"mode is 128"});
}

TEST(FaultScript, AnObjectHasItsAddressAndAValueThatFitsIntoIt) {
  const DriveTrouble trouble = only("fixed-object", "object = 0x1016\nsub = 1\nvalue = 0xFFFFFFFF").trouble;
  EXPECT_EQ(trouble.object, (can::ObjectAddress{.index = 0x1016, .sub = 1}));
  EXPECT_EQ(static_cast<std::uint32_t>(trouble.value), 0xFFFFFFFF);
  EXPECT_EQ(only("no-object", "object = 0x6007").trouble.object, (can::ObjectAddress{.index = 0x6007}));
  refused("no-object", "object = @0x6008", {"6008h, which the simulated drive does not have with sub 0"});
  refused("no-object", "object = @0x6007\nsub = 1", {"6007h", "with sub 1"});
  refused("fixed-object", "object = 0x6007\nvalue = @65536", {"value is 65536", "from 0 to 65535"});
  refused("no-object", "object = 0x6007\nvalue = @1", {"value does not belong to what = \"no-object\""});
  refused("stick", "at = 0\nobject = @0x6007", {"object does not belong"});
  expect_refused(parse, "@" + fault("silent-object", ""), {"a fault has no object; add"});
  expect_refused(parse, "@" + fault("fixed-object", "object = 0x6007"), {"a fault has no value; add"});
}

TEST(FaultScript, AFloodOutOfRange) {
  refused("flood", "at = 0\nframes_per_s = @0", {"frames_per_s is 0"});
  refused("flood", "at = 0\nframes_per_s = @100001", {"frames_per_s is 100001"});
}

TEST(FaultScript, MoreFaultsThanAllowed) {
  std::string text;
  for (int i = 0; i < 1001; ++i) text += fault("stick", "at = 0");
  expect_refused(parse, "@" + text, {"1001", "at most 1000"});
}

TEST(FaultScript, AFileThatIsNotThere) {
  EXPECT_THROW(read_fault_script("/nowhere/faults.toml", rig()), InputError);
}

}  // namespace fault_script_test
}  // namespace inbetween
