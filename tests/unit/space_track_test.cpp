// Keys in the world: the axes follow a path of the hand or of the camera. By the program itself, and measured
// with another library's kinematics.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "host_tools/check/planned_stops.hpp"
#include "host_tools/plan/plan.hpp"
#include "inbetween/play/playhead.hpp"
#include "tests/support/example_joints.hpp"
#include "tests/support/oracle_kinematics.hpp"
#include "tests/support/places.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace space_track_test {

using Json = nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using Vector = std::array<double, 3>;

constexpr double degree = 0.017453292519943295;
constexpr Vector puppet = {4.2, 2.4, 1};

double size(const Vector& v) {
  return std::hypot(v[0], v[1], v[2]);
}
Vector difference(const Vector& a, const Vector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// Between the lens and the puppet, or another point, in degrees.
double aim_error(const OraclePose& pose, const Vector& point = puppet) {
  const Vector sight = difference(point, pose.position);
  const Vector& lens = pose.columns[0];
  const Vector cross = {lens[1] * sight[2] - lens[2] * sight[1], lens[2] * sight[0] - lens[0] * sight[2],
                        lens[0] * sight[1] - lens[1] * sight[0]};
  const double along = lens[0] * sight[0] + lens[1] * sight[1] + lens[2] * sight[2];
  return std::atan2(size(cross), along) / degree;
}

Json planned(const std::string& move, const std::string& rig) {
  const ProgramRun run = run_program({"plan", move, "--rig", rig, "--per", "tick", "--json", "-"});
  EXPECT_EQ(run.status, 0) << run.err;
  return Json::parse(run.out);
}

std::vector<double> row_of(const Json& json, const char* what, std::size_t row) {
  std::vector<double> numbers;
  for (const Json& axis : json.at("axes")) numbers.push_back(axis.at(what).at(row).get<double>());
  return numbers;
}

Vector vector_of(const std::vector<double>& numbers) {
  return {numbers.at(0), numbers.at(1), numbers.at(2)};
}

/// A rig of three slides along x, y and z, in metres: a move on it draws the same path without any joints.
const std::string slides = rig_text(
    {{.name = "x", .unit = "m"}, {.name = "y", .unit = "m"}, {.name = "z", .unit = "m"}}, {.rate_hz = 250});

/// The text without the lines that begin with one of these words, and with axes x, y, z.
std::string drawn_text(const std::string& text) {
  std::string drawn;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
    std::string line = text.substr(begin, end - begin);
    begin = end;
    const auto starts = [&](const char* word) { return line.starts_with(word); };
    if (starts("space") || starts("elbow") || starts("aim") || starts("near")) continue;
    if (starts("axes")) line = "axes = [\"x\", \"y\", \"z\"]\n";
    const std::size_t roll = line.find(", roll = 0");
    if (roll != std::string::npos) line.erase(roll, 10);
    drawn += line;
  }
  return drawn;
}

struct Worst {
  double off_share = 0;    // of the length
  double speed_share = 0;  // of the drawn speed, where that is above a hundredth of the fastest
};

/// How far the link of the oracle is from the path that is drawn, at every tick.
Worst worst_of(const Json& followed, const Json& drawn, const OracleTree& tree, int link) {
  Worst worst;
  const double length = drawn.at("tracks")[0].at("length").get<double>();
  const std::size_t rows = drawn.at("axes")[0].at("position").size();
  EXPECT_EQ(followed.at("axes")[0].at("position").size(), rows);
  double fastest = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    fastest = std::max(fastest, size(vector_of(row_of(drawn, "velocity", row))));
  }
  for (std::size_t row = 0; row < rows; ++row) {
    const std::vector<double> axes = row_of(followed, "position", row);
    const Vector wanted = vector_of(row_of(drawn, "position", row));
    worst.off_share =
        std::max(worst.off_share, size(difference(tree.pose(link, axes).position, wanted)) / length);
    const OracleTwist twist =
        tree.motion(link, axes, row_of(followed, "velocity", row), row_of(followed, "acceleration", row))
            .velocity;
    const double speed = size(vector_of(row_of(drawn, "velocity", row)));
    if (speed < fastest / 100) continue;
    worst.speed_share =
        std::max(worst.speed_share, std::fabs(size({twist[0], twist[1], twist[2]}) / speed - 1));
  }
  return worst;
}

