// A move, solved: what a plan knows of axes and units, and at which place of the file it complains.
#include "host_tools/plan/plan.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/plan/drawn_curve.hpp"
#include "tests/support/places.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace plan_test {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

const std::string two_tracks = R"(name = "arc"
fps = "24000/1001"
frames = 48
[[track]]
axes = ["pan", "slide"]
keys = [ { at = [0, 0] }, { at = [30, 40] }, { at = [60, 90] } ]
speed = [0, 0, 10, 0, 0]
weights = [0, 1]
[[track]]
axes = ["focus"]
keys = [ { at = [1] }, { at = [2] } ]
speed = [3]
)";

RigFile rig_of(const std::vector<AxisText>& axes) {
  return parse_rig(rig_text(axes, {.name = "stand"}), "rig.toml");
}

Plan plan_of(const std::string& move, std::optional<RigFile> rig = std::nullopt,
             Solver solver = Solver::closed_form) {
  return {parse_move(move, "move.toml"), std::move(rig), {.solver = solver}};
}

void expect_plan_refused(const std::string& marked, std::initializer_list<std::string_view> words) {
  expect_refused(
      [](std::string_view text, const std::string& file) { Plan(parse_move(text, file), std::nullopt, {}); },
      marked, words);
}

std::vector<std::string> names(const Plan& plan) {
  std::vector<std::string> all;
  for (const PlanAxis& one : plan.axes()) all.push_back(one.name);
  return all;
}

TEST(Plan, WithoutARigAxesComeInTheOrderOfTheTracksAndHaveNoUnit) {
  const Plan plan = plan_of(two_tracks);
  EXPECT_THAT(names(plan), ElementsAre("pan", "slide", "focus"));
  for (const PlanAxis& one : plan.axes()) EXPECT_FALSE(one.unit.has_value());
  EXPECT_EQ(plan.length_unit(0), "");
  EXPECT_THAT(plan.tracks(), SizeIs(2));
  EXPECT_THAT(plan.warnings(), IsEmpty());
}

TEST(Plan, WithARigAxesComeInItsOrderAndThoseInNoTrackToo) {
  const Plan plan =
      plan_of(two_tracks, rig_of({{"focus", "turn"}, {"lift", "mm"}, {"slide", "m"}, {"pan", "deg"}}));
  EXPECT_THAT(names(plan), ElementsAre("focus", "lift", "slide", "pan"));
  EXPECT_EQ(plan.axes()[0].unit, AxisUnit::turn);
  EXPECT_EQ(plan.axes()[0].track, 1U);
  EXPECT_FALSE(plan.axes()[1].track.has_value());
  EXPECT_EQ(plan.axes()[2].track, 0U);
  EXPECT_EQ(plan.axes()[2].track_axis, 1U);
  EXPECT_EQ(plan.axes()[3].track_axis, 0U);
}

TEST(Plan, LastsAsLongAsItsExactRateSays) {
  EXPECT_DOUBLE_EQ(plan_of(two_tracks).duration_s(), 2.002);
}

TEST(Plan, ALengthHasTheUnitOfTheAxesThatCount) {
  const Plan plan = plan_of(two_tracks, rig_of({{"focus", "turn"}, {"slide", "m"}, {"pan", "deg"}}));
  EXPECT_EQ(plan.length_unit(0), "m");  // pan has no weight
  EXPECT_EQ(plan.length_unit(1), "turn");
}

/// A track on the arm of the examples.
Plan plan_on_arm(const std::string& track) {
  const RigFile rig = read_rig_file(in_checkout("examples/arm/rig.toml"));
  const std::string head =
      "name = \"m\"\nfps = 24\nframes = 48\n[[track]]\naxes = [\"shoulder\", \"elbow\"]\n";
  return {parse_move(head + track, "move.toml"),
          rig,
          {.kinematics = std::make_shared<const Kinematics>(read_kinematics(rig))}};
}

