// A shoot as somebody at a terminal goes through it: stopped, looked at backward, gone on with.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"
#include "tests/support/terminal_screen.hpp"

namespace inbetween {
namespace shoot_scene_test {

using testing::HasSubstr;

const std::string head_rig =
    rig_text({axis_text("pan", "deg", {-90, 90}, {.velocity = 100, .acceleration = 1000}, "",
                        R"(type = "pipe", path = "/dev/null", counts_per_unit = 1000)")},
             {.name = "head"});
const std::string turn = R"(name = "turn"
fps = 24
frames = 47
[[track]]
axes = ["pan"]
keys = [{ at = [0] }, { at = [20] }]
speed = [0, 0, 10, 10, 0, 0]
)";

/// "21 2 1" of a line of the log: the frame, how often it was shot, and whether it is whole.
std::vector<std::string> exposures(const std::string& log) {
  std::istringstream file(file_contents(log));
  std::vector<std::string> all;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    std::string at, frame, shots, whole;
    std::getline(cells, at, ',');
    std::getline(cells, frame, ',');
    std::getline(cells, shots, ',');
    std::getline(cells, whole);
    all.push_back(frame + " " + shots + " " + whole);
  }
  return all;
}

/// Somebody with the keys of a shoot, who waits until each has done what it does.
struct Animator {
  TerminalScreen& screen;

  void press(const std::string& key, const std::string& shown) {
    screen.press(key);
    screen.wait_for(shown);
  }
  void shoot_until(int last) {
    for (++frame; frame <= last; ++frame) press("Space", "waiting  frame " + std::to_string(frame) + " ");
    frame = last;
  }
  int frame = -1;
};

TEST(ShootScene, StoppedLookedAtGoneOnWithOneFrameAgainAndOneSkipped) {
  const TemporaryFolder folder;
  const std::string log = folder.path() / "log.csv", report = folder.path() / "report.json";
  const std::string rig = folder.path() / "rig.toml", move = folder.path() / "move.toml";
  std::ofstream(rig) << head_rig;
  std::ofstream(move) << turn;
  TerminalScreen screen({"run", move, "--rig", rig, "--sim", "--step", "--settle", "0", "--exposure", "0.02",
                         "--shoot-log", log, "--json", report});
  Animator animator{screen};
  screen.wait_for("standing  frame 0 ");
  EXPECT_EQ(exposures(log).size(), 0U) << "nothing is exposed before somebody asks";
  animator.shoot_until(20);
  animator.press("Escape", "stopped: press a");
  animator.press("a", "Enter starts from here");
  animator.press("Enter", "standing  frame 20 ");
  EXPECT_EQ(exposures(log).size(), 21U) << "and none again because it was stopped";
  for (const char* looked : {"19", "18", "17"}) {
    animator.press("Left", std::string("standing  frame ") + looked + " ");
  }
  animator.shoot_until(25);
  animator.press("e", "27 shot");
  animator.shoot_until(29);
  animator.press("Right", "standing  frame 30 ");
  animator.press("Right", "standing  frame 31 ");
  animator.frame = 30;
  animator.shoot_until(47);
  screen.press("Space");
  EXPECT_EQ(screen.wait_for_exit(), 5);
  EXPECT_THAT(screen.shown(),
              HasSubstr("frames 0..47: 48 due, 47 shot, 1 of them again, 1 skipped; go on with --resume\n"));

  std::vector<std::string> expected;
  for (int frame = 0; frame <= 47; ++frame) {
    if (frame != 30) expected.push_back(std::to_string(frame) + " 1 1");
    if (frame == 25) expected.emplace_back("25 2 1");
  }
  EXPECT_EQ(exposures(log), expected);
  const auto shoot = nlohmann::ordered_json::parse(file_contents(report))["shoot"];
  EXPECT_EQ(shoot.dump(), R"({"first":0,"last":47,"due":48,"shot":47,"shot_again":1,"skipped":1,"left":0,)"
                          R"("cut_off":0,"last_shot":47})");
}

}  // namespace shoot_scene_test
}  // namespace inbetween