Worst worst_of_example(const std::string& name, const std::string& rig, const OracleTree& tree, int link) {
  const std::string move = in_checkout(name);
  const TemporaryFile drawn("drawn.toml", drawn_text(file_contents(move)));
  const TemporaryFile slides_file("slides.toml", slides);
  const Worst worst =
      worst_of(planned(move, in_checkout(rig)), planned(drawn.path(), slides_file.path()), tree, link);
  testing::Test::RecordProperty(name + " off", fmt::format("{:.3g}", worst.off_share));
  fmt::print("{}: off {:.3g} of the length, speed {:.3g}\n", name, worst.off_share, worst.speed_share);
  return worst;
}

TEST(SpaceTrack, TheHandGoesWhereItIsDrawnWithItsElbowOnTheSideThatIsAsked) {
  const OracleTree tree(joints_of_arm());
  for (const auto& [side, sign] : {std::pair("up", -1), std::pair("down", 1)}) {
    const std::string name = fmt::format("examples/arm/hand_elbow_{}.toml", side);
    const Worst worst = worst_of_example(name, "examples/arm/rig.toml", tree, 2);
    EXPECT_LE(worst.off_share, 1e-6) << name;
    EXPECT_LE(worst.speed_share, 1e-4) << name;
    const Json json = planned(in_checkout(name), in_checkout("examples/arm/rig.toml"));
    for (const Json& elbow : json.at("axes")[1].at("position"))
      ASSERT_GT(sign * elbow.get<double>(), 20) << name;
  }
}

TEST(SpaceTrack, TheCraneCarriesItsCameraAlongThePathAndLooksAtThePuppet) {
  const OracleTree tree(joints_of_crane());
  const std::string name = "examples/crane/round_the_puppet.toml";
  const Worst worst = worst_of_example(name, "examples/crane/rig.toml", tree, 7);
  EXPECT_LE(worst.off_share, 1e-6);
  EXPECT_LE(worst.speed_share, 1e-4);
  const Json json = planned(in_checkout(name), in_checkout("examples/crane/rig.toml"));
  double aim = 0;
  for (std::size_t row = 0; row < json.at("axes")[0].at("position").size(); ++row) {
    const OraclePose pose = tree.pose(7, row_of(json, "position", row));
    aim = std::max(aim, aim_error(pose));
    ASSERT_NEAR(pose.columns[1][2], 0, 1e-6) << "the horizon is level";
  }
  fmt::print("aim {:.3g} deg\n", aim);
  EXPECT_LE(aim, 0.01);
}

/// Of the camera at the places of a playhead, in degrees.
class AimWatch {
 public:
  explicit AimWatch(const Plan& plan) : plan_(plan), positions_(plan.played().axis_count()) {}
  void take(const Playhead& playhead) {
    plan_.motion().positions(playhead.time(), positions_);
    std::vector<double> axes(positions_.size());
    for (std::size_t d = 0; d < axes.size(); ++d) axes[plan_.axis_of(d)] = positions_[d];
    const double lift = axes.size() > 6 ? axes[6] / 1000 : 0;
    const Vector there = {puppet[0], puppet[1], puppet[2] + lift};
    worst_ = std::max(worst_, aim_error(tree_.pose(7, {axes.begin(), axes.begin() + 6}), there));
    ++places_;
  }
  [[nodiscard]] double worst() const { return worst_; }
  [[nodiscard]] int places() const { return places_; }

 private:
  const Plan& plan_;
  OracleTree tree_{joints_of_crane()};
  std::vector<double> positions_;
  double worst_ = 0;
  int places_ = 0;
};

