// What a rig file says about its axes without power and without this program, and what is refused for it
// before anything is switched on.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "host_tools/rig/rig_drives.hpp"
#include "host_tools/rig/simulated_hardware.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace rig_power_test {

using testing::HasSubstr;
using testing::StartsWith;

std::string rig_text(std::string_view axis_fields, std::string_view drive_fields = "") {
  return inbetween::rig_text(
      {axis_text("lift", "mm", {0, 500}, {.velocity = 100, .acceleration = 200}, std::string(axis_fields),
                 cia402_text(1, -1000).append(drive_fields))},
      {.name = "crane", .rate_hz = 250, .more = bus_can0});
}

constexpr std::string_view of_cia402 = R"(type = "cia402", bus = "can0", node = 1, counts_per_unit = -1000)";
constexpr std::string_view of_steps =
    R"(type = "step-dir", chip = "io", step = 1, dir = 2, steps_per_unit = 10)";

RigFile rig_of(std::string_view axis_fields, std::string_view drive_fields = "") {
  return parse_rig(rig_text(axis_fields, drive_fields), "rig.toml");
}

TEST(RigPower, AnAxisSaysWhatItDoesWithoutPower) {
  EXPECT_TRUE(rig_of("unpowered = \"holds\"").axes[0].unpowered.value().holds);
  EXPECT_FALSE(rig_of("unpowered = \"falls\"").axes[0].unpowered.value().holds);
  EXPECT_FALSE(rig_of("").axes[0].unpowered);
  expect_refused(parse_rig, rig_text("unpowered = @\"stays\""), {"\"stays\"", "\"holds\" or \"falls\""});
  expect_refused(parse_rig, rig_text("unpowered = @true"), {"unpowered is"});
}

TEST(RigPower, ACia402AxisSaysThatItMayRollOutAndThatItsManualWasRead) {
  const RigFile plain = rig_of("");
  EXPECT_FALSE(plain.axes[0].coasts);
  EXPECT_FALSE(plain.axes[0].stops_without_host);
  const RigFile rig = rig_of("coasts = true\non_host_lost = \"stops\"");
  const can::Cia402Setup setup = settings_of(rig.axes[0], rig.rate_hz).setup;
  EXPECT_TRUE(setup.coasts);
  EXPECT_TRUE(setup.stops_without_host);
  expect_refused(parse_rig, rig_text("coasts = @1"), {"coasts is"});
  expect_refused(parse_rig, rig_text("on_host_lost = @\"runs on\""), {"write \"stops\""});
  for (const char* field : {"coasts = @false", "on_host_lost = @\"stops\""}) {
    expect_refused(parse_rig, with(rig_text(field), std::string(of_cia402), std::string(of_steps)),
                   {"belongs to a cia402 drive only; leave it out"});
  }
}