// Case 50
TEST(Plan, ATrackWithOneKeyInSpaceOrByDistanceStandsThere) {
  const Plan hand =
      plan_on_arm("space = \"hand\"\nelbow = \"up\"\nspeed = [1]\nkeys = [{ at = [0.4, 0.1, 0] }]\n");
  const Plan twice = plan_on_arm(
      "space = \"hand\"\nelbow = \"up\"\nspeed = [1]\nkeys = [{ at = [0.4, 0.1, 0] }, "
      "{ at = [0.4, 0.1, 0] }]\n");
  const Plan angles = plan_on_arm("distance = \"hand\"\nspeed = [1]\nkeys = [{ at = [10, 80] }]\n");
  for (const double frame : {0.0, 20.0, 48.0}) {
    std::array<double, 2> at{};
    std::array<double, 2> of_twice{};
    hand.motion().positions({static_cast<std::int32_t>(frame), 0}, at);
    twice.motion().positions({static_cast<std::int32_t>(frame), 0}, of_twice);
    EXPECT_EQ(at, of_twice);
    angles.motion().positions({static_cast<std::int32_t>(frame), 0}, at);
    EXPECT_EQ(at, (std::array<double, 2>{10, 80}));
  }
  EXPECT_FALSE(angles.is_moving(0, RollEnd::before)) << "it stands, whatever its speed curve says";
}

// Case 51
TEST(Plan, ACurveThroughOneValueIsThatThroughTwoEqualOnes) {
  for (const char* more : {"rest = \"both\"", "ease_in = 8", "ease_out = 3", ""}) {
    const auto values = [&](const char* speed) {
      const std::string text = fmt::format(
          "name = \"m\"\nfps = 24\nframes = 48\n[[track]]\naxes = [\"a\"]\nkeys = [{{ at "
          "= [0] }}, {{ at = [9] }}]\nthrough = true\nspeed = {}\n{}\n",
          speed, more);
      const MoveFile move = parse_move(text, "move.toml");
      return drawn_curve(move.tracks[0], move.frames);
    };
    EXPECT_EQ(values("[10]"), values("[10, 10]")) << more;
  }
}

TEST(Plan, SaysAtOnceThatAKeyIsOutsideItsAxis) {
  const Plan plan = plan_on_arm("speed = [0, 0, 1, 0, 0]\nkeys = [{ at = [0, 80] }, { at = [20, 200] }]\n");
  EXPECT_TRUE(plan.warnings().empty()) << "check and run refuse it";
  ASSERT_EQ(plan.keys_outside().size(), 1U);
  EXPECT_THAT(plan.keys_outside()[0].message,
              testing::HasSubstr("key 1: axis \"elbow\" is at 200 deg, outside -150..150 deg"));
}

TEST(Plan, WarnsThatMillimetresCountAsDegreesWhereNobodySaidOtherwise) {
  const RigFile rig = rig_of({{"focus", "turn"}, {"slide", "mm"}, {"pan", "deg"}});
  const std::string unweighted = with(two_tracks, "weights = [0, 1]\n", "");
  const Plan plan = plan_of(unweighted, rig);
  ASSERT_THAT(plan.warnings(), SizeIs(1));
  EXPECT_EQ(
      to_string(plan.warnings().front()),
      "move.toml:4:1: warning: 1 mm counts as 1 deg of distance along this track; give weights, one per "
      "axis, to say otherwise");
  EXPECT_EQ(plan.length_unit(0), "");
  const std::string weighted = with(two_tracks, "weights = [0, 1]", "weights = [1, 1]");
  EXPECT_THAT(plan_of(weighted, rig).warnings(), IsEmpty());
}

TEST(Plan, WarnsOfEveryUnitOfATrack) {
  const std::string move = R"(name = "m"
fps = 24
frames = 2
[[track]]
axes = ["a", "b", "c"]
keys = [ { at = [0, 0, 0] }, { at = [1, 1, 1] } ]
speed = [1]
)";
  const Plan plan = plan_of(move, rig_of({{"a", "mm"}, {"b", "turn"}, {"c", "deg"}}));
  ASSERT_THAT(plan.warnings(), SizeIs(1));
  EXPECT_THAT(plan.warnings().front().message,
              testing::StartsWith("1 mm and 1 turn count as 1 deg of distance along this track"));
}