/// Plays, stops, plays backward and stops again.
void expect_aim_in_stops(const Plan& plan, const char* what) {
  const PlannedStops stops(plan);
  ASSERT_TRUE(stops.bounds());
  Playhead playhead(plan.played(), *stops.bounds(), plan.rig()->rate_hz);
  AimWatch watch(plan);
  const auto run = [&](int ticks) {
    for (int i = 0; i < ticks && !(i > 0 && playhead.is_resting()); ++i) {
      playhead.tick();
      watch.take(playhead);
    }
  };
  ASSERT_TRUE(playhead.play(Direction::forward));
  run(1200);
  playhead.stop();
  run(100'000);
  ASSERT_TRUE(playhead.is_resting());
  ASSERT_TRUE(playhead.play(Direction::backward));
  run(700);
  playhead.stop();
  run(100'000);
  ASSERT_TRUE(playhead.is_resting());
  EXPECT_GT(watch.places(), 1900);
  EXPECT_GT(watch.worst(), 0);
  EXPECT_LE(watch.worst(), 0.01);
  fmt::print("aim at {} in a stop and in reverse {:.3g} deg\n", what, watch.worst());
}

TEST(SpaceTrack, TheCraneHoldsItsAimInAControlledStopAndInReverse) {
  const RigFile rig = read_rig_file(in_checkout("examples/crane/rig.toml"));
  const auto kinematics = std::make_shared<const Kinematics>(read_kinematics(rig));
  expect_aim_in_stops(
      {read_move_file(in_checkout("examples/crane/round_the_puppet.toml")), rig, {.kinematics = kinematics}},
      "what rests");
}

TEST(SpaceTrack, EveryExampleInSpaceKeepsTheLimitsOfItsRig) {
  for (const auto& [move, rig] :
       {std::pair("examples/arm/hand_elbow_up.toml", "examples/arm/rig.toml"),
        std::pair("examples/arm/hand_elbow_down.toml", "examples/arm/rig.toml"),
        std::pair("examples/crane/round_the_puppet.toml", "examples/crane/rig.toml")}) {
    const ProgramRun run = run_program({"check", in_checkout(move), "--rig", in_checkout(rig)});
    EXPECT_EQ(run.status, 0) << run.out << run.err;
  }
}

TEST(SpaceTrack, ACurveThatFitsIsFoundAndShownForAMoveInSpace) {
  const TemporaryFile move(
      "short.toml", with(file_contents(in_checkout("examples/crane/round_the_puppet.toml")), "frames = 288",
                         "frames = 130"));
  const TemporaryFile fitted("fitted.toml", "");
  const TemporaryFile picture("limits.svg", "");
  const std::string rig = in_checkout("examples/crane/rig.toml");
  const ProgramRun run =
      run_program({"check", move.path(), "--rig", rig, "--fit", fitted.path(), "--plot", picture.path()});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run_program({"check", fitted.path(), "--rig", rig}).status, 0);
  EXPECT_THAT(file_contents(picture.path()), HasSubstr("<svg"));
}

TEST(SpaceTrack, PlanAndCheckSayHowFarTheAxesCanBeFromWhatIsDrawn) {
  const std::string move = in_checkout("examples/crane/round_the_puppet.toml");
  const std::string rig = in_checkout("examples/crane/rig.toml");
  for (const char* command : {"plan", "check"}) {
    EXPECT_THAT(run_program({command, move, "--rig", rig}).out,
                testing::ContainsRegex("\"camera\" in space: within 0[.][0-9]+ um of its path, its speed "
                                       "within [0-9.e-]+ of what is drawn, its aim within [0-9.e-]+ deg "
                                       "\\(proven, between all of [0-9]+ places\\)"))
        << command;
  }
}

TEST(SpaceTrack, DistanceAtATipMakesTheDrawnSpeedThatOfTheTip) {
  const std::string text = with(with(file_contents(in_checkout("examples/arm/reach_over.toml")),
                                     "spline = \"smooth\"", "distance = \"hand\""),
                                "speed = [0, 0, 8, 10, 8, 10, 8, 0, 0]", "speed = [5]");
  const TemporaryFile move("even.toml", text);
  const OracleTree tree(joints_of_arm());
  const Json json = planned(move.path(), in_checkout("examples/arm/rig.toml"));
  const std::size_t rows = json.at("axes")[0].at("position").size();
  const double speed = json.at("tracks")[0].at("length").get<double>() / 6;
  int compared = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    const auto motion = tree.motion(2, row_of(json, "position", row), row_of(json, "velocity", row),
                                    row_of(json, "acceleration", row));
    const double found = std::hypot(motion.velocity[0], motion.velocity[1], motion.velocity[2]);
    if (found < speed * (1 - 1e-4) && compared == 0) continue;  // its pre-roll
    if (++compared > 1500) break;
    ASSERT_NEAR(found / speed, 1, 1e-4) << row;
  }
  EXPECT_GT(compared, 1400);
}

