#include "host_tools/rig_model/rig_file.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <variant>

#include "tests/support/refused_text.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace rig_file_test {

using testing::HasSubstr;

constexpr const char* slider = R"(name = "slider with pan head"
rate_hz = 250

[bus.can0]
bitrate = 1_000_000

[[axis]]
name = "track"
unit = "mm"
min = 0.0
max = 1500.0
max_velocity = 400.0
max_acceleration = 800.0
max_jerk = 8000
drive = { type = "cia402", bus = "can0", node = 1, counts_per_unit = 1000.0 }

[[axis]]
name = "pan"
unit = "deg"
min = -90.0
max = 90.0
max_velocity = 60.0
max_acceleration = 120.0
drive = { type = "step-dir", chip = "pinctrl-bcm2711", step = 17, dir = "GPIO27", steps_per_unit = -88.888889 }
)";

constexpr const char* mixed = R"(name = "one of each"
rate_hz = 300
[bus.can1]
bitrate = 500_000
data_bitrate = 2_000_000
[bus.can0]
bitrate = 1_000_000
[[axis]]
name = "a"
unit = "m"
min = -1
max = 1
max_velocity = 1
max_acceleration = 2
max_jerk = 3
max_acceleration_step = 4
stop_acceleration = 5
stop_jerk = 6
drive = { type = "odrive", bus = "can0", node = 0, turns_per_unit = 12.5, firmware = "0.5" }
[[axis]]
name = "b"
unit = "turn"
min = -1
max = 1
max_velocity = 1
max_acceleration = 1
drive = { type = "moteus", bus = "can1", node = 126, turns_per_unit = 1 }
[[axis]]
name = "c"
unit = "rad"
min = -1
max = 1
max_velocity = 1
max_acceleration = 1
drive = { type = "pipe", path = "/run/puppet", counts_per_unit = 300 }
[[axis]]
name = "d"
unit = "unit"
min = -1
max = 1
max_velocity = 1
max_acceleration = 1
drive = { type = "step-dir", chip = "expander", step = "STEP", dir = 1, enable = 0, steps_per_unit = 2 }
)";

void expect_rig_refused(const std::string& marked, std::initializer_list<std::string_view> words) {
  expect_refused([](std::string_view text, const std::string& file) { parse_rig(text, file); }, marked,
                 words);
}

/// The slider with one thing changed; the mark @ is in `to`.
void expect_change_refused(std::string_view from, std::string_view to,
                           std::initializer_list<std::string_view> words) {
  expect_rig_refused(with(slider, from, to), words);
}

void expect_mixed_change_refused(std::string_view from, std::string_view to,
                                 std::initializer_list<std::string_view> words) {
  expect_rig_refused(with(mixed, from, to), words);
}

