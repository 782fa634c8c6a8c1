// What a rig says about its GPIO lines: step timing, home and limit switches, emergency stop, trigger,
// camera, outputs; and who knows where an axis is.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <string_view>
#include <variant>

#include "host_tools/rig_model/rig_file.hpp"
#include "tests/support/refused_text.hpp"

namespace inbetween {
namespace rig_gpio_test {

constexpr const char* slider = R"(name = "slider"
rate_hz = 250
[emergency_stop]
chip = "head"
line = 5
stops_at = "high"
[start_trigger]
line = "START"
active = "low"
[camera]
chip = "head"
line = 13
asks = { chip = "head", line = 16, active = "low", bias = "pull-up" }
[output.lamp]
chip = "head"
line = 19
idle = "high"
[output.Clap-2_b]
line = "CLAP"
[[axis]]
name = "slide"
unit = "mm"
min = 0
max = 800
max_velocity = 100
max_acceleration = 200
drive = { type = "step-dir", chip = "head", step = 17, dir = 27, enable = 22, steps_per_unit = -80 }
home = { chip = "head", line = 23, direction = "negative", fast = 20, slow = 2, back_off = 5 }
limit_min = { chip = "head", line = 24 }
limit_max = { chip = "head", line = 25, active = "low", bias = "pull-up" }
[[axis]]
name = "pan"
unit = "deg"
min = -90
max = 90
max_velocity = 60
max_acceleration = 120
drive = { type = "pipe", path = "/dev/ttyACM0", counts_per_unit = 10 }
)";

/// The slide's drive with all that it may say.
constexpr const char* every_time =
    R"(enable = 22, enable_active = "high", max_step_rate = 50_000, pulse_us = 2.5, pause_us = 7.5004, )"
    "dir_setup_us = 0.0001, dir_hold_us = 20, latest_us = 250,";

constexpr const char* can_rig = R"(name = "r"
rate_hz = 250
[bus.can0]
bitrate = 1_000_000
[[axis]]
name = "track"
unit = "mm"
min = 0
max = 1500
max_velocity = 400
max_acceleration = 800
drive = { type = "cia402", bus = "can0", node = 1, counts_per_unit = 1000 }
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

RigFile changed(std::string_view from, std::string_view to) {
  return parse_rig(with(slider, from, to), "r");
}

StepDirDrive slide_drive(const RigFile& rig) {
  return std::get<StepDirDrive>(rig.axes.at(0).drive);
}

// ---- what is accepted

TEST(RigGpio, ReadsTheSwitchesOfAnAxis) {
  const RigFile rig = parse_rig(slider, "slider.toml");
  const RigAxis& slide = rig.axes.at(0);
  ASSERT_TRUE(slide.home.has_value());
  EXPECT_EQ(to_string(slide.home->input.address), "line 23 of chip \"head\"");
  EXPECT_EQ(to_string(slide.home->input.address.place), "slider.toml:28:32");
  EXPECT_EQ(slide.home->input.active, Level::high);
  EXPECT_EQ(slide.home->input.bias, Bias::pull_up);
  EXPECT_EQ(slide.home->direction, -1);
  EXPECT_EQ(slide.home->fast, 20);
  EXPECT_EQ(slide.home->slow, 2);
  EXPECT_EQ(slide.home->back_off, 5);
  EXPECT_EQ(slide.home->search, 805) << "the whole axis and the distance to back off";
  EXPECT_EQ(slide.home->at, 0);
  ASSERT_TRUE(slide.limit_min && slide.limit_max);
  EXPECT_EQ(slide.limit_min->address.line, GpioLine(24));
  EXPECT_EQ(slide.limit_min->active, Level::high);
  EXPECT_EQ(slide.limit_min->bias, Bias::pull_up);
  EXPECT_EQ(slide.limit_max->active, Level::low);
  EXPECT_EQ(slide.limit_max->bias, Bias::pull_up);
  EXPECT_FALSE(rig.axes.at(1).home || rig.axes.at(1).limit_min || rig.axes.at(1).limit_max);
}

TEST(RigGpio, ReadsTheSearchForTheSwitch) {
  const RigFile rig = changed("\"negative\", fast = 20", "\"positive\", search = 30, at = 801.5, fast = 100");
  EXPECT_EQ(rig.axes.at(0).home->direction, 1);
  EXPECT_EQ(rig.axes.at(0).home->search, 30);
  EXPECT_EQ(rig.axes.at(0).home->at, 801.5);
  EXPECT_EQ(changed("back_off = 5", "back_off = 5, at = -20").axes.at(0).home->search, 825);
  EXPECT_EQ(changed("\"negative\", fast = 20", "\"positive\", at = 500, fast = 20").axes.at(0).home->search,
            805);
}

TEST(RigGpio, ReadsTheLinesOfTheRig) {
  const RigFile rig = parse_rig(slider, "slider.toml");
  ASSERT_TRUE(rig.emergency_stop && rig.start_trigger && rig.camera && rig.camera->asks);
  EXPECT_EQ(rig.emergency_stop->active, Level::high);
  EXPECT_EQ(rig.emergency_stop->bias, Bias::pull_up);
  EXPECT_EQ(rig.start_trigger->address.chip, "");
  EXPECT_EQ(to_string(rig.start_trigger->address), "line \"START\"");
  EXPECT_EQ(rig.start_trigger->active, Level::low);
  EXPECT_EQ(rig.start_trigger->bias, Bias::pull_up);
  EXPECT_EQ(rig.camera->shutter.address.line, GpioLine(13));
  EXPECT_EQ(rig.camera->shutter.idle, Level::low);
  EXPECT_EQ(rig.camera->asks->active, Level::low);
  ASSERT_EQ(rig.outputs.size(), 2U);
  EXPECT_EQ(rig.outputs[0].name, "Clap-2_b");
  EXPECT_EQ(rig.outputs[0].line.address.line, GpioLine("CLAP"));
  EXPECT_EQ(rig.outputs[0].line.idle, Level::low);
  EXPECT_EQ(rig.outputs[1].name, "lamp");
  EXPECT_EQ(rig.outputs[1].line.idle, Level::high);
}

TEST(RigGpio, AllOfItMayBeMissing) {
  const RigFile rig = parse_rig(can_rig, "r");
  EXPECT_FALSE(rig.emergency_stop || rig.start_trigger || rig.camera);
  EXPECT_TRUE(rig.outputs.empty());
}

TEST(RigGpio, StepTimesHaveDefaults) {
  const StepDirDrive drive = slide_drive(parse_rig(slider, "r"));
  EXPECT_EQ(drive.max_step_rate, 10'000);
  EXPECT_EQ(drive.pulse_ns, 5'000);
  EXPECT_EQ(drive.pause_ns, 5'000);
  EXPECT_EQ(drive.dir_setup_ns, 5'000);
  EXPECT_EQ(drive.dir_hold_ns, 5'000);
  EXPECT_EQ(drive.latest_ns, 500'000);
  EXPECT_EQ(drive.enable_active, Level::low);
}

TEST(RigGpio, StepTimesAreRoundedUpToNanoseconds) {
  const StepDirDrive drive = slide_drive(changed("enable = 22,", every_time));
  EXPECT_EQ(drive.max_step_rate, 50'000);
  EXPECT_EQ(drive.pulse_ns, 2'500);
  EXPECT_EQ(drive.pause_ns, 7'501);
  EXPECT_EQ(drive.dir_setup_ns, 1);
  EXPECT_EQ(drive.dir_hold_ns, 20'000);
  EXPECT_EQ(drive.latest_ns, 250'000);
  EXPECT_EQ(drive.enable_active, Level::high);
}

// ---- steps

TEST(RigGpio, AnAxisIsNoFasterThanItsDriveMayStep) {
  expect_change_refused(
      "-80", "@-101",
      {"steps_per_unit is -101, so that max_velocity = 100 mm/s is 10100 steps/s",
       "max_step_rate = 10000 steps/s (the default)", "lower max_velocity or the microstepping"});
  EXPECT_EQ(slide_drive(changed("-80", "100")).steps_per_unit, 100) << "exactly the highest rate";
  expect_change_refused("steps_per_unit = -80", "max_step_rate = 7999, steps_per_unit = @-80",
                        {"is 8000 steps/s, more than max_step_rate = 7999 steps/s;"});
}

TEST(RigGpio, PulseAndPausePermitTheHighestRate) {
  expect_change_refused("enable = 22", "pulse_us = @96",
                        {"pulse_us does not go with the others: pulse_us + pause_us is 101 us",
                         "max_step_rate = 10000, 100 us", "lower one of the three"});
  expect_change_refused("enable = 22", "pause_us = @95.001", {"pause_us does not go", "100.001 us"});
  expect_change_refused("enable = 22", "max_step_rate = @100_001", {"max_step_rate does not go"});
  EXPECT_EQ(slide_drive(changed("enable = 22", "max_step_rate = 100_000")).max_step_rate, 100'000);
}

TEST(RigGpio, StepTimesAreInTheirRanges) {
  for (const char* field : {"pulse_us", "pause_us", "dir_setup_us", "dir_hold_us"}) {
    expect_change_refused("enable = 22", fmt::format("{} = @0", field), {field, "write a number above 0"});
    expect_change_refused("enable = 22", fmt::format("{} = @1000.5", field), {field, "from 0 to 1000"});
    expect_change_refused("enable = 22", fmt::format("{} = @\"5\"", field), {field, "is text"});
  }
  expect_change_refused("enable = 22", "latest_us = @0", {"latest_us is 0; write a number above 0"});
  expect_change_refused("enable = 22", "latest_us = @1e7", {"from 0 to 1000000"});
  expect_change_refused("enable = 22", "max_step_rate = @0", {"max_step_rate is 0; write a number above 0"});
  expect_change_refused("enable = 22", "max_step_rate = @2e6", {"from 0 to 1000000"});
}

TEST(RigGpio, AnActiveLevelNeedsItsLine) {
  expect_change_refused("enable = 22", "enable_active = @\"high\"", {"needs an enable line"});
  expect_change_refused("enable = 22", "enable = 22, enable_active = @1", {"write \"low\" or \"high\""});
}

TEST(RigGpio, AChipStepsAtMost32Drives) {
  std::string rig = "name = \"r\"\nrate_hz = 100\n";
  for (int i = 0; i < 33; ++i) {
    rig += fmt::format(
        "{}[[axis]]\nname = \"a{}\"\nunit = \"mm\"\nmin = 0\nmax = 1\nmax_velocity = 1\nmax_acceleration = "
        "1\ndrive = {{ type = \"step-dir\", chip = \"c\", step = {}, dir = {}, steps_per_unit = 1 }}\n",
        i == 32 ? "@" : "", i, 2 * i, 2 * i + 1);
  }
  expect_rig_refused(rig, {"axis \"a32\" is one more step-dir drive than the 32 that chip \"c\""});
  EXPECT_EQ(parse_rig(rig.substr(0, rig.find('@')), "r").axes.size(), 32U);
}

// ---- lines

TEST(RigGpio, ALineIsUsedOnceWhateverFor) {
  expect_change_refused("line = 19", "line = @5",
                        {"line is line 5 of chip \"head\", which line 5 has already; use each line once"});
  expect_change_refused("line = 16", "line = @22", {"which line 27 has already"});
  expect_change_refused("line = 24", "line = @23", {"which line 28 has already"});
  expect_change_refused("line = 25", "line = @24", {"which line 29 has already"});
  expect_change_refused("line = 5\n", "line = @17\n", {"which line 27 has already"});
  expect_change_refused("line = 13", "line = @25", {"which line 30 has already"});
}

TEST(RigGpio, ANameWithoutAChipIsTheSameLineOnAnyChip) {
  expect_change_refused("line = 19", "line = @\"START\"", {"is line \"START\" of chip \"head\"", "line 8"});
  expect_change_refused("\"CLAP\"", "@\"START\"", {"is line \"START\", which line 8 has already"});
  const RigFile rig = changed("chip = \"head\"\nline = 19", "chip = \"other\"\nline = 5");
  EXPECT_EQ(rig.outputs.at(1).line.address.chip, "other");
}

TEST(RigGpio, AnOffsetNeedsItsChip) {
  expect_change_refused("line = \"START\"", "line = @7",
                        {"line is an offset without its chip; add chip = \"the label of the GPIO chip\""});
  expect_change_refused("chip = \"head\"\nline = 19", "chip = @\"gpiochip0\"\nline = 19", {"chip's label"});
  expect_change_refused("line = 19", "line = @65_536", {"from 0 to 65535"});
  expect_change_refused("line = 19", "line = @\"\"", {"line is empty"});
}

// ---- what a broken wire does

TEST(RigGpio, AnEmergencyStopSaysItsLevel) {
  expect_rig_refused(with(with(slider, "[emergency_stop]", "@[emergency_stop]"), "stops_at = \"high\"\n", ""),
                     {"the emergency stop has no stops_at; add stops_at = \"high\" or \"low\""});
  const RigFile rig = changed("stops_at = \"high\"", "stops_at = \"low\"");
  EXPECT_EQ(rig.emergency_stop->active, Level::low);
  EXPECT_EQ(rig.emergency_stop->bias, Bias::pull_down) << "a broken wire stops";
}

TEST(RigGpio, ABrokenWireCannotSilenceTheEmergencyStop) {
  expect_change_refused("stops_at = \"high\"", "stops_at = \"high\"\nbias = @\"pull-down\"",
                        {"bias is \"pull-down\", so that a broken wire would read low",
                         "as if nothing were to stop", "write \"pull-up\", or \"none\""});
  expect_change_refused("stops_at = \"high\"", "stops_at = \"low\"\nbias = @\"pull-up\"",
                        {"would read high", "write \"pull-down\""});
  const RigFile outside = changed("stops_at = \"high\"", "stops_at = \"high\"\nbias = \"none\"");
  EXPECT_EQ(outside.emergency_stop->bias, Bias::none);
}

TEST(RigGpio, ABrokenWireStartsNothing) {
  expect_change_refused("active = \"low\"\n", "active = \"low\"\nbias = @\"pull-down\"\n",
                        {"a broken wire would read low, which would start", "write \"pull-up\""});
  expect_change_refused("line = 16, active = \"low\", bias = \"pull-up\"",
                        "line = 16, active = \"high\", bias = @\"pull-up\"", {"which would start"});
  EXPECT_EQ(changed("active = \"low\"\n", "").start_trigger->bias, Bias::pull_down);
}

TEST(RigGpio, ASwitchIsPressedWhenItsWireBreaksUnlessItSaysOtherwise) {
  EXPECT_EQ(changed("line = 24", "line = 24, active = \"low\"").axes[0].limit_min->bias, Bias::pull_down);
  EXPECT_EQ(changed("line = 24", "line = 24, bias = \"pull-down\"").axes[0].limit_min->bias, Bias::pull_down);
  expect_change_refused("line = 24", "line = 24, bias = @\"up\"",
                        {"bias is \"up\"; write \"pull-up\", \"pull-down\" or \"none\""});
}

// ---- homing and reference

TEST(RigGpio, AHomeSaysWhereAndHowFast) {
  const std::string marked = with(slider, "home = {", "home = @{");
  expect_rig_refused(with(marked, " direction = \"negative\",", ""), {"a home has no direction; add"});
  expect_rig_refused(with(marked, " fast = 20,", ""), {"a home has no fast; add"});
  expect_rig_refused(with(marked, " slow = 2,", ""), {"a home has no slow; add"});
  expect_rig_refused(with(marked, ", back_off = 5", ""), {"a home has no back_off; add"});
  expect_rig_refused(with(marked, "line = 23, ", ""), {"a home has no line; add"});
  expect_change_refused("\"negative\"", "@\"down\"", {"write \"negative\" or \"positive\""});
  expect_change_refused("fast = 20", "fast = @101", {"fast is 101, above max_velocity = 100"});
  expect_change_refused("slow = 2", "slow = @20", {"slow is 20, not below fast = 20"});
  expect_change_refused("slow = 2", "slow = @0", {"slow is 0; write a number above 0"});
  expect_change_refused("fast = 20", "fast = @-1", {"fast is -1; write a number above 0"});
  expect_change_refused("back_off = 5", "back_off = @0", {"back_off is 0; write a number above 0"});
  expect_change_refused("back_off = 5", "back_off = 5, search = @0", {"search is 0"});
  expect_change_refused("back_off = 5", "back_off = 5, at = @1e9",
                        {"at is 1000000000 mm, which the drive cannot count to"});
  expect_change_refused("back_off = 5", "back_off = 5, at = @800",
                        {"at puts the switch at 800 mm, where no way down leads from max = 800"});
  expect_change_refused(
      "home = { chip = \"head\", line = 23, direction = \"negative\"",
      "home = @{ chip = \"head\", line = 23, direction = \"positive\"",
      {"home puts the switch at 0 mm, where no way up leads from min = 0", "or the other direction"});
  expect_change_refused("back_off", "@backoff", {"did you mean \"back_off\"?"});
}

TEST(RigGpio, AnAxisParksInsideItsLimitsOnceItIsHome) {
  EXPECT_EQ(parse_rig(slider, "slider.toml").axes.at(0).park, std::nullopt);
  EXPECT_EQ(changed("back_off = 5", "back_off = 5, park = 40").axes.at(0).park, 40);
  EXPECT_EQ(changed("back_off = 5", "back_off = 5, park = 800").axes.at(0).park, 800);
  for (const char* park : {"800.5", "-0.1", "1e9"}) {
    expect_change_refused("back_off = 5", std::string("back_off = 5, park = @") + park,
                          {"park is ", " mm, outside 0..800", "write a position between min and max"});
  }
  expect_change_refused("back_off = 5", "back_off = 5, park = @\"left\"", {"park", "number"});
}

TEST(RigGpio, ADriveThatKnowsWhereItIsHomesItself) {
  const std::string odrive = with(can_rig, R"("cia402")", R"("odrive", firmware = "0.6")");
  expect_rig_refused(with(odrive, "counts_per_unit = 1000", "turns_per_unit = 0.01") + "home = @{}\n",
                     {"home has no meaning for a drive that knows"});
}

TEST(RigGpio, WhoKnowsWhereAnAxisIsHasADefault) {
  const RigFile rig = parse_rig(slider, "r");
  EXPECT_EQ(rig.axes.at(0).reference, Reference::by_home);
  EXPECT_EQ(rig.axes.at(1).reference, Reference::by_operator);
  EXPECT_EQ(parse_rig(can_rig, "r").axes.at(0).reference, Reference::by_operator) << "it may forget turns";
  EXPECT_TRUE(is_open_loop(rig.axes.at(0).drive) && is_open_loop(rig.axes.at(1).drive));
  EXPECT_FALSE(is_open_loop(parse_rig(can_rig, "r").axes.at(0).drive));
}

TEST(RigGpio, WhoKnowsWhereAnAxisIsCanBeSaid) {
  const auto of_can_axis = [](const char* reference) {
    return parse_rig(fmt::format("{}reference = \"{}\"\n", can_rig, reference), "r").axes.at(0).reference;
  };
  EXPECT_EQ(of_can_axis("operator"), Reference::by_operator);
  for (const Reference reference : {Reference::by_operator, Reference::by_drive}) {
    EXPECT_EQ(of_can_axis(std::string(to_string(reference)).c_str()), reference);
  }
  EXPECT_EQ(changed("home = {", "reference = \"home\"\nhome = {").axes.at(0).reference, Reference::by_home);
}

TEST(RigGpio, AReferenceGoesWithTheAxis) {
  expect_rig_refused(std::string(can_rig) + "reference = @\"home\"\n",
                     {"is \"home\", but the axis has none; add home = { ... } or write \"operator\""});
  expect_change_refused("home = {", "reference = @\"operator\"\nhome = {",
                        {"is \"operator\", but the axis has a home; remove one of the two"});
  expect_change_refused("home = {", "reference = @\"drive\"\nhome = {", {"nothing reports where this axis"});
  expect_change_refused("home = {", "reference = @\"motor\"\nhome = {",
                        {"write \"drive\", \"operator\" or \"home\""});
}

// ---- sections of the rig

TEST(RigGpio, EachSectionHasItsOwnFields) {
  expect_change_refused("stops_at", "@active", {"the emergency stop has no field \"active\""});
  expect_change_refused("active = \"low\"\n", "@activ = \"low\"\n", {"did you mean \"active\"?"});
  expect_change_refused("idle = \"high\"", "@width_ms = 5", {"output \"lamp\" has no field \"width_ms\""});
  expect_change_refused("asks =", "@ask =", {"the camera has no field \"ask\"", "\"asks\"?"});
  expect_change_refused("idle = \"high\"", "idle = @\"off\"", {"idle is \"off\"; write \"low\" or \"high\""});
}

TEST(RigGpio, SectionsAreTables) {
  for (const char* field : {"emergency_stop", "start_trigger", "camera", "output", "output.lamp"}) {
    expect_rig_refused(fmt::format("{} = @5\n{}", field, can_rig), {"is a whole number; write a table"});
  }
  expect_rig_refused(with(slider, "limit_min = {", "limit_min = @[]\n#"), {"limit_min is an array"});
}

TEST(RigGpio, AnOutputHasAPlainNameThatIsNotTheCameras) {
  expect_change_refused("[output.lamp]", "@[output.\"l amp\"]",
                        {"output \"l amp\" is not a plain name; write letters, digits, - and _"});
  expect_change_refused("[output.lamp]", "@[output.\"\"]", {"is not a plain name"});
  expect_change_refused("[output.lamp]", "@[output.camera]",
                        {"has the name of the shutter line; write [camera], or another name"});
}

TEST(RigGpio, ARigHasAtMost64Outputs) {
  std::string rig = std::string(can_rig) + "@[output.n0]\nchip = \"c\"\nline = 0\n";
  for (int i = 1; i < 64; ++i) rig += fmt::format("[output.n{}]\nchip = \"c\"\nline = {}\n", i, i);
  EXPECT_EQ(parse_rig(with(rig, "@", ""), "r").outputs.size(), 64U);
  expect_rig_refused(rig + "[output.n64]\nchip = \"c\"\nline = 64\n",
                     {"output has 65 lines; write at most 64"});
}

}  // namespace rig_gpio_test
}  // namespace inbetween