/// The arm's example with one thing changed, and why it is refused.
std::string refusal(const std::string& example, const std::string& rig, const std::string& from,
                    const std::string& to) {
  const TemporaryFile move("move.toml", with(file_contents(in_checkout(example)), from, to));
  const ProgramRun run = run_program({"plan", move.path(), "--rig", in_checkout(rig)});
  EXPECT_EQ(run.status, 1) << run.out;
  EXPECT_EQ(std::ranges::count(run.err, '\n'), 1) << run.err;
  return run.err;
}
std::string refusal_of_arm(const std::string& from, const std::string& to) {
  return refusal("examples/arm/hand_elbow_up.toml", "examples/arm/rig.toml", from, to);
}

TEST(SpaceTrack, AMillimetreBeyondTheReachIsRefusedWithFrameJointAndDistance) {
  EXPECT_THAT(refusal_of_arm("[-150.0,  380.0, 0.0]", "[0.0,  551.0, 0.0]"),
              AllOf(HasSubstr("frame 125.00"), HasSubstr("1 mm beyond"), HasSubstr("\"elbow\"")));
}

TEST(SpaceTrack, AMillimetreAwayFromThePlaneOfTheArmIsRefused) {
  EXPECT_THAT(refusal_of_arm("[-150.0,  380.0, 0.0]", "[-150.0,  380.0, 1.0]"),
              HasSubstr("mm beyond what axis"));
}

TEST(SpaceTrack, ASingularPlaceIsRefusedWithFrameAndJoint) {
  // Straight below the camera of a crane: pan may be anything.
  EXPECT_THAT(refusal("examples/crane/round_the_puppet.toml", "examples/crane/rig.toml",
                      "aim    = \"puppet\"", "aim    = [3.3, 1.5, 0.2]"),
              AllOf(HasSubstr("frame "), HasSubstr("\"pan\""), HasSubstr("singular")));
}

/// A head that pans and tilts over the top, a lamp that it may look at on a lift, and a move of it.
struct HeadFiles {
  TemporaryFile urdf{"head.urdf", R"(<robot name="head">
  <link name="stand"/>
  <link name="yoke"/>
  <link name="camera"/>
  <link name="lamp"/>
  <joint name="pan" type="continuous"><parent link="stand"/><child link="yoke"/><axis xyz="0 0 1"/></joint>
  <joint name="tilt" type="continuous"><parent link="yoke"/><child link="camera"/><axis xyz="0 -1 0"/></joint>
  <joint name="lift" type="prismatic">
    <parent link="stand"/><child link="lamp"/><origin xyz="2 0 0"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="3" effort="1" velocity="9"/>
  </joint>
</robot>)"};
  TemporaryFile rig;
  TemporaryFile move;

  explicit HeadFiles(const std::string& track)
      : rig("rig.toml", rig_text()), move("move.toml", head_of_move + track) {}
  [[nodiscard]] ProgramRun run(const std::string& command, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {command, move.path().string(), "--rig", rig.path().string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }

 private:
  static constexpr const char* head_of_move = "name = \"look\"\nfps = 25\nframes = 100\n";
  [[nodiscard]] std::string rig_text() const {
    std::string text =
        fmt::format("name = \"head\"\nrate_hz = 100\n[kinematics]\nurdf = \"{}\"\ntip = \"camera\"\n",
                    urdf.path().string());
    for (const auto& [name, unit, reach] :
         {std::tuple("pan", "deg", 170), std::tuple("tilt", "deg", 150), std::tuple("lift", "m", 3)}) {
      text += fmt::format(
          "[[axis]]\nname = \"{}\"\nunit = \"{}\"\nmin = {}\nmax = {}\nmax_velocity = {}\nmax_acceleration = "
          "400\n"
          "unpowered = \"holds\"\ndrive = {{ type = \"pipe\", path = \"p\", counts_per_unit = 1000 }}\n",
          name, unit, unit == std::string("m") ? 0 : -reach, reach, unit == std::string("m") ? 9 : 200);
    }
    return text;
  }
};

std::string look_along(const std::string& keys) {
  return "[[track]]\naxes = [\"pan\", \"tilt\"]\nspace = \"camera\"\nspline = \"linear\"\nspeed = [0, 0, 5, "
         "0, 0]\n"
         "keys = [" +
         keys + "]\n";
}

TEST(SpaceTrack, APathOverASingularPlaceIsRefusedThoughTheAxesWouldGoOnSmoothly) {
  const HeadFiles over_the_top(look_along("{ aim = [1, 0, 1] }, { aim = [-1.1, 0, 1] }"));
  const ProgramRun run = over_the_top.run("plan");
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, AllOf(HasSubstr("frame "), HasSubstr("singular"), HasSubstr("axis \"pan\"")));
}

