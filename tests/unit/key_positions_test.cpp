#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/rig_text.hpp"
#include "tests/support/run_on.hpp"
#include "tests/support/temporary_file.hpp"

/// Where a key is, as an author writes it: by name, in any unit, and as a direction of a rotary axis.

namespace inbetween {
namespace key_positions_test {

using Json = nlohmann::json;
using testing::HasSubstr;

const std::string drive = R"(type = "pipe", path = "/dev/null", counts_per_unit = 100)";
const std::string rig = rig_text(
    {axis_text("track", "mm", {-100'000, 100'000}, {.velocity = 5000, .acceleration = 20'000}, "", drive),
     axis_text("pan", "deg", {-1080, 1080}, {.velocity = 2000, .acceleration = 20'000}, "", drive)},
    {.rate_hz = 250});

std::string move_of(const std::string& track) {
  return "name = \"move\"\nfps = 24\nframes = 96\n[[track]]\n" + track + "\nspeed = [0, 0, 10, 0, 0]\n";
}
const std::string both = "axes = [\"track\", \"pan\"]\nweights = [1, 1]\n";
const std::string pan = "axes = [\"pan\"]\n";

/// Of an axis at every key of track 0.
std::vector<double> keys_of(const std::string& text, std::size_t axis) {
  const ProgramRun run = run_on(rig, "plan", text, {"--json", "-"});
  EXPECT_EQ(run.status, 0) << run.err;
  std::vector<double> keys;
  if (run.status != 0) return keys;
  const Json plan = Json::parse(run.out);
  for (const Json& segment : plan["tracks"][0]["segments"]) {
    keys.push_back(segment["coefficients"][axis][0].get<double>());
  }
  keys.push_back(plan["axes"][axis]["position"].back().get<double>());
  return keys;
}

void expect_refused(const std::string& text, const std::string& words) {
  const ProgramRun run = run_on(rig, "plan", text);
  EXPECT_EQ(run.status, 1) << text;
  EXPECT_THAT(run.err, HasSubstr(words));
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
}

TEST(KeyPositions, AnAxisThatAKeyLeavesOutKeepsItsValue) {
  const std::string named = move_of(both +
                                    "keys = [{ at = { pan = 30, track = 5 } }, { at = { track = 50 } }, "
                                    "{ at = { pan = -20 } }, { at = [0, 0] }]");
  EXPECT_EQ(keys_of(named, 0), (std::vector<double>{5, 50, 50, 0}));
  EXPECT_EQ(keys_of(named, 1), (std::vector<double>{30, 30, -20, 0}));
}

TEST(KeyPositions, TheFirstKeyNamesEveryAxisAndNoKeyAnother) {
  expect_refused(move_of(both + "keys = [{ at = { pan = 30 } }, { at = [0, 0] }]"),
                 "leaves out axis \"track\", which has no key before to keep its value from; name every axis "
                 "in the first key");
  expect_refused(move_of(both + "keys = [{ at = [0, 0] }, { at = { pin = 30 } }]"), "did you mean \"pan\"?");
}

TEST(KeyPositions, UnitsAreConvertedToThoseOfTheRig) {
  constexpr double turn_in_rad = 2 * std::numbers::pi;
  const std::string text = move_of(
      both +
      "unit = { track = \"ft\" }\nkeys = [{ at = [1, 0] }, { at = [3, 0], unit = { track = \"in\" } }, "
      "{ at = { track = 2.5 }, unit = { track = \"cm\" } }, { at = { pan = 1 }, unit = { pan = \"rad\" } "
      "}, { at = [-1, 0.25], unit = { track = \"m\", pan = \"turn\" } }]");
  const std::vector<double> track = keys_of(text, 0);
  const std::vector<double> angle = keys_of(text, 1);
  ASSERT_EQ(track.size(), 5U);
  const std::vector<double> wanted{304.8, 76.2, 25, 25, -1000};
  for (std::size_t k = 0; k < wanted.size(); ++k) EXPECT_NEAR(track[k], wanted[k], 1e-12 * 1000) << k;
  EXPECT_NEAR(angle[3], 360 / turn_in_rad, 1e-12);
  EXPECT_EQ(angle[4], 90);
}

TEST(KeyPositions, ALengthIsNoAngleAndAnUnknownUnitIsNamed) {
  expect_refused(move_of(pan + "unit = \"ft\"\nkeys = [{ at = [1] }, { at = [3] }]"),
                 "axis \"pan\" is given in ft, and it counts deg in the rig");
  expect_refused(move_of(pan + "unit = \"yd\"\nkeys = [{ at = [1] }, { at = [3] }]"),
                 "unit is \"yd\"; write \"mm\", \"cm\", \"m\", \"in\", \"ft\", \"deg\", \"rad\" or \"turn\"");
}

TEST(KeyPositions, WithoutARigAnAxisCountsInTheUnitOfItsKeys) {
  const std::string text =
      move_of("axes = [\"track\"]\nunit = \"cm\"\nkeys = [{ at = [1] }, { at = [1], unit = \"in\" }]");
  const TemporaryFile file("move.toml", text);
  const ProgramRun run = run_program({"plan", file.path().string(), "--json", "-"});
  ASSERT_EQ(run.status, 0) << run.err;
  const Json axis = Json::parse(run.out)["axes"][0];
  EXPECT_EQ(axis["unit"], "mm");
  EXPECT_EQ(axis["position"].front(), 10);
  EXPECT_NEAR(axis["position"].back().get<double>(), 25.4, 1e-12);
  const TemporaryFile half("move.toml",
                           move_of("axes = [\"track\"]\nkeys = [{ at = [1] }, { at = [1], unit = \"in\" }]"));
  const ProgramRun refused = run_program({"plan", half.path().string()});
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("in the unit of the rig, which is not known"));
}

/// The oracle: of all positions that show the direction, a `way` is so many turns from the nearest.
TEST(KeyPositions, ARotaryAxisGoesTheShortWayTheLongWayOrSoManyTurns) {
  struct Case {
    double from, to;
    std::string way;
    double arrives;
  };
  const std::vector<Case> cases = {{350, 10, "", 370},
                                   {350, 10, ", way = \"short\"", 370},
                                   {350, 10, ", way = \"long\"", 10},
                                   {350, 10, ", turns = 1", 730},
                                   {350, 10, ", turns = -1", 10},
                                   {10, 350, "", -10},
                                   {10, -10, ", way = \"long\"", 350},
                                   {0, 0, ", turns = 2", 720},
                                   {0, 0, ", turns = -2", -720},
                                   {0, 180, ", turns = 0", 180},
                                   {0, 180, ", turns = -1", -180},
                                   {90, -90, ", turns = 0", 270}};
  for (const Case& c : cases) {
    const std::string text = move_of(pan + "wrap = 360\nkeys = [{ at = [" + std::to_string(c.from) +
                                     "] }, { at = [" + std::to_string(c.to) + "]" + c.way + " }]");
    const std::vector<double> keys = keys_of(text, 0);
    ASSERT_EQ(keys.size(), 2U);
    EXPECT_EQ(keys[1], c.arrives) << c.from << " to " << c.to << c.way;
  }
}

TEST(KeyPositions, ADirectionGoesOnFromKeyToKeyAndByName) {
  const std::string text = move_of(
      both +
      "wrap = { pan = 360 }\nkeys = [{ at = [0, 0] }, { at = { pan = 120 } }, { at = { pan = 240 } }, "
      "{ at = { pan = 0 } }, { at = { track = 10 } }, { at = { track = 20 }, turns = { pan = -1 } }]");
  EXPECT_EQ(keys_of(text, 1), (std::vector<double>{0, 120, 240, 360, 360, 0}));
  const std::string in_turns =
      move_of(pan + "unit = \"turn\"\nwrap = 1\nkeys = [{ at = [0.25] }, { at = [0], turns = 1 }]");
  EXPECT_EQ(keys_of(in_turns, 0), (std::vector<double>{90, 360}));
}

TEST(KeyPositions, WhatADirectionDoesNotSayIsRefused) {
  const auto keys = [&](const std::string& list) {
    return move_of(pan + "wrap = 360\nkeys = [" + list + "]");
  };
  expect_refused(keys("{ at = [0] }, { at = [180] }"),
                 "half a turn to go, and neither way is shorter; write turns = 0 to go up, or turns = -1");
  expect_refused(keys("{ at = [0] }, { at = [720] }"),
                 "720 is not within one turn; write 0, and turns = ...");
  expect_refused(keys("{ at = [0] }, { at = [360] }"),
                 "360 is not within one turn; write 0, and turns = ...");
  expect_refused(keys("{ at = [0], turns = 1 }, { at = [10] }"), "nothing leads there");
  expect_refused(keys("{ at = [0] }, { at = [10], turns = 1, way = \"long\" }"), "remove one of the two");
  expect_refused(move_of(pan + "keys = [{ at = [0] }, { at = [10], turns = 1 }]"), "wrap = 360");
}

TEST(KeyPositions, TurnsBeyondALimitAreRefusedBeforeAnythingMoves) {
  const std::string text =
      move_of(pan + "wrap = 360\nkeys = [{ at = [0] }, { at = [0], turns = 4 }]");  // the rig ends at 1080
  const ProgramRun run = run_on(rig, "run", text, {"--sim", "--fast"});
  EXPECT_EQ(run.status, 3);
  EXPECT_THAT(run.err, HasSubstr("1440"));
  EXPECT_EQ(run.out, "");
}

TEST(KeyPositions, TurnsThatADriveCannotCountAreRefusedWithTheRig) {
  std::string long_rig = rig;
  long_rig.replace(long_rig.find("max = 1080"), 10, "max = 36000000");
  const ProgramRun run =
      run_on(long_rig, "check", move_of(pan + "wrap = 360\nkeys = [{ at = [0] }, { at = [90] }]"));
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, HasSubstr("count"));
}

TEST(KeyPositions, ARunGoesOnOverWholeTurns) {
  const TemporaryFolder folder;
  const std::string record = (folder.path() / "record.csv").string();
  const std::string text = move_of(pan + "wrap = 360\nkeys = [{ at = [0] }, { at = [0], turns = 2 }]");
  const ProgramRun run = run_on(rig, "run", text, {"--sim", "--fast", "--record", record});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("720.0000"));
}

TEST(KeyPositions, AFitLeavesKeysByNameAsTheirAuthorWroteThem) {
  const TemporaryFolder folder;
  const std::string fitted = (folder.path() / "fitted.toml").string();
  const std::string keys =
      "unit = { track = \"ft\" } # as in the script\nwrap = { pan = 360 }\n"
      "keys = [{ at = { track = 0, pan = 350 } }, { at = { pan = 10 } }, # round the corner\n"
      "{ at = { track = 40.5 }, unit = { track = \"ft\" } }, { at = { pan = 90 }, turns = { pan = 1 } }]";
  const std::string text = "name = \"move\"\nfps = 24\nframes = 150\n[[track]]\n" + both + keys +
                           "\nspeed = [0, 0, 1, 30, 1, 0, 0]\n";
  const ProgramRun run = run_on(rig, "check", text, {"--fit", fitted});
  ASSERT_EQ(run.status, 0) << run.err;
  const std::string written = file_contents(fitted);
  EXPECT_THAT(written, HasSubstr(keys));
  EXPECT_NE(written, text) << "the curve was to be fitted";
  EXPECT_EQ(run_on(rig, "check", written).status, 0);
}

}  // namespace key_positions_test
}  // namespace inbetween