std::string error_of_file(const std::filesystem::path& path) {
  try {
    read_rig_file(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

// ---- what is accepted

TEST(RigFile, ReadsARigWithItsLimitsAndDrives) {
  const RigFile rig = parse_rig(slider, "slider.toml");
  EXPECT_EQ(rig.path, "slider.toml");
  EXPECT_EQ(rig.name, "slider with pan head");
  EXPECT_EQ(rig.rate_hz, 250);
  ASSERT_EQ(rig.buses.size(), 1U);
  EXPECT_EQ(rig.buses[0].name, "can0");
  EXPECT_EQ(rig.buses[0].bitrate, 1'000'000);
  EXPECT_EQ(to_string(rig.buses[0].place), "slider.toml:4:1");

  ASSERT_EQ(rig.axes.size(), 2U);
  const RigAxis& track = rig.axes[0];
  EXPECT_EQ(track.name, "track");
  EXPECT_EQ(to_string(track.unit), "mm");
  EXPECT_EQ(track.min, 0);
  EXPECT_EQ(track.max, 1500);
  EXPECT_EQ(track.max_velocity, 400);
  EXPECT_EQ(track.max_acceleration, 800);
  EXPECT_EQ(track.max_jerk, 8000);
  EXPECT_FALSE(track.max_acceleration_step.has_value());
  EXPECT_FALSE(track.stop_acceleration.has_value());
  EXPECT_FALSE(track.stop_jerk.has_value());
  EXPECT_EQ(to_string(track.place), "slider.toml:7:1");
  const auto& servo = std::get<Cia402Drive>(track.drive);
  EXPECT_EQ(servo.bus, "can0");
  EXPECT_EQ(servo.node, 1);
  EXPECT_EQ(servo.counts_per_unit, 1000);

  const auto& stepper = std::get<StepDirDrive>(rig.axes[1].drive);
  EXPECT_EQ(stepper.chip, "pinctrl-bcm2711");
  EXPECT_EQ(stepper.step, GpioLine(17));
  EXPECT_EQ(stepper.dir, GpioLine("GPIO27"));
  EXPECT_FALSE(stepper.enable.has_value());
  EXPECT_EQ(stepper.steps_per_unit, -88.888889);
}

TEST(RigFile, ReadsEveryLimitAndEveryKindOfDrive) {
  const RigFile rig = parse_rig(mixed, "mixed.toml");
  ASSERT_EQ(rig.buses.size(), 2U);
  EXPECT_EQ(rig.buses[0].name, "can0");
  EXPECT_EQ(rig.buses[1].bitrate, 500'000);
  ASSERT_EQ(rig.axes.size(), 4U);

  EXPECT_EQ(rig.axes[0].unit, AxisUnit::m);
  EXPECT_EQ(rig.axes[0].max_acceleration_step, 4);
  EXPECT_EQ(rig.axes[0].stop_acceleration, 5);
  EXPECT_EQ(rig.axes[0].stop_jerk, 6);
  EXPECT_EQ(std::get<OdriveDrive>(rig.axes[0].drive).bus, "can0");
  EXPECT_EQ(std::get<OdriveDrive>(rig.axes[0].drive).node, 0);
  EXPECT_EQ(std::get<OdriveDrive>(rig.axes[0].drive).turns_per_unit, 12.5);
  EXPECT_EQ(std::get<OdriveDrive>(rig.axes[0].drive).firmware, OdriveFirmware::v0_5);
  EXPECT_EQ(std::get<OdriveDrive>(rig.axes[0].drive).follow.max_following_error, 0.1)
      << "a tenth of a second";

  EXPECT_EQ(rig.axes[1].unit, AxisUnit::turn);
  EXPECT_EQ(std::get<MoteusDrive>(rig.axes[1].drive).bus, "can1");
  EXPECT_EQ(std::get<MoteusDrive>(rig.axes[1].drive).node, 126);
  EXPECT_EQ(std::get<MoteusDrive>(rig.axes[1].drive).turns_per_unit, 1);
  EXPECT_EQ(std::get<MoteusDrive>(rig.axes[1].drive).follow.max_following_error, 0.1)
      << "a tenth of a second";
  EXPECT_EQ(bus_named(rig, "can1").data_bitrate, 2'000'000);
  EXPECT_EQ(bus_named(rig, "can0").data_bitrate, std::nullopt);

  EXPECT_EQ(rig.axes[2].unit, AxisUnit::rad);
  EXPECT_EQ(std::get<PipeDrive>(rig.axes[2].drive).path, "/run/puppet");
  EXPECT_EQ(std::get<PipeDrive>(rig.axes[2].drive).counts_per_unit, 300);

  EXPECT_EQ(rig.axes[3].unit, AxisUnit::unit);
  EXPECT_EQ(std::get<StepDirDrive>(rig.axes[3].drive).step, GpioLine("STEP"));
  EXPECT_EQ(std::get<StepDirDrive>(rig.axes[3].drive).enable, GpioLine(0));
}

TEST(RigFile, AnEnumeratorOfAUnitReadsAsInTheFile) {
  for (const char* name : {"mm", "m", "deg", "rad", "turn", "unit"}) {
    const RigFile rig = parse_rig(with(slider, "\"mm\"", fmt::format("\"{}\"", name)), "r");
    EXPECT_EQ(to_string(rig.axes.at(0).unit), name);
  }
}

TEST(RigFile, ReadsAFileByItsPath) {
  const TemporaryFile file("slider.toml", slider);
  EXPECT_EQ(read_rig_file(file.path()).axes.at(1).place.file, file.path().string());
}

TEST(RigFile, OneChipsLinesAreNotAnothers) {
  const std::string other_chip =
      with(mixed, "{ type = \"pipe\", path = \"/run/puppet\", counts_per_unit = 300 }",
           "{ type = \"step-dir\", chip = \"other\", step = \"STEP\", dir = 1, steps_per_unit = 2 }");
  EXPECT_EQ(parse_rig(other_chip, "r").axes.size(), 4U);
}

TEST(RigFile, OneBusesNodesAreNotAnothers) {
  EXPECT_EQ(parse_rig(with(with(mixed, "node = 0", "node = 9"), "node = 126", "node = 9"), "r").axes.size(),
            4U);
}

// ---- the file as a whole

TEST(RigFile, AMissingFileAndADirectoryAreNamed) {
  EXPECT_EQ(error_of_file("no/such/rig.toml"),
            "no/such/rig.toml: error: there is no such file; check the path");
  const TemporaryFolder folder;
  EXPECT_THAT(error_of_file(folder.path()), HasSubstr("is a directory"));
}

TEST(RigFile, AHugeFileIsRefusedUnread) {
  const TemporaryFile file("huge.toml", "");
  std::filesystem::resize_file(file.path(), 8'388'609);
  EXPECT_THAT(error_of_file(file.path()), HasSubstr("has 8388609 bytes, more than the 8388608 allowed"));
}

TEST(RigFile, AnEmptyFileSaysWhatARigHas) {
  expect_rig_refused("@", {"the file is empty", "name, rate_hz and an [[axis]]"});
}

TEST(RigFile, InvalidUtf8DeepNestingAndSyntaxErrorsAreRefused) {
  expect_change_refused("\"track\"",
                        "\"tr@\xe9"
                        "ck\"",
                        {"byte 0xe9 is not UTF-8"});
  expect_rig_refused("axis = [[[[[[[[[[[[[[[[@[[[[[[[[", {"nested deeper than 16 levels"});
  expect_change_refused("250", "@", {"not valid TOML"});
}

TEST(RigFile, TheClockIsWatchedBeforeAnEdgeForSoLong) {
  EXPECT_EQ(parse_rig(slider, "slider.toml").step_watch_ns, 100'000);
  const std::string with_watch = with(slider, "rate_hz = 250", "rate_hz = 250\nstep_watch_us = 40");
  EXPECT_EQ(parse_rig(with_watch, "slider.toml").step_watch_ns, 40'000);
  expect_change_refused("rate_hz = 250", "rate_hz = 250\nstep_watch_us = @1001", {"1001", "from 0 to 1000"});
  expect_change_refused("rate_hz = 250", "rate_hz = 250\nstep_watch_us = @-1", {"-1", "from 0 to 1000"});
}

// ---- fields and types

TEST(RigFile, AnUnknownFieldIsCorrected) {
  expect_change_refused(
      "rate_hz", "@rate",
      {"the rig has no field \"rate\"", "its fields are name, rate_hz, step_watch_us, bus, axis"});
  expect_change_refused("rate_hz", "@ratehz", {"did you mean \"rate_hz\"?"});
  expect_change_refused("bitrate", "@bit_rate",
                        {"bus \"can0\" has no field \"bit_rate\"", "did you mean \"bitrate\"?"});
  expect_change_refused("max_jerk", "@max_jerks",
                        {"an axis has no field \"max_jerks\"", "did you mean \"max_jerk\"?"});
}

TEST(RigFile, EachDriveHasItsOwnFields) {
  expect_change_refused("counts_per_unit", "@steps_per_unit",
                        {"a cia402 drive has no field \"steps_per_unit\"",
                         "its fields are type, bus, node, mode, counts_per_unit"});
  expect_mixed_change_refused("turns_per_unit = 12.5", "@counts_per_unit = 1",
                              {"an odrive drive has no field \"counts_per_unit\""});
  expect_mixed_change_refused("turns_per_unit = 1 ", "@turn_per_unit = 1 ",
                              {"a moteus drive has no field", "did you mean \"turns_per_unit\"?"});
  expect_mixed_change_refused("path", "@device",
                              {"a pipe drive has no field \"device\"", "type, path, counts_per_unit"});
  expect_change_refused("dir =", "@direction =", {"a step-dir drive has no field \"direction\""});
}

TEST(RigFile, ADuplicateKeyIsFoundAtTheSecondOne) {
  expect_change_refused("max = 1500.0", "max = 1500.0\n@max = 1.0", {"\"max\" is given a second time"});
  expect_change_refused("[[axis]]\nname = \"track\"", "@[bus.can0]\n[[axis]]\nname = \"track\"",
                        {"\"bus.can0\" is given a second time"});
}

TEST(RigFile, MissingFieldsAreNamedWithAnExample) {
  expect_rig_refused("@" + with(slider, "name = \"slider with pan head\"", ""),
                     {"the rig has no name; add name = "});
  expect_rig_refused("@" + with(slider, "rate_hz = 250", ""), {"the rig has no rate_hz; add rate_hz = 250"});
  expect_rig_refused("@name = \"a\"\nrate_hz = 1", {"the rig has no axis; add an [[axis]]"});
  const std::string marked = with(slider, "[[axis]]\nname = \"track\"", "@[[axis]]\nname = \"track\"");
  expect_rig_refused(with(marked, "name = \"track\"\n", ""), {"an axis has no name; add name = "});
  expect_rig_refused(with(marked, "unit = \"mm\"\n", ""), {"an axis has no unit; add unit = \"mm\", \"m\""});
  expect_rig_refused(with(marked, "min = 0.0\n", ""), {"an axis has no min; add"});
  expect_rig_refused(with(marked, "max = 1500.0\n", ""), {"an axis has no max; add"});
  expect_rig_refused(with(marked, "max_velocity = 400.0\n", ""), {"an axis has no max_velocity; add"});
  expect_rig_refused(with(marked, "max_acceleration = 800.0\n", ""),
                     {"an axis has no max_acceleration; add"});
  expect_rig_refused(
      with(marked, "drive = { type = \"cia402\", bus = \"can0\", node = 1, counts_per_unit = 1000.0 }\n", ""),
      {"an axis has no drive; add"});
  expect_rig_refused("name=\"a\"\nrate_hz=1\n@[bus.can0]\n[[axis]]",
                     {"bus \"can0\" has no bitrate; add bitrate = "});
}

TEST(RigFile, MissingFieldsOfADriveAreNamed) {
  expect_change_refused("{ type = \"cia402\", bus", "@{ bus", {"drive has no type; add type = \"cia402\""});
  expect_change_refused("{ type = \"cia402\", bus = \"can0\",", "@{ type = \"cia402\",",
                        {"a cia402 drive has no bus; add"});
  expect_change_refused("{ type = \"cia402\", bus = \"can0\", node = 1,",
                        "@{ type = \"cia402\", bus = \"can0\",", {"has no node; add"});
  expect_change_refused("{ type = \"cia402\", bus = \"can0\", node = 1, counts_per_unit = 1000.0 }",
                        "@{ type = \"cia402\", bus = \"can0\", node = 1 }", {"has no counts_per_unit; add"});
  expect_change_refused("{ type = \"step-dir\", chip = \"pinctrl-bcm2711\",", "@{ type = \"step-dir\",",
                        {"has no chip; add the label"});
  expect_mixed_change_refused("{ type = \"pipe\", path = \"/run/puppet\",", "@{ type = \"pipe\",",
                              {"has no path; add"});
}

TEST(RigFile, WrongTypesSayWhatStandsThereAndWhatShould) {
  expect_change_refused("250", "@250.0", {"rate_hz is a number with a fraction", "without a decimal point"});
  expect_change_refused("1_000_000", "@\"1M\"",
                        {"bitrate is text; write a whole number from 10000 to 1000000"});
  expect_change_refused("1500.0", "@\"1500\"", {"max is text; write a number"});
  expect_change_refused("unit = \"mm\"", "unit = @1", {"unit is a whole number; write \"mm\", \"m\""});
  expect_rig_refused("name = \"a\"\nrate_hz = 1\n@[axis]\nname = \"b\"",
                     {"axis is a single table", "[[...]]"});
  expect_rig_refused("name = \"a\"\nrate_hz = 1\nbus = @\"can0\"", {"bus is text; write a table"});
  expect_rig_refused("name = \"a\"\nrate_hz = 1\nbus.can0 = @1",
                     {"bus \"can0\" is a whole number; write a table"});
  expect_change_refused("step = 17", "step = @1.5", {"step is a number with a fraction"});
  expect_mixed_change_refused("{ type = \"pipe\", path = \"/run/puppet\", counts_per_unit = 300 }",
                              "@\"pipe\"", {"drive is text; write a table"});
}

TEST(RigFile, UnknownUnitsAndDrivesMeetTheListOfThem) {
  expect_change_refused("\"mm\"", "@\"cm\"",
                        {"unit is \"cm\"; write \"mm\", \"m\", \"deg\", \"rad\", \"turn\" or \"unit\""});
  expect_change_refused("\"cia402\"", "@\"canopen\"",
                        {"type is \"canopen\"; write \"cia402\", \"odrive\", \"moteus\", \"rmd\", "
                         "\"cubemars\", \"step-dir\" or \"pipe\""});
}

// ---- numbers

TEST(RigFile, RateIsFromOneTo20000) {
  expect_change_refused("250", "@0", {"rate_hz is 0; write a whole number from 1 to 20000"});
  expect_change_refused("250", "@-250", {"rate_hz is -250"});
  expect_change_refused("250", "@20_001", {"rate_hz is 20001"});
  EXPECT_EQ(parse_rig(with(slider, "250", "20000"), "r").rate_hz, 20'000);
}

TEST(RigFile, ARateThatCia402CannotStateMeetsTheNearestTwo) {
  expect_change_refused("250", "@300", {"rate_hz is 300", "60C2", "write 250 or 400"});
  expect_change_refused("250", "@999", {"write 800 or 1000"});
  EXPECT_EQ(parse_rig(mixed, "r").rate_hz, 300) << "without a CiA 402 drive every rate will do";
}

TEST(RigFile, Cia402RatesHaveAnExactPeriod) {
  for (const int rate :
       {1, 2, 4, 5, 8, 10, 25, 40, 50, 100, 125, 200, 250, 500, 1000, 2000, 4000, 8000, 10'000, 20'000}) {
    EXPECT_TRUE(is_cia402_rate(rate)) << rate;
  }
  // 3 has no whole number of microseconds; 32 has 31 250, and 3125 does not fit into the byte of 60C2:1.
  for (const int rate : {-1, 0, 3, 24, 30, 32, 60, 64, 240, 300, 3000, 16'000})
    EXPECT_FALSE(is_cia402_rate(rate)) << rate;
}

TEST(RigFile, BitrateIsACanBitrate) {
  expect_change_refused("1_000_000", "@9_999",
                        {"bitrate is 9999; write a whole number from 10000 to 1000000"});
  expect_change_refused("1_000_000", "@5_000_000", {"bitrate is 5000000"});
}

TEST(RigFile, MinIsBelowMax) {
  expect_change_refused("1500.0", "@0.0", {"max is 0, not above min = 0; write min < max"});
  expect_change_refused("max = 90.0", "max = @-91", {"max is -91, not above min = -90"});
}

TEST(RigFile, LimitsAreAboveZero) {
  expect_change_refused("400.0", "@0.0", {"max_velocity is 0; write a number above 0"});
  expect_change_refused("800.0", "@-800.0", {"max_acceleration is -800; write a number above 0"});
  expect_change_refused("8000", "@0", {"max_jerk is 0; write a number above 0"});
  expect_mixed_change_refused("max_acceleration_step = 4", "max_acceleration_step = @0",
                              {"max_acceleration_step is 0"});
  expect_mixed_change_refused("stop_acceleration = 5", "stop_acceleration = @-5",
                              {"stop_acceleration is -5"});
  expect_mixed_change_refused("stop_jerk = 6", "stop_jerk = @0", {"stop_jerk is 0"});
}

TEST(RigFile, AStopMayDoWhatTheMotionMay) {
  expect_mixed_change_refused("stop_acceleration = 5", "stop_acceleration = @1.5",
                              {"stop_acceleration is 1.5, below max_acceleration = 2; write 2 or more"});
  expect_mixed_change_refused("stop_jerk = 6", "stop_jerk = @2.5", {"stop_jerk is 2.5, below max_jerk = 3"});
  EXPECT_EQ(parse_rig(with(mixed, "stop_acceleration = 5", "stop_acceleration = 2"), "rig.toml")
                .axes[0]
                .stop_acceleration,
            2);
}

TEST(RigFile, NotANumberInfinityAndHugeNumbersAreRefused) {
  expect_change_refused("1500.0", "@inf", {"max is inf; write a number from -1e+100 to 1e+100"});
  expect_change_refused("min = 0.0", "min = @nan", {"min is nan"});
  expect_change_refused("400.0", "@1e308", {"max_velocity is 1e+308"});
  expect_change_refused("1000.0", "@nan", {"counts_per_unit is nan"});
}

// ---- drives

TEST(RigFile, AScaleIsNotZero) {
  expect_change_refused("1000.0", "@0", {"counts_per_unit is 0", "negative one to reverse the motor"});
  expect_change_refused("-88.888889", "@0.0", {"steps_per_unit is 0"});
  expect_mixed_change_refused("12.5", "@0", {"turns_per_unit is 0"});
}

TEST(RigFile, CountsFitInto32Bits) {
  expect_change_refused(
      "1000.0", "@2e6",
      {"counts_per_unit is 2000000, so that 1500 mm is 3000000000 counts, beyond 2147483647"});
  expect_change_refused("-88.888889", "@24e6", {"so that -90 deg is -2160000000 steps"});
  expect_mixed_change_refused("300 }", "@2147483648 }", {"-1 rad is -2147483648 counts"});
  EXPECT_EQ(parse_rig(with(mixed, "300 }", "-2147483647.4 }"), "r").axes.size(), 4U);
}

TEST(RigFile, AnOdriveSaysItsFirmwareAndCanBeToldEveryVelocity) {
  expect_mixed_change_refused(
      R"({ type = "odrive", bus = "can0", node = 0, turns_per_unit = 12.5, firmware = "0.5" })",
      R"(@{ type = "odrive", bus = "can0", node = 0, turns_per_unit = 12.5 })",
      {"an odrive drive has no firmware; add"});
  expect_mixed_change_refused(R"(firmware = "0.5")", R"(firmware = @"0.4")",
                              {R"(firmware is "0.4"; write "0.5" or "0.6")"});
  expect_mixed_change_refused(R"(firmware = "0.5")", R"(firmware = "0.5", max_following_error = @0)",
                              {"max_following_error is 0"});
  // In 16 bits the feed-forward of a velocity would go round.
  expect_mixed_change_refused("turns_per_unit = 12.5", "turns_per_unit = @-32.768",
                              {"max_velocity = 1 m/s is 32.768 turns/s", "goes to 32.767"});
}

// A classic drive answers a CAN FD frame with errors, so that nothing gets through for anybody.
TEST(RigFile, DrivesThatSpeakCanFdHaveABusOfTheirOwnWithABitrateOfData) {
  expect_mixed_change_refused(R"("moteus", bus = "can1")", R"("moteus", bus = @"can0")",
                              {R"(bus is "can0", a bus of classic CAN, and this drive speaks CAN FD; write )",
                               "data_bitrate = 5_000_000, say, in [bus.can0]"});
  expect_mixed_change_refused(R"("odrive", bus = "can0")", R"("odrive", bus = @"can1")",
                              {R"(bus is "can1", a bus of CAN FD)", "give it a bus of its own"});
  expect_mixed_change_refused("data_bitrate = 2_000_000", "data_bitrate = @499_999",
                              {"data_bitrate is 499999; write a whole number from 500000 to 8000000"});
}

// docs/faults.md 29
TEST(RigFile, AnRmdMotorCanBeToldTheLimitOfEveryVelocity) {
  const std::string drive =
      R"({ type = "odrive", bus = "can0", node = 0, turns_per_unit = 12.5, firmware = "0.5" })";
  const auto rig = [&](const std::string& text) { return with(mixed, drive, text); };
  const RigFile read = parse_rig(
      rig(R"({ type = "rmd", bus = "can0", node = 32, turns_per_unit = -12.5, no_watchdog = "accepted" })"),
      "r");
  const RmdDrive& rmd = std::get<RmdDrive>(read.axes[0].drive);
  EXPECT_EQ(rmd.node, 32);
  EXPECT_EQ(rmd.turns_per_unit, -12.5);
  EXPECT_EQ(rmd.follow.max_following_error, 0.1);
  EXPECT_TRUE(rmd.has_no_watchdog);
  EXPECT_EQ(max_rmd_deg_per_s_of(read.axes[0]), 5400);
  expect_rig_refused(rig(R"({ type = "rmd", bus = "can0", node = @0, turns_per_unit = 12.5 })"),
                     {"node is 0; write a whole number from 1 to 32"});
  expect_rig_refused(rig(R"({ type = "rmd", bus = "can0", node = 1, turns_per_unit = @152 })"),
                     {"1.2 times max_velocity is 65664 deg/s", "holds 65535"});
  expect_rig_refused(
      rig(R"({ type = "rmd", bus = "can0", node = 1, turns_per_unit = 1, no_watchdog = @"yes" })"),
      {"write \"accepted\""});
}

// docs/faults.md 29
TEST(RigFile, ACubemarsMotorNeedsSomebodyWhoAcceptsThatNothingStopsItAndNeverHasMitMode) {
  const std::string drive =
      R"({ type = "odrive", bus = "can0", node = 0, turns_per_unit = 12.5, firmware = "0.5" })";
  const auto rig = [&](const std::string& more, const std::string& scale = "turns_per_unit = -0.1") {
    return with(mixed, drive, "{ type = \"cubemars\", bus = \"can0\", node = 255, " + scale + more + " }");
  };
  const std::string shaft = ", pole_pairs = 21, gear = 9";
  const std::string accepted = R"(, no_watchdog = "accepted")";
  const RigFile read =
      parse_rig(rig(shaft + accepted + ", counts_per_deg = 1000000, erpm_per_count = 1"), "r");
  const CubemarsDrive& cubemars = std::get<CubemarsDrive>(read.axes[0].drive);
  EXPECT_EQ(cubemars.node, 255);
  EXPECT_EQ(cubemars.pole_pairs * cubemars.gear, 189);
  EXPECT_EQ(cubemars.counts_per_deg, 1'000'000);
  EXPECT_EQ(cubemars.erpm_per_count, 1);
  EXPECT_EQ(cubemars_limits_of(read.axes[0]).velocity, 1361) << "1.2 m/s, 7.2 turns a minute";
  expect_rig_refused(with(rig(shaft), "{ type = \"cubemars\"", "@{ type = \"cubemars\""),
                     {"a cubemars drive has no no_watchdog; add no_watchdog = \"accepted\"",
                      "no firmware is known to have a watchdog"});
  expect_rig_refused(rig(shaft + accepted + R"(, mode = @"mit")"),
                     {"mode is \"mit\"", "without a velocity limit", "write \"servo\""});
  expect_rig_refused(rig(shaft + accepted + ", counts_per_deg = @20000"), {"write 10000 or 1000000"});
  expect_rig_refused(rig(shaft + accepted + ", erpm_per_count = @5"), {"write 10 or 1"});
  expect_rig_refused(rig(shaft + accepted, "turns_per_unit = @9"), {"-1 m is -9 turns, beyond 8.8888"});
  expect_rig_refused(
      rig(", pole_pairs = 21, gear = 1" + accepted + ", counts_per_deg = 1000000", "turns_per_unit = @6"),
      {"-1 m is 2160 deg of the motor", "it can be told 2147"});
  expect_rig_refused(rig(", pole_pairs = 21, gear = 60" + accepted, "turns_per_unit = @4"),
                     {"1.2 times max_velocity is 362880 electrical turns a minute", "holds 327670"});
  expect_rig_refused(rig(shaft + accepted + ", erpm_per_count = 1", "turns_per_unit = @0.7"),
                     {"a controlled stop is 39690 electrical turns a minute per second"});
}

TEST(RigFile, TurnsKeepAThousandthInSinglePrecision) {
  expect_mixed_change_refused("12.5", "@16385", {"-1 m is -16385 turns, beyond 16384"});
  expect_mixed_change_refused("turns_per_unit = 1 ", "turns_per_unit = @-1e9 ", {"beyond 16384"});
  EXPECT_EQ(parse_rig(with(mixed, "turns_per_unit = 1 ", "turns_per_unit = -16384 "), "r").axes.size(), 4U);
}

TEST(RigFile, NodesAreInTheRangeOfTheirProtocol) {
  expect_change_refused("node = 1", "node = @0", {"node is 0; write a whole number from 1 to 127"});
  expect_change_refused("node = 1", "node = @128", {"node is 128"});
  expect_mixed_change_refused("node = 0", "node = @63", {"node is 63; write a whole number from 0 to 62"});
  expect_mixed_change_refused("node = 126", "node = @127",
                              {"node is 127; write a whole number from 1 to 126"});
}

TEST(RigFile, AnUnknownBusIsRefused) {
  expect_change_refused("bus = \"can0\"", "bus = @\"can7\"",
                        {"bus is \"can7\", which the rig does not have; add a [bus.NAME]"});
}

TEST(RigFile, ABusIsNamedLikeANetworkInterface) {
  expect_change_refused("[bus.can0]", "@[bus.\"a/b\"]",
                        {"bus \"a/b\" is not a network interface; write a name such as can0"});
  expect_change_refused("[bus.can0]", "@[bus.a-name-too-long-for-linux]", {"is not a network interface"});
  expect_change_refused("[bus.can0]", "@[bus.\"\"]", {"is not a network interface"});
}

TEST(RigFile, ANodeIsOnABusOnce) {
  expect_mixed_change_refused(
      R"(type = "moteus", bus = "can1", node = 126, turns_per_unit = 1)",
      R"(type = "odrive", bus = "can0", node = @0, turns_per_unit = 1, firmware = "0.5")",
      {"node is node 0 of bus can0, which line 19 has already; give each drive its own"});
}

TEST(RigFile, AnAxisNameIsUniqueAndNotEmpty) {
  expect_change_refused("\"pan\"", "@\"track\"", {"name is axis \"track\", which line 8 has already"});
  expect_change_refused("\"pan\"", "@\"\"", {"name is empty"});
  expect_change_refused("\"pan\"", "@\"a\\tb\"", {"control character; remove it"});
}

TEST(RigFile, ALineOfAChipIsUsedOnce) {
  expect_change_refused(
      "\"GPIO27\"", "@17",
      {"dir is line 17 of chip \"pinctrl-bcm2711\", which line 24 has already; use each line once"});
  expect_mixed_change_refused("enable = 0", "enable = @1", {"enable is line 1 of chip \"expander\""});
  expect_mixed_change_refused("enable = 0", "enable = @\"STEP\"",
                              {"enable is line \"STEP\" of chip \"expander\""});
  const std::string two_steppers =
      with(mixed, "{ type = \"pipe\", path = \"/run/puppet\", counts_per_unit = 300 }",
           "{ type = \"step-dir\", chip = \"expander\", step = 2, dir = 3, steps_per_unit = 1 }");
  expect_rig_refused(with(two_steppers, "dir = 1", "dir = @3"),
                     {"dir is line 3 of chip \"expander\", which line 35"});
}

TEST(RigFile, ALineIsAnOffsetOrAName) {
  expect_change_refused("17", "@-1", {"step is -1; write a whole number from 0 to 65535"});
  expect_change_refused("\"GPIO27\"", "@\"\"", {"dir is empty"});
}

TEST(RigFile, AChipGoesByItsLabel) {
  for (const char* chip : {"gpiochip0", "/dev/gpiochip4", "0", "gpiochip"}) {
    expect_change_refused("\"pinctrl-bcm2711\"", fmt::format("@\"{}\"", chip),
                          {"a number that may change at every start; write the chip's label"});
  }
}

TEST(RigFile, ARigHasAtMost64Axes) {
  std::string axes = "name = \"a\"\nrate_hz = 1\n@";
  for (int i = 0; i < 65; ++i) axes += "[[axis]]\n";
  expect_rig_refused(axes, {"axis has 65 elements; write at most 64"});
}

}  // namespace rig_file_test
}  // namespace inbetween