TEST(SpaceTrack, APathThatEndsBesideASingularPlaceIsRefused) {
  EXPECT_THAT(HeadFiles(look_along("{ aim = [1, 0, 1] }, { aim = [0.00005, 0, 1] }")).run("plan").err,
              AllOf(HasSubstr("frame 100.00"), HasSubstr("singular"), HasSubstr("axis \"pan\"")));
  EXPECT_EQ(HeadFiles(look_along("{ aim = [1, 0, 1] }, { aim = [0.1, 0, 1] }")).run("plan").status, 0);
}

TEST(SpaceTrack, NearSaysInTheUnitsOfTheRigWhichSolutionIsMeant) {
  const std::string keys = look_along("{ aim = [1, 1, 1] }, { aim = [1, 0.9, 1] }");
  for (const auto& [near, pan, tilt] :
       {std::tuple("near = { tilt = 40 }\n", 45.0, 35.264389682754654),
        std::tuple("near = { pan = -130, tilt = 140 }\n", -135.0, 144.73561031724535)}) {
    const ProgramRun run =
        HeadFiles(with(keys, "spline =", std::string(near) + "spline =")).run("plan", {"--json", "-"});
    ASSERT_EQ(run.status, 0) << run.err;
    EXPECT_NEAR(row_of(Json::parse(run.out), "position", 0).at(0), pan, 1e-9);
    EXPECT_NEAR(row_of(Json::parse(run.out), "position", 0).at(1), tilt, 1e-9);
  }
  EXPECT_THAT(HeadFiles(with(keys, "spline =", "near = { lift = 1 }\nspline =")).run("plan").err,
              HasSubstr("lift"));
}

TEST(SpaceTrack, KeysOnFramesInSpaceArePassedAtAPaceOrEvenlyAndInNoOtherWay) {
  const std::string curve = "speed = [0, 0, 8, 10, 6, 10, 8, 0, 0]";
  std::string text =
      with(file_contents(in_checkout("examples/arm/hand_elbow_up.toml")), curve, "timing = \"frames\"");
  const std::array<std::pair<const char*, int>, 4> keys = {
      std::pair("[ 420.0, -150.0, 0.0]", 0), std::pair("[ 350.0,  200.0, 0.0]", 50),
      std::pair("[ 100.0,  400.0, 0.0]", 90), std::pair("[-150.0,  380.0, 0.0]", 125)};
  for (const auto& [at, frame] : keys) text = with(text, at, fmt::format("{}, frame = {}", at, frame));
  const auto run = [&](const std::string& timing) {
    const TemporaryFile move("move.toml", with(text, "timing = \"frames\"", timing));
    return run_program({"plan", move.path(), "--rig", in_checkout("examples/arm/rig.toml"), "--json", "-"});
  };
  for (const char* kinetic : {"", "\nkinetic = \"curves\"", "\nkinetic = \"monotone\""}) {
    const ProgramRun refused = run(std::string("timing = \"frames\"") + kinetic);
    EXPECT_EQ(refused.status, 1);
    EXPECT_EQ(std::ranges::count(refused.err, '\n'), 1) << refused.err;
    EXPECT_THAT(refused.err, AllOf(HasSubstr("kinetic = \"pace\" or \"linear\""), HasSubstr("error: ")));
  }
  for (const char* kinetic : {"\nkinetic = \"pace\"", "\nkinetic = \"linear\""}) {
    const ProgramRun passed = run(std::string("timing = \"frames\"") + kinetic);
    ASSERT_EQ(passed.status, 0) << passed.err;
    const Json json = Json::parse(passed.out);
    const std::size_t before = static_cast<std::size_t>(-json.at("axes")[0].value("first_frame", 0));
    const Json& position = json.at("tips")[0].at("position").at(50 + before);
    EXPECT_NEAR(position[0].get<double>(), 0.35, 1e-6) << kinetic;
    EXPECT_NEAR(position[1].get<double>(), 0.2, 1e-6) << kinetic;
  }
}