TEST(RigPower, TheDriveBrakesAsHardAsTheRigDoes) {
  const auto told = [](std::string_view axis_fields, std::string_view drive_fields = "") {
    const RigFile rig = rig_of(axis_fields, drive_fields);
    return settings_of(rig.axes[0], rig.rate_hz).setup.quick_stop_deceleration;
  };
  EXPECT_EQ(told(""), 300'000U) << "1.5 times max_acceleration";
  EXPECT_EQ(told("stop_acceleration = 250.5"), 250'500U);
  EXPECT_EQ(told("stop_acceleration = 250", ", deceleration_per_unit = 0.3"), 75U) << "in rpm/s, say";
  expect_refused(parse_rig, rig_text("stop_acceleration = 250", ", deceleration_per_unit = @0.001"),
                 {"so that a stop by 250 mm/s^2 is 0 units of the drive", "6085 takes 1 to 4294967295"});
  expect_refused(parse_rig, with(rig_text("stop_acceleration = 4294968"), "unit = -1000", "unit = @-1000"),
                 {"is -1000, so that a stop by 4294968 mm/s^2 is 4294968000 units"});
  expect_refused(parse_rig, rig_text("", ", deceleration_per_unit = @0"), {"above 0"});
}

/// `run` on a real rig, of which this machine has nothing.
ProgramRun run_with(const std::string& text) {
  const TemporaryFile move("move.toml", R"(name = "up"
fps = 25
frames = 100
[[track]]
axes = ["lift"]
keys = [ { at = [0] }, { at = [10] } ]
speed = [0, 0, 10, 10, 0, 0]
)");
  const TemporaryFile rig("rig.toml", text + "reference = \"drive\"\n");
  return run_program({"run", move.path().string(), "--rig", rig.path().string()});
}

TEST(RigPower, AnAxisThatFallsIsRefusedBeforeAnythingIsOpened) {
  const ProgramRun run = run_with(rig_text("unpowered = \"falls\""));
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, HasSubstr(":12:13: error: axis \"lift\" falls without power"));
  EXPECT_THAT(run.err,
              HasSubstr("a brake on the brake output of its drive, a self-locking gear or a counterweight"));
}

TEST(RigPower, AnAxisThatDoesNotSayIsRefusedInALineThatShowsWhatToWrite) {
  for (const std::string_view drive : {of_cia402, of_steps}) {
    const RigFile rig = parse_rig(with(rig_text(""), std::string(of_cia402), std::string(drive)), "rig.toml");
    EXPECT_THAT(
        [&] { refuse_falling_axes(rig); },
        testing::ThrowsMessage<InputError>(testing::AllOf(
            StartsWith("rig.toml:5:1: error: axis \"lift\" does not say"),
            HasSubstr("write unpowered = \"holds\" if it keeps its place"), testing::Not(HasSubstr("\n")))));
  }
  const ProgramRun run = run_with(rig_text(""));
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, HasSubstr("does not say what it does without power"));
}

TEST(RigPower, AnAxisThatHoldsIsNotRefused) {
  EXPECT_NO_THROW(refuse_falling_axes(rig_of("unpowered = \"holds\"")));
  EXPECT_THAT(run_with(rig_text("unpowered = \"holds\"")).err, HasSubstr("rig.toml:3:1: error:"))
      << "its bus is opened";
}

TEST(RigPower, ASimulatedRigNeedNotSay) {
  for (const char* fields : {"", "unpowered = \"falls\""}) {
    const RigFile rig = rig_of(fields);
    SimulatedHardware hardware(rig, {0});
    EXPECT_NO_THROW(RigDrives(rig, hardware)) << fields;
  }
}

// --- why a drive could not be set up, in words

TEST(SetupRefusal, SaysTheCodeAndTheWordsOfTheDrive) {
  EXPECT_EQ(
      words_of(can::SetupRefusal{
          .object = {.index = 0x6007}, .expected = 3, .found = 2, .abort_code = can::abort_device_state}),
      "object 6007h:0 is 2 (2h), not 3 (3h); 0800 0022h: the value cannot be stored in the present state "
      "of the device");
  EXPECT_EQ(words_of(can::SetupRefusal{.object = {.index = 0x6085}, .expected = 1'200'000, .found = 0xFFFF}),
            "object 6085h:0 is 65535 (FFFFh), not 1200000 (124F80h)");
}

TEST(SetupRefusal, SaysNoValueThatTheDriveHasNotGiven) {
  EXPECT_EQ(words_of(can::SetupRefusal{
                .object = {.index = 0x6060}, .expected = 8, .abort_code = can::abort_no_object}),
            "object 6060h:0; 0602 0000h: the device has no such object");
  EXPECT_EQ(words_of(can::SetupRefusal{
                .object = {.index = 0x1016, .sub = 1}, .expected = 1, .abort_code = can::abort_timeout}),
            "object 1016h:1; 0504 0000h: no answer in time");
}

}  // namespace rig_power_test
}  // namespace inbetween
