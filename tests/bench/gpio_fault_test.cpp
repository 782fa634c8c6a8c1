// What goes wrong at lines of the kernel's GPIO, and what the whole program does about it.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "tests/bench/gpio_scene.hpp"

namespace inbetween {
namespace gpio_fault_test {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;

constexpr std::int64_t ms = 1'000'000;

// --- edges are lost

constexpr unsigned step = 0, enable = 4, emergency_stop = 6, first_contact = 8, contacts = 16;
constexpr std::int64_t tick_ns = 100 * ms;
/// The kernel of the bench tells an edge of each line every 10 ms, the loop takes 64 in a tick, and 1024 are
/// kept.
constexpr std::int64_t told_in_a_tick = 10 * contacts, taken_in_a_tick = 64, kept = 1024;
constexpr std::int64_t fewest_ticks_to_lose = kept / told_in_a_tick;
constexpr std::int64_t ticks_to_lose = kept / (told_in_a_tick - taken_in_a_tick) + 1;

/// A home of the rig with loose contacts.
std::string home_at(unsigned line) {
  return fmt::format(
      R"(home = {{ chip = "head", line = {}, direction = "positive", fast = 10, slow = 1, back_off = 1, )"
      R"(bias = "none" }})",
      line);
}

/// A loop so slow, and so many lines that change, that more edges come in a tick than it can take.
std::string rig_with_loose_contacts(const std::string& of_rig, const std::string& of_x) {
  const std::string x = R"(chip = "head", step = 0, dir = 1, enable = 4, enable_active = "high")";
  std::vector<AxisText> axes{gpio_axis("x", {-1, 60}, x, of_x)};
  for (unsigned i = 0; i < contacts; ++i) {
    const unsigned line = first_contact + contacts + 2 * i;
    axes.push_back(gpio_axis(fmt::format("spare {}", i), {-1, 60},
                             fmt::format("chip = \"head\", step = {}, dir = {}", line, line + 1),
                             home_at(first_contact + i)));
  }
  return rig_text(axes, {.name = "bench", .rate_hz = 10, .more = "step_watch_us = 0\n" + of_rig});
}

const std::string long_move = R"(name = "there"
fps = 25
frames = 200
[[track]]
axes = ["x"]
keys = [ { at = [0] }, { at = [50] } ]
speed = [0, 0, 10, 10, 0, 0]
)";

struct LooseContacts : GpioScene {
  LooseContacts(const std::string& rig, const std::string& command, const std::string& during)
      : GpioScene(
            {.rig = rig,
             .move = long_move,
             .at_zero = {"x"},
             .command = command,
             .during = fmt::format("shake() {{ inbetween_shake_lines $chips/head {} {} & contacts=$!; }}\n{}",
                                   first_contact, contacts, during),
             .bench = {"--gpio", "head:56"},
             .lines = {step, enable, emergency_stop, first_contact}}) {}