TEST(SpaceTrack, AnAxisThatDoesNotMoveTheTipIsRefusedInItsTrack) {
  const std::string track =
      with(look_along("{ aim = [1, 0, 1] }, { aim = [1, 1, 1] }"), "\"tilt\"]", "\"tilt\", \"lift\"]");
  EXPECT_THAT(HeadFiles(track).run("plan").err,
              HasSubstr("axis \"lift\" does not move \"camera\"; give it a track of its own"));
}

/// The crane, with the puppet on a lift that a track of its own moves.
struct LiftFiles {
  TemporaryFile urdf{"crane.urdf", with(with(file_contents(in_checkout("examples/crane/crane.urdf")),
                                             "\"stage\" type=\"fixed\"", "\"lift\" type=\"prismatic\""),
                                        "<origin xyz=\"4.2 2.4 1\"/>",
                                        "<origin xyz=\"4.2 2.4 1\"/><axis xyz=\"0 0 1\"/>"
                                        "<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>")};
  TemporaryFile rig{"rig.toml", with(file_contents(in_checkout("examples/crane/rig.toml")), "\"crane.urdf\"",
                                     "\"" + urdf.path().string() + "\"") +
                                    R"(
[[axis]]
name = "lift"
unit = "mm"
min = -500
max = 500
max_velocity = 900
max_acceleration = 900
unpowered = "holds"
drive = { type = "pipe", path = "p", counts_per_unit = 10 }
)"};
  /// The crane's move with this aim, and a track for the lift.
  [[nodiscard]] static std::string text(const std::string& aim, const std::string& lift) {
    return with(file_contents(in_checkout("examples/crane/round_the_puppet.toml")), "\"puppet\"", aim) +
           "\n[[track]]\naxes = [\"lift\"]\n" + lift;
  }
  [[nodiscard]] Json plan(const std::string& aim, const std::string& lift) const {
    const TemporaryFile move("move.toml", text(aim, lift));
    return planned(move.path(), rig.path());
  }
  [[nodiscard]] std::string refusal(const std::string& move_text) const {
    const TemporaryFile move("move.toml", move_text);
    const ProgramRun run = run_program({"plan", move.path(), "--rig", rig.path()});
    EXPECT_EQ(run.status, 1) << run.out;
    EXPECT_EQ(std::ranges::count(run.err, '\n'), 1) << run.err;
    return run.err;
  }
};

TEST(SpaceTrack, ALinkThatIsAimedAtIsLookedForWhereItsAxesHoldIt) {
  const LiftFiles files;
  const std::string hold = "keys = [{ at = [200] }]\nspeed = [1]\n";
  const Json by_name = files.plan("\"puppet\"", hold);
  const Json by_place = files.plan("[4.2, 2.4, 1.2]", hold);
  for (std::size_t row = 0; row < by_name.at("axes")[0].at("position").size(); row += 50) {
    const std::vector<double> axes = row_of(by_name, "position", row);
    const std::vector<double> expected = row_of(by_place, "position", row);
    for (std::size_t i = 0; i < axes.size(); ++i) ASSERT_NEAR(axes[i], expected[i], 1e-9) << i;
  }
}

const char* const up_and_down =
    "timing = \"frames\"\nkeys = [{ at = [0], frame = 0 }, { at = [300], frame = 100 }, { at = [-200], frame "
    "= 200 }, "
    "{ at = [0], frame = 288 }]\n";