TEST(Plan, EveryTrackTravelsItsWholePath) {
  for (const Solver solver : {Solver::closed_form, Solver::runge_kutta}) {
    const Plan plan = plan_of(two_tracks, std::nullopt, solver);
    for (const SolvedTrack& solved : plan.tracks()) {
      EXPECT_EQ(solved.integrated().has_value(), solver == Solver::runge_kutta);
      EXPECT_EQ(solved.table().frames(), 48);
      EXPECT_TRUE(check_invariants(solved.track(), solved.table()));
    }
  }
}

TEST(Plan, AnAxisThatTheRigDoesNotHaveIsNamedWithThoseThatItHas) {
  expect_refused(
      [](std::string_view text, const std::string& file) {
        Plan(parse_move(text, file), rig_of({{"slide", "mm"}, {"pan", "deg"}}), {});
      },
      with(two_tracks, "[\"focus\"]", "[@\"focus\"]"), {"\"stand\"", "\"focus\"", "it has slide, pan"});
}

TEST(Plan, AMoveWithMoreTicksThanAnyRigPlaysIsRefused) {
  expect_refused(
      [](std::string_view text, const std::string& file) {
        Plan(parse_move(text, file), rig_of({{"slide", "mm"}, {"pan", "deg"}, {"focus", "turn"}}), {});
      },
      with(with(two_tracks, "24000/1001", "1/1000000"), "48", "@48"),
      {"5000000000 ticks", "100 Hz", "lower"});
}

TEST(Plan, NoSpeedOnARealPathNamesTheSpeedCurve) {
  expect_plan_refused(with(two_tracks, "[0, 0, 10, 0, 0]", "@[0, 0]"), {"zero everywhere", "raise"});
}

TEST(Plan, NoSpeedIsFineWhereThereIsNoDistance) {
  const std::string still = with(with(two_tracks, "[2]", "[1]"), "[3]", "[0]");
  EXPECT_EQ(plan_of(still).tracks()[1].track().constant(), 0);
}

TEST(Plan, AnAxisThatMovesOnAPathWithoutLengthNamesKeyAndAxis) {
  const std::string move = with(two_tracks, "{ at = [0, 0] }, { at = [30, 40] }",
                                "{ at = [0, 0] }, { at = [@30, 40] }, { at = [31, 40] }");
  expect_plan_refused(move, {"axis \"pan\"", "key 1"});
}

/// A bend with a key that is met on a frame, once by a lock and once as a curve over frames.
std::string bend_in(int frames, int met, const std::string& timing) {
  return fmt::format(
      "name = \"bend\"\nfps = 24\nframes = {}\n[[track]]\naxes = [\"pan\", \"tilt\"]\n"
      "keys = [ {{ at = [0, 0], frame = 0 }}, {{ at = [30, 40], frame = {} }}, {{ at = [60, 10], frame = {} "
      "}} ]\n{}\n",
      frames, met, frames, timing);
}

std::vector<double> positions_of(const Plan& plan) {
  std::vector<double> all;
  const Track& track = plan.tracks()[0].track();
  std::vector<AxisMotion> motion(2);
  for (std::int32_t frame = 0; frame <= plan.move().frames; ++frame) {
    static_cast<void>(track.motion({frame, 0}, motion));
    for (const AxisMotion& axis : motion) all.push_back(axis.position);
  }
  return all;
}

TEST(Plan, OfTheSameKeysInOtherFramesIsTheOneThatIsSolvedAnew) {
  for (const std::string timing :
       {"speed = [0, 0, 10, 4, 10, 0, 0]", "timing = \"frames\"", "timing = \"frames\"\nkinetic = \"pace\"",
        "timing = \"frames\"\nkinetic = \"monotone\""}) {
    const Plan drawn = plan_of(bend_in(48, 12, timing));
    const std::string other = bend_in(60, 40, timing);
    const Plan plan(parse_move(other, "move.toml"), drawn);
    EXPECT_EQ(positions_of(plan), positions_of(plan_of(other))) << timing;
  }
}

}  // namespace plan_test
}  // namespace inbetween