  /// x went on until edges were lost, then it stopped, and nobody knows where it is.
  void expect_a_stop_when_edges_were_lost(std::int64_t ticks_to_stop) const {
    EXPECT_EQ(run.status, 4) << run.err;
    const std::vector<std::int64_t> steps = rises(step);
    EXPECT_GT(steps.size(), 50U);
    EXPECT_LT(steps.size(), 450U);
    const std::int64_t begun_ns = rises(first_contact).front();
    EXPECT_GT(steps.back(), begun_ns + fewest_ticks_to_lose * tick_ns) << "nothing was lost yet";
    EXPECT_LT(steps.back(), begun_ns + (ticks_to_lose + ticks_to_stop) * tick_ns);
    ASSERT_THAT(falls(enable), SizeIs(1));
    EXPECT_GT(falls(enable).front(), steps.back());
    EXPECT_FALSE(is_high_at_the_end(enable));
    EXPECT_THAT(positions, HasSubstr("unreferenced x\n"));
  }
};

// The kernel keeps the last 1024 edges of a chip. The emergency stop itself is not touched, but a moment in
// which it was pressed would not be known of any more.
TEST(GpioFault, EdgesThatTheKernelLostOnTheChipOfTheEmergencyStopAreAnEmergencyStop) {
  const LooseContacts scene(rig_with_loose_contacts(emergency_stop_of_head, ""), GpioSceneOptions{}.command,
                            "shake");
  EXPECT_THAT(scene.run.out,
              AllOf(HasSubstr("edges were lost on the chip of the emergency stop, line 6 of chip \"head\""),
                    HasSubstr("find the line that changes so often")));
  EXPECT_FALSE(scene.has_ever_been_high(emergency_stop));
  scene.expect_a_stop_when_edges_were_lost(3);
}

// docs/faults.md 31
TEST(GpioFault, EdgesThatTheKernelLostWhileAnAxisLooksForItsSwitchEndTheHoming) {
  const LooseContacts scene(rig_with_loose_contacts("", home_at(7)),
                            "home --rig rig.toml --positions positions x", "shake");
  EXPECT_THAT(scene.run.out, HasSubstr("bench: axis \"x\": edges of the switches were lost"));
  scene.expect_a_stop_when_edges_were_lost(6);
}

TEST(GpioFault, LinesThatChangeOftenAndAreAllHeardStopNothing) {
  const LooseContacts scene(rig_with_loose_contacts(emergency_stop_of_head, ""), GpioSceneOptions{}.command,
                            "shake; sleep 0.4; kill $contacts");
  EXPECT_EQ(scene.run.status, 0) << scene.run.err << scene.run.out;
  EXPECT_GE(scene.rises(first_contact).size(), 15U);
  EXPECT_THAT(scene.rises(step), SizeIs(500));
  EXPECT_THAT(scene.positions, HasSubstr("at 50 x\n"));
}

// --- lines that cannot be had, on two chips

/// Whoever takes a line of "head" changes a level there: the resistors of the chip pull up two of them, and
/// the drive is off while its ENABLE is high.
const std::string rig_on_two_chips =
    rig_text({gpio_axis("x", {-1, 60}, R"(chip = "head", step = 0, dir = 1, enable = 4)",
                        R"(limit_max = { chip = "head", line = 7, active = "high", bias = "pull-up" })"),
              gpio_axis("y", {-60, 1}, R"(chip = "far", step = 0, dir = 1)",
                        R"(limit_min = { chip = "far", line = 3, active = "high", bias = "none" })")},
             {.name = "bench", .rate_hz = 250, .more = R"(step_watch_us = 0
[emergency_stop]
chip = "head"
line = 6
stops_at = "high"
bias = "pull-up"
[output.lamp]
chip = "far"
line = 2
)"});

/// `head` is watched.
struct TwoChips : GpioScene {
  std::string lines_of_head;  ///< who uses them and how, as gpioinfo says after two seconds

  explicit TwoChips(const std::vector<std::string>& more_of_bench, const std::string& rig = rig_on_two_chips,
                    const std::string& command = GpioSceneOptions{}.command)
      : GpioScene({.rig = rig,
                   .move = move_of_both,
                   .at_zero = {"x", "y"},
                   .command = command,
                   .during = "gpioinfo --chip $(basename $(readlink $chips/head)) >lines_of_head",
                   .bench = {"--gpio", "head:8", "--gpio", "far:4"},
                   .more_of_bench = more_of_bench}),
        lines_of_head(file_contents(path("lines_of_head"))) {}
  void expect_nothing_was_touched() const {
    EXPECT_THAT(record, SizeIs(1)) << "a level has changed";
    EXPECT_THAT(lines_of_head, AllOf(HasSubstr("8 lines"), Not(HasSubstr("output"))));
    EXPECT_THAT(positions, AllOf(HasSubstr("at 0 x\n"), HasSubstr("at 0 y\n")));
  }
};

TEST(GpioFault, ALineThatIsTakenIsSeenToBe) {
  const TwoChips scene({});
  EXPECT_THAT(scene.run.out, HasSubstr("emergency stop is pressed")) << "the chip's own resistor does that";
  EXPECT_GT(scene.record.size(), 1U);
  EXPECT_THAT(scene.lines_of_head, HasSubstr("output"));
}

// docs/faults.md 30
TEST(GpioFault, ALineThatIsBusyOnASecondChipChangesNothingOnTheFirst) {
  const std::string goto_command = "goto --rig rig.toml --positions positions --yes x=10";
  const std::string run_command = GpioSceneOptions{}.command;
  struct Case {
    unsigned line;
    std::string command;
  };
  for (const Case& of :
       {Case{0, run_command}, Case{2, run_command}, Case{3, run_command}, Case{2, goto_command}}) {
    SCOPED_TRACE(fmt::format("line {}, {}", of.line, of.command));
    const TwoChips scene({"--hog", fmt::format("far:{}:fan", of.line)}, rig_on_two_chips, of.command);
    EXPECT_EQ(scene.run.status, 1);
    EXPECT_THAT(scene.run.err, HasSubstr(fmt::format("line {} of chip far is in use by fan", of.line)));
    EXPECT_THAT(scene.run.err, HasSubstr("rig.toml:"));
    scene.expect_nothing_was_touched();
  }
}

// By an offset and by a name, so that only the machine knows.
TEST(GpioFault, ALineThatTheRigMeansTwiceIsRefusedBeforeAnyIsTaken) {
  std::string rig = rig_on_two_chips;
  const std::string by_offset = "[output.lamp]\nchip = \"far\"\nline = 2\n";
  rig.replace(rig.find(by_offset), by_offset.size(), "[output.lamp]\nline = \"LAMP\"\n\n");
  const TwoChips scene({"--name", "far:3:LAMP"}, rig);
  EXPECT_EQ(scene.run.status, 1);
  EXPECT_THAT(scene.run.err,
              AllOf(HasSubstr("rig.toml:10:"),
                    HasSubstr("line 3 of chip \"far\" is used in line 30 already; give each line one use")));
  scene.expect_nothing_was_touched();
}

// --- an output without its chip

TEST(GpioFault, AnOutputThatSaysOnlyTheNameOfItsLinePulsesThere) {
  constexpr unsigned camera = 2, lamp = 1;
  const GpioScene scene({.rig = rig_text({gpio_axis("x", {-1, 60}, R"(chip = "head", step = 0, dir = 1)")},
                                         {.name = "bench", .rate_hz = 250, .more = R"([output.shutter]
line = "CAMERA"
[output.lamp]
chip = "far"
line = 1
)"}),
                         .move = R"(name = "there"
fps = 25
frames = 100
[[track]]
axes = ["x"]
keys = [ { at = [0] }, { at = [50] } ]
speed = [0, 0, 10, 10, 0, 0]
[[cue]]
line = "shutter"
frames = [10, 35, 85]
width_ms = 40
)",
                         .at_zero = {"x"},
                         .command = "run move.toml --rig rig.toml --positions positions --cue-log cues.csv",
                         .bench = {"--gpio", "head:8", "--gpio", "far:4", "--name", "far:2:CAMERA"},
                         .watched = "far",
                         .lines = {lamp, camera}});
  EXPECT_EQ(scene.run.status, 0) << scene.run.err << scene.run.out;
  const std::vector<std::int64_t> rises = scene.rises(camera);
  const std::vector<std::int64_t> falls = scene.falls(camera);
  ASSERT_THAT(rises, SizeIs(3));
  ASSERT_THAT(falls, SizeIs(3));
  // Whoever looks every 0.4 ms is that late.
  const auto about = [](std::int64_t expected_ns) {
    return testing::AllOf(testing::Gt(expected_ns - ms), testing::Lt(expected_ns + ms));
  };
  EXPECT_THAT(rises[1] - rises[0], about(1000 * ms));
  EXPECT_THAT(rises[2] - rises[0], about(3000 * ms));
  for (std::size_t i = 0; i < rises.size(); ++i) EXPECT_THAT(falls[i] - rises[i], about(40 * ms)) << i;
  EXPECT_FALSE(scene.has_ever_been_high(lamp));
  // The log tells how late each was, which the run would not have forgiven beyond a millisecond.
  const std::string one = "[0-9.]+,shutter,%,40,0,[0-9][0-9.e-]*\n";
  std::string log = "seconds,line,frame,width_ms,merged,late_us\n";
  for (const char* const frame : {"10", "35", "85"}) log += std::string(one).replace(one.find('%'), 1, frame);
  EXPECT_THAT(file_contents(scene.path("cues.csv")), testing::MatchesRegex(log));
}

}  // namespace gpio_fault_test
}  // namespace inbetween