/// Of the crane with the puppet on its lift, by the axes of the rig.
OraclePose camera_of(const OracleTree& tree, const std::vector<double>& axes) {
  return tree.pose(7, {axes.begin(), axes.begin() + 6});
}

TEST(SpaceTrack, TheCraneLooksAtAPuppetThatAnotherTrackMoves) {
  const LiftFiles files;
  const Json json = files.plan("\"puppet\"", up_and_down);
  const Json still =
      planned(in_checkout("examples/crane/round_the_puppet.toml"), in_checkout("examples/crane/rig.toml"));
  const OracleTree tree(joints_of_crane());
  double aim = 0;
  double off = 0;
  double highest = 0;
  const std::size_t rows = json.at("axes")[0].at("position").size();
  ASSERT_EQ(rows, still.at("axes")[0].at("position").size()) << "it begins and ends at rest, without rolls";
  for (std::size_t row = 0; row < rows; ++row) {
    const std::vector<double> axes = row_of(json, "position", row);
    const OraclePose pose = camera_of(tree, axes);
    const Vector lifted = {puppet[0], puppet[1], puppet[2] + axes.at(6) / 1000};
    aim = std::max(aim, aim_error(pose, lifted));
    // The path and the speed along it are those that are drawn, whatever the puppet does.
    const OraclePose expected = tree.pose(7, row_of(still, "position", row));
    off = std::max(off, size(difference(pose.position, expected.position)));
    highest = std::max(highest, lifted[2]);
    ASSERT_NEAR(pose.columns[1][2], 0, 1e-6) << "the horizon is level";
  }
  fmt::print("aim at what moves {:.3g} deg, off {:.3g} m\n", aim, off);
  EXPECT_GT(highest, 1.29);
  EXPECT_LE(aim, 0.001);
  EXPECT_LE(off, 1e-6 * 2.8);
}

TEST(SpaceTrack, TheCraneHoldsItsAimAtWhatMovesInAControlledStopAndInReverse) {
  const LiftFiles files;
  const TemporaryFile move("move.toml", LiftFiles::text("\"puppet\"", up_and_down));
  const RigFile rig = read_rig_file(files.rig.path());
  const auto kinematics = std::make_shared<const Kinematics>(read_kinematics(rig));
  expect_aim_in_stops({read_move_file(move.path()), rig, {.kinematics = kinematics}}, "what moves");
}

TEST(SpaceTrack, ItLooksAtThePuppetWhileTheCraneHolds) {
  const LiftFiles files;
  std::string text = LiftFiles::text("\"puppet\"", up_and_down);
  text = with(text, "{ at = [3.3, 1.5, 1.5], roll = 0 }", "{ at = [3.3, 1.5, 1.5], roll = 0, hold = 48 }");
  const TemporaryFile move("move.toml", text);
  const Json json = planned(move.path(), files.rig.path());
  const OracleTree tree(joints_of_crane());
  int held = 0;
  for (std::size_t row = 0; row < json.at("axes")[0].at("position").size(); ++row) {
    const std::vector<double> axes = row_of(json, "position", row);
    const OraclePose pose = camera_of(tree, axes);
    ASSERT_LE(aim_error(pose, {puppet[0], puppet[1], puppet[2] + axes.at(6) / 1000}), 0.001) << row;
    if (size(difference(pose.position, {3.3, 1.5, 1.5})) < 1e-6) ++held;
  }
  EXPECT_GE(held, 48 * 250 / 24 - 2);
}

TEST(SpaceTrack, WhatLooksAtAMovingPuppetIsCheckedAsAnyOtherMotion) {
  const LiftFiles files;
  const TemporaryFile move("move.toml", LiftFiles::text("\"puppet\"", up_and_down));
  const ProgramRun fits = run_program({"check", move.path(), "--rig", files.rig.path()});
  EXPECT_EQ(fits.status, 0) << fits.err;
  EXPECT_THAT(fits.out,
              AllOf(HasSubstr("\"camera\" in space: within "), HasSubstr("of the fastest"),
                    HasSubstr("no step of velocity or acceleration"), HasSubstr("fits in 288 frames")));
  const TemporaryFile fast(
      "fast.toml",
      with(with(with(LiftFiles::text("\"puppet\"", up_and_down), "frames = 288", "frames = 72"),
                "frame = 100 }", "frame = 25 }"),
           "frame = 200 }, { at = [0], frame = 288 }", "frame = 50 }, { at = [0], frame = 72 }"));
  const ProgramRun refused = run_program({"check", fast.path(), "--rig", files.rig.path()});
  EXPECT_EQ(refused.status, 3) << refused.err;
  EXPECT_THAT(refused.err, HasSubstr("error: axis "));
  const TemporaryFile fitted("fitted.toml", "");
  const ProgramRun fit =
      run_program({"check", fast.path(), "--rig", files.rig.path(), "--fit", fitted.path()});
  EXPECT_EQ(fit.status, 3);
  EXPECT_THAT(fit.err, HasSubstr("looks at a link that another track moves"));
}

TEST(SpaceTrack, AnAimThatCannotBeFollowedIsRefusedInOneLine) {
  const LiftFiles files;
  const auto text = [](const std::string& lift) { return LiftFiles::text("\"puppet\"", lift); };
  EXPECT_THAT(files.refusal(file_contents(in_checkout("examples/crane/round_the_puppet.toml"))),
              HasSubstr("not known where \"puppet\" stands"));
  EXPECT_THAT(files.refusal(text(
                  "spline = \"linear\"\nkeys = [{ at = [0] }, { at = [9] }, { at = [0] }]\nspeed = [5]\n")),
              HasSubstr("the motion of \"puppet\" steps"));
  EXPECT_THAT(files.refusal(with(text(up_and_down), "space  = ", "spline = \"catmull-rom\"\nspace  = ")),
              HasSubstr("without steps; write spline = \"smooth\""));
  EXPECT_THAT(files.refusal(with(text(up_and_down), "aim    = \"puppet\"", "aim    = \"yoke\"")),
              HasSubstr("\"yoke\" moves with the axes of this track"));
  std::string free = text(up_and_down);
  for (int k = 0; k < 4; ++k) free.erase(free.find(", roll = 0"), 10);
  EXPECT_THAT(files.refusal(free), HasSubstr("leave some of the axes free"));
}

TEST(SpaceTrack, ARangeThatEndsInTheMiddleIsRefusedWithFrameJointAndDistance) {
  EXPECT_THAT(refusal_of_arm("[-150.0,  380.0, 0.0]", "[-380.0,  -50.0, 0.0]"),
              AllOf(HasSubstr("frame "), HasSubstr("axis \"shoulder\" would have to go to"),
                    HasSubstr("deg beyond its max = 170")));
}

TEST(SpaceTrack, AnArmWithoutElbowAndWordsWithoutSpaceAreRefused) {
  EXPECT_THAT(refusal_of_arm("elbow  = \"up\"\n", ""), HasSubstr("elbow = \"up\" or elbow = \"down\""));
  EXPECT_THAT(refusal_of_arm("space  = \"hand\"\n", ""), HasSubstr("elbow needs keys in the world"));
  EXPECT_THAT(refusal_of_arm("space  = \"hand\"", "space  = \"foot\""),
              HasSubstr("no tip \"foot\"; it has hand"));
  EXPECT_THAT(refusal_of_arm("axes   = [\"shoulder\", \"elbow\"]", "axes   = [\"shoulder\"]"),
              HasSubstr("axis \"elbow\" moves \"hand\" and is not in this track"));
  EXPECT_THAT(refusal_of_arm("unit   = \"mm\"", "unit   = \"deg\""), HasSubstr("is not a length"));
  EXPECT_THAT(refusal_of_arm("[-150.0,  380.0, 0.0]", "[-150.0,  380.0]"),
              HasSubstr("write three, x, y and z"));
  EXPECT_THAT(
      refusal("examples/crane/round_the_puppet.toml", "examples/crane/rig.toml", "\"puppet\"", "\"pan\""),
      HasSubstr("no link \"pan\" to look at"));
}

TEST(SpaceTrack, WithoutARigItSaysWhatIsMissing) {
  const ProgramRun run = run_program({"plan", in_checkout("examples/arm/hand_elbow_up.toml")});
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, HasSubstr("plan with --rig RIG"));
}

}  // namespace space_track_test
}  // namespace inbetween
