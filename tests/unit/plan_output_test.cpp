// `plan --json` and `plan --csv`, as design and docs/formats.md promise them, by the program itself.
#include "host_tools/plan/plan_output.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/joints/kinematics.hpp"
#include "host_tools/plan/plan_rows.hpp"
#include "tests/support/golden_table.hpp"
#include "tests/support/oracle_table.hpp"
#include "tests/support/places.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace plan_output_test {

using Json = nlohmann::ordered_json;  // the order of the fields counts, too
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;
using testing::StartsWith;

const std::string examples = in_checkout("examples/");

const std::string drift = R"(name = "drift \"slow\""
fps = "24000/1001"
frames = 48
[[track]]
axes = ["x", "y, \"up\""]
spline = "tcb"
closed = true
keys = [ { at = [0, 0] }, { at = [30.1, 40] }, { at = [60, -7], tension = 0.5 } ]
speed = [2, 10, 1]
weights = [1, 2]
[[track]]
axes = ["z"]
keys = [ { at = [1] }, { at = [2] } ]
speed = [3]
)";

ProgramRun plan(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "plan");
  ProgramRun run = run_program(arguments);
  EXPECT_EQ(run.status, 0) << run.err;
  return run;
}

Json json_of(std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), {"--json", "-"});
  return Json::parse(plan(arguments).out);
}

std::vector<std::string> fields(const Json& object) {
  std::vector<std::string> names;
  for (const auto& [name, value] : object.items()) names.push_back(name);
  return names;
}

std::vector<double> numbers(const Json& list) {
  return list.get<std::vector<double>>();
}

/// P(s) and its derivative by the printed coefficients.
double position(const Json& track, double s, std::size_t axis) {
  const Json& segments = track.at("segments");
  const auto segment = std::min(static_cast<std::size_t>(s), segments.size() - 1);
  const double t = s - static_cast<double>(segment);
  const std::vector<double> c = numbers(segments[segment].at("coefficients").at(axis));
  return c[0] + t * (c[1] + t * (c[2] + t * c[3]));
}

#define EXPECT_SAME_BITS(one, other) \
  EXPECT_EQ(std::bit_cast<std::uint64_t>(one), std::bit_cast<std::uint64_t>(other)) << (one) << " " << (other)

/// Fields may be added; those of the first version stay, in their order.
void expect_fields(const Json& object, std::vector<std::string> expected) {
  std::vector<std::string> names = fields(object);
  std::erase_if(names, [&](const std::string& name) { return std::ranges::count(expected, name) == 0; });
  EXPECT_EQ(names, expected);
}

std::string metres_of(const std::vector<std::string>& names) {
  std::vector<AxisText> axes;
  for (const std::string& name : names)
    axes.push_back({.name = name, .unit = "m", .max_velocity = 1, .max_acceleration = 1});
  return rig_text(axes, {.rate_hz = 60});
}

TEST(PlanJson, HasTheFieldsOfItsFormatInTheirOrder) {
  const Json json = json_of({examples + "reveal.toml", "--rig", examples + "camera_rig.toml"});
  expect_fields(json, {"format", "name", "fps", "frames", "duration_s", "tracks", "axes"});
  expect_fields(json["tracks"][0],
                {"axes", "solver", "length", "K", "f", "speed", "speed_drawn", "segments", "table"});
  expect_fields(json["tracks"][0]["segments"][0], {"coefficients"});
  expect_fields(json["tracks"][0]["table"][0], {"frame", "alpha", "s", "distance", "speed", "acceleration"});
  expect_fields(json["axes"][0], {"name", "unit", "position", "velocity", "acceleration"});
}

TEST(PlanJson, SaysWhatWasPlanned) {
  const Json json = json_of({examples + "reveal.toml", "--rig", examples + "camera_rig.toml"});
  EXPECT_EQ(json["format"], 1);
  EXPECT_EQ(json["name"], "reveal");
  EXPECT_EQ(json["fps"].dump(), "24");
  EXPECT_EQ(json["frames"], 192);
  EXPECT_EQ(json["duration_s"], 8);
  ASSERT_THAT(json["tracks"], SizeIs(1));
  const Json& track = json["tracks"][0];
  EXPECT_EQ(track["axes"], Json::parse(R"(["slide", "pan", "tilt"])"));
  EXPECT_EQ(track["solver"], "closed-form");
  EXPECT_EQ(track["speed_error"], 1e-6);
  EXPECT_EQ(track["f"], 9);
  EXPECT_EQ(track["speed"], Json::parse("[0, 0, 3, 4, 9, 12, 8, 5, 0, 0]"));
  EXPECT_EQ(track["speed_drawn"], track["speed"]);
  EXPECT_THAT(track["segments"], SizeIs(4));
  EXPECT_THAT(track["table"], SizeIs(193));
  ASSERT_THAT(json["axes"], SizeIs(3));
  EXPECT_EQ(json["axes"][0]["name"], "slide");
  EXPECT_EQ(json["axes"][0]["unit"], "mm");
  EXPECT_EQ(json["axes"][1]["unit"], "deg");
  for (const Json& axis : json["axes"]) {
    for (const char* column : {"position", "velocity", "acceleration"})
      EXPECT_THAT(axis[column], SizeIs(193));
  }
}

TEST(PlanJson, UnitsAreNullWithoutARig) {
  const Json json = json_of({examples + "reveal.toml"});
  for (const Json& axis : json["axes"]) EXPECT_TRUE(axis["unit"].is_null());
}

TEST(PlanJson, RepeatsTheFrameRateAndTheNameAsTheyWereWritten) {
  const TemporaryFile move("move.toml", drift);
  const Json json = json_of({move.path().string()});
  EXPECT_EQ(json["fps"], "24000/1001");
  EXPECT_EQ(json["name"], "drift \"slow\"");
  EXPECT_EQ(json["tracks"][0]["axes"][1], "y, \"up\"");
  EXPECT_DOUBLE_EQ(json["duration_s"], 48 * 1001 / 24000.0);
}

TEST(PlanJson, ASingleControlValueIsTwoEqualOnes) {
  const TemporaryFile move("move.toml", drift);
  const Json json = json_of({move.path().string()});
  const Json& track = json["tracks"][1];
  EXPECT_EQ(track["f"], 1);
  EXPECT_EQ(track["speed"], Json::parse("[3, 3]"));
  EXPECT_EQ(track["speed_drawn"], Json::parse("[3]"));
}

TEST(PlanJson, ItsCoefficientsReproduceTheKeys) {
  const TemporaryFile file("move.toml", drift);
  const MoveFile move = read_move_file(file.path());
  const Json json = json_of({file.path().string()});
  for (std::size_t t = 0; t < move.tracks.size(); ++t) {
    const MoveTrack& written = move.tracks[t];
    const Json& track = json["tracks"][t];
    const std::size_t segments = written.keys.size() - (written.closed ? 0 : 1);
    ASSERT_THAT(track["segments"], SizeIs(segments));
    for (std::size_t i = 0; i < segments; ++i) {
      const Json& rows = track["segments"][i]["coefficients"];
      ASSERT_THAT(rows, SizeIs(written.axes.size()));
      for (std::size_t d = 0; d < rows.size(); ++d) {
        const std::vector<double> c = numbers(rows[d]);
        ASSERT_THAT(c, SizeIs(4));
        EXPECT_EQ(c[0], written.keys[i].at[d]);
        EXPECT_NEAR(c[0] + c[1] + c[2] + c[3], written.keys[(i + 1) % written.keys.size()].at[d], 1e-13);
      }
    }
  }
}

TEST(PlanJson, ItsNumbersReadBackToTheLastBit) {
  const std::string move = examples + "reveal.toml";
  const Plan solved(read_move_file(move), std::nullopt, {});
  const Track& track = solved.tracks()[0].track();
  const FrameTable& table = solved.tracks()[0].table();
  const Json json = json_of({move});
  const Json& printed = json["tracks"][0];
  EXPECT_SAME_BITS(printed["length"].get<double>(), track.arc_length().total());
  EXPECT_SAME_BITS(printed["K"].get<double>(), table.provenance().constant);
  std::vector<AxisMotion> motion(3);
  constexpr std::array travels{1580.0, 94.0, 13.1};
  for (std::int32_t frame = 0; frame <= 192; ++frame) {
    const Json& row = printed["table"][static_cast<std::size_t>(frame)];
    const FrameRow expected = frame_row(track, table, frame);
    EXPECT_EQ(row["frame"], frame);
    EXPECT_SAME_BITS(row["alpha"].get<double>(), expected.alpha);
    EXPECT_SAME_BITS(row["s"].get<double>(), expected.point.segment + expected.point.t);
    EXPECT_SAME_BITS(row["distance"].get<double>(), expected.distance);
    EXPECT_SAME_BITS(row["speed"].get<double>(), expected.speed);
    EXPECT_SAME_BITS(row["acceleration"].get<double>(), expected.acceleration);
    solved.motion().motion({frame, 0}, motion);
    for (std::size_t d = 0; d < 3; ++d) {
      const Json& axis = json["axes"][d];
      const auto j = static_cast<std::size_t>(frame);
      EXPECT_SAME_BITS(axis["position"][j].get<double>(), motion[d].position);
      const double of_table = track.path().position(expected.point, static_cast<std::int32_t>(d));
      EXPECT_NEAR(motion[d].position, of_table, 1.1 * travels[d] / (1 << 30));
      EXPECT_SAME_BITS(axis["velocity"][j].get<double>(), motion[d].velocity);
      EXPECT_SAME_BITS(axis["acceleration"][j].get<double>(), motion[d].acceleration);
    }
  }
}

TEST(PlanJson, ItsTableIsTheOneOfTheOracle) {
  const TemporaryFile file("move.toml", drift);
  const Json json = json_of({file.path().string()});
  const std::vector<DrawnTrack> drawn = read_drawn_tracks(file.path());
  const double fps = 24000.0 / 1001.0;
  for (std::size_t t = 0; t < drawn.size(); ++t) {
    const oracle::Path path(drawn[t].keys);
    const std::vector<oracle::Row> rows =
        oracle::frame_table(path, oracle::Profile(drawn[t].speed), drawn[t].frames);
    const Json& track = json["tracks"][t];
    const auto length = static_cast<double>(path.total_length());
    EXPECT_NEAR(track["length"], length, 1e-13 * length);
    ASSERT_THAT(track["table"], SizeIs(rows.size()));
    for (std::size_t j = 0; j < rows.size(); ++j) {
      const Json& row = track["table"][j];
      const oracle::Row& expected = rows[j];
      const auto speed = static_cast<double>(expected.speed) * fps;
      EXPECT_NEAR(row["alpha"], static_cast<double>(expected.alpha), 1e-15 * 48);
      EXPECT_NEAR(row["distance"], static_cast<double>(expected.distance), 1e-6 * length);
      EXPECT_NEAR(row["s"], static_cast<double>(expected.place.segment + expected.place.t), 1e-5);
      EXPECT_NEAR(row["speed"], speed, 1e-12 * length);
      EXPECT_NEAR(row["acceleration"], static_cast<double>(expected.acceleration) * fps * fps,
                  1e-11 * length);
    }
  }
}

TEST(PlanJson, VelocityAndAccelerationAreTheDerivativesOfThePosition) {
  const Json json = json_of({examples + "reveal.toml"});
  const std::vector<DrawnTrack> drawn = read_drawn_tracks(examples + "reveal.toml");
  const oracle::Path path(drawn[0].keys);
  const oracle::Profile profile(drawn[0].speed);
  for (const int frame : {31, 74, 100, 160}) {
    const oracle::Motion expected = oracle::motion_at(path, profile, drawn[0].frames, 24, frame / 24.0L);
    const auto j = static_cast<std::size_t>(frame);
    for (std::size_t d = 0; d < 3; ++d) {
      EXPECT_NEAR(json["axes"][d]["velocity"][j], static_cast<double>(expected.velocity[d]), 1e-3);
      EXPECT_NEAR(json["axes"][d]["acceleration"][j], static_cast<double>(expected.acceleration[d]), 2e-3);
    }
  }
}

TEST(PlanJson, BothSolversPutTheAxesWhereTheirOwnTableHasThem) {
  for (const char* solver : {"closed-form", "runge-kutta"}) {
    const Json json = json_of({examples + "paper_figure_4.toml", "--solver", solver});
    const Json& track = json["tracks"][0];
    EXPECT_EQ(track["solver"], solver);
    for (std::size_t j = 0; j <= 72; ++j) {
      for (std::size_t d = 0; d < 2; ++d) {
        // What plays of the closed form is a trajectory, within 2^-30 of the distance of some 300.
        const double rounding = std::string_view(solver) == "closed-form" ? 3e-7 : 1e-12;
        EXPECT_NEAR(json["axes"][d]["position"][j], position(track, track["table"][j]["s"], d), rounding)
            << solver;
      }
    }
  }
}

TEST(PlanJson, TheTwoSolversAgreeWithinTheErrorThatThePapersReports) {
  const std::string move = examples + "paper_figure_5.toml";
  const Json exact = json_of({move});
  const Json paper = json_of({move, "--solver", "runge-kutta"});
  const double error = paper["tracks"][0]["speed_error"];
  EXPECT_GT(error, 1e-9);
  EXPECT_LT(error, 0.02);
  bool differ = false;
  for (std::size_t j = 0; j <= 72; ++j) {
    const double drawn = exact["tracks"][0]["table"][j]["distance"];
    const double integrated = paper["tracks"][0]["table"][j]["distance"];
    EXPECT_NEAR(integrated, drawn, (error + 1e-6) * drawn);
    differ = differ || integrated != drawn;
  }
  EXPECT_TRUE(differ);
}

TEST(PlanJson, PerTickItsAxesHaveAValuePerTick) {
  const TemporaryFile move("move.toml", with(drift, ", \\\"up\\\"", ""));
  const std::string rig = metres_of({"z", "idle", "y", "x"});
  const TemporaryFile machine("rig.toml", rig);
  const Json json = json_of({move.path().string(), "--rig", machine.path().string(), "--per", "tick"});
  EXPECT_THAT(json["tracks"][0]["table"], SizeIs(49));
  ASSERT_THAT(json["axes"], SizeIs(3)) << "idle is in no track";
  EXPECT_EQ(json["axes"][0]["name"], "z");
  const Plan solved(read_move_file(move.path()), std::nullopt, {});
  for (std::size_t a = 0; a < 3; ++a) {
    ASSERT_THAT(json["axes"][a]["position"], SizeIs(122));  // 2.002 s at 60 Hz, rounded up, and tick 0
  }
  std::vector<double> positions(2);
  for (std::size_t tick = 0; tick < 122; ++tick) {
    const auto time = frame_time_of_tick(static_cast<std::int64_t>(tick), {24000, 1001}, 60);
    solved.motion().trajectories()[0].positions(time, positions);
    EXPECT_SAME_BITS(json["axes"][2]["position"][tick].get<double>(), positions[0]);
    EXPECT_SAME_BITS(json["axes"][1]["position"][tick].get<double>(), positions[1]);
  }
  EXPECT_EQ(json["axes"][2]["position"][121], 0);  // closed: back at key 0
}

/// The example arm, its joints known.
Plan plan_of_arm(const std::string& track) {
  static const RigFile rig = read_rig_file(examples + "arm/rig.toml");
  static const auto joints = std::make_shared<const Kinematics>(read_kinematics(rig));
  const std::string move =
      "name = \"key\"\nfps = 24\nframes = 96\n[[track]]\n"
      "axes = [\"shoulder\", \"elbow\"]\n";
  return Plan(parse_move(move + track, "key.toml"), rig, {.kinematics = joints});
}

/// What an axis has `way` frames beside a frame, from what plays there and twice as far away.
double acceleration_beside(const Plan& plan, std::size_t axis, std::int32_t frame, double distance) {
  const auto at = [&](double frames) {
    return plan.motion().trajectories()[0].motion_of(axis, moved_by({frame, 0}, frames)).acceleration;
  };
  return 2 * at(distance) - at(2 * distance);
}

/// The row of a key's frame has the acceleration behind it. Returns whether it steps there.
bool expect_the_leaving_side(const Plan& plan, std::int32_t frame) {
  bool steps = false;
  for (const std::size_t axis : {0U, 1U}) {
    SCOPED_TRACE(fmt::format("axis {}, frame {}", axis, frame));
    const double arriving = acceleration_beside(plan, axis, frame, -1e-4);
    const double leaving = acceleration_beside(plan, axis, frame, 1e-4);
    const AxisColumn column(plan, plan.axes()[axis], PlanRows::frame);
    EXPECT_NEAR(column.motion(frame).acceleration, leaving,
                1e-3 * (1 + std::fabs(leaving) + std::fabs(arriving)));
    steps = steps || std::fabs(leaving - arriving) > 1;
  }
  return steps;
}

TEST(PlanRows, ABreakIsToldAsTheAxisLeavesIt) {
  EXPECT_TRUE(expect_the_leaving_side(plan_of_arm(R"(spline = "catmull-rom"
speed = [0, 0, 2.0244224295936504, 7.061276261967915, 5, 0, 0]
keys = [{ at = [-47.71, 75.43] }, { at = [-11.99, 72.16], frame = 33, break = true },
        { at = [15.77, 99.52] }, { at = [48.72, 65.1] }]
)"),
                                      33));
}

TEST(PlanRows, ALockedKeyOfATipsDistanceIsToldAsTheAxisLeavesIt) {
  EXPECT_TRUE(expect_the_leaving_side(plan_of_arm(R"(spline = "catmull-rom"
distance = "hand"
speed = [0, 0, 4.4704110082609185, 8.421370181948236, 5, 0, 0]
keys = [{ at = [-34.81, 99.5] }, { at = [-13.33, 75.06] }, { at = [21.61, 65.33], frame = 60 },
        { at = [52.4, 73.3] }]
)"),
                                      60));
}

TEST(PlanRows, AKeyOfAPaceIsToldAsTheAxisLeavesIt) {
  const Plan plan = plan_of_arm(R"(spline = "tcb"
timing = "frames"
kinetic = "pace"
keys = [{ at = [-39.33, 62.13], frame = 0 }, { at = [-2.56, 64.54], frame = 28 },
        { at = [13.26, 98.88], frame = 65 }, { at = [50.74, 92.46], frame = 96 }]
)");
  EXPECT_TRUE(expect_the_leaving_side(plan, 28));
  EXPECT_TRUE(expect_the_leaving_side(plan, 65));
}

/// A way of saying when keys 1 and 2 are met: what the track says beside its keys, and what they say.
struct KeyTimes {
  const char* track;
  const char* key_1;
  const char* key_2;
  bool in_space = false;
};
const std::vector<KeyTimes> key_times = {
    {"timing = \"frames\"\nkinetic = \"pace\"\n", "frame = 31", "frame = 62"},
    {"timing = \"frames\"\nkinetic = \"monotone\"\n", "frame = 31", "frame = 62"},
    {"timing = \"frames\"\n", "frame = 31", "frame = 62"},
    {"speed = [0, 0, 4, 8, 5, 0, 0]\n", "frame = 31", "frame = 62"},
    {"speed = [0, 0, 4, 8, 5, 0, 0]\n", "frame = 31, break = true", "frame = 62, break = true"},
    {"speed = [0, 0, 4, 8, 5, 0, 0]\n", "frame = 31, hold = 7", "frame = 62"},
    {"speed = [0, 0, 4, 8, 5, 0, 0]\ndistance = \"hand\"\n", "frame = 31", "frame = 62"},
    {"speed = [0, 0, 4, 8, 5, 0, 0]\nspace = \"hand\"\nelbow = \"up\"\n", "frame = 31", "frame = 62", true},
};

TEST(PlanRows, EveryKeyIsToldAsTheAxisLeavesItWithEverySplineAndTiming) {
  int stepping = 0;
  for (const char* spline : {"smooth", "catmull-rom", "tcb", "linear"}) {
    for (const KeyTimes& times : key_times) {
      for (const double other : {-1.0, -0.4, 0.3, 0.9}) {
        const auto at = [&](double place) {
          return times.in_space
                     ? fmt::format("[{}, {}, 0]", 0.3 + 0.02 * other * place, -0.2 + 0.13 * place)
                     : fmt::format("[{}, {}]", -45 + 30 * place + 5 * other, 80 + 9 * other * place);
        };
        const std::string first = times.track[0] == 't' ? ", frame = 0" : "";
        const std::string last = first.empty() ? "" : ", frame = 96";
        const std::string track = fmt::format(
            "spline = \"{}\"\n{}keys = [{{ at = {}{} }}, {{ at = {}, {} }}, {{ at = {}, {} }}, {{ at = {}{} "
            "}}]\n",
            spline, times.track, at(0), first, at(1.2), times.key_1, at(1.8), times.key_2, at(3), last);
        SCOPED_TRACE(track);
        const Plan plan = plan_of_arm(track);
        for (const std::int32_t frame : {31, 62}) stepping += expect_the_leaving_side(plan, frame) ? 1 : 0;
      }
    }
  }
  EXPECT_GT(stepping, 60) << "so many step, and the sides differ";
}

/// Adds the names of all fields at any depth.
void collect_fields(const Json& json, std::set<std::string>& names) {
  for (const auto& [name, value] : json.items()) {
    if (json.is_object()) names.insert(name);
    if (value.is_structured()) collect_fields(value, names);
  }
}

TEST(OutputDocument, HasEveryFieldOfTheJsonAndTheHeaderOfTheCsv) {
  const std::string document = file_contents(in_checkout("docs/formats.md"));
  const std::string written = document.substr(document.find("## What is written"));
  const std::string rig = examples + "camera_rig.toml";
  const std::string move = examples + "reveal.toml";
  std::set<std::string> names;
  collect_fields(json_of({move, "--rig", rig}), names);
  const ProgramRun run = run_program({"run", move, "--rig", rig, "--sim", "--fast", "--json", "-"});
  collect_fields(Json::parse(run.out), names);
  EXPECT_GE(names.size(), 25U);
  for (const std::string& name : names) {
    EXPECT_NE(written.find("`" + name + "`"), std::string::npos) << "docs/formats.md lacks " << name;
  }
  std::istringstream csv(plan({move, "--rig", rig, "--csv", "-"}).out);
  for (int line = 0; line < 2; ++line) {
    std::string text;
    std::getline(csv, text);
    EXPECT_THAT(written, HasSubstr("\n" + text + "\n"));
  }
}

struct Csv {
  std::string header;
  std::vector<std::vector<std::string>> rows;
};

Csv csv_of(std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), {"--csv", "-"});
  std::istringstream lines(plan(arguments).out);
  Csv csv;
  std::getline(lines, csv.header);
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::string> row;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(cell);
    csv.rows.push_back(row);
  }
  return csv;
}

double number(const std::string& text) {
  return std::strtod(text.c_str(), nullptr);
}

TEST(PlanCsv, NamesItsColumnsWithUnits) {
  const std::string move = examples + "reveal.toml";
  EXPECT_EQ(csv_of({move}).header, "frame,time_s,slide,pan,tilt");
  EXPECT_EQ(csv_of({move, "--rig", examples + "camera_rig.toml"}).header,
            "frame,time_s,slide (mm),pan (deg),tilt (deg)");
}

TEST(PlanCsv, QuotesAColumnNameThatNeedsIt) {
  const TemporaryFile move("move.toml", drift);
  EXPECT_EQ(csv_of({move.path().string()}).header, R"(frame,time_s,x,"y, ""up""",z)");
}

TEST(PlanCsv, HasARowPerFrameWithTheNumbersOfTheJson) {
  const std::string move = examples + "reveal.toml";
  const Csv csv = csv_of({move});
  const Json json = json_of({move});
  ASSERT_THAT(csv.rows, SizeIs(193));
  for (std::size_t j = 0; j < csv.rows.size(); ++j) {
    ASSERT_THAT(csv.rows[j], SizeIs(5));
    EXPECT_EQ(csv.rows[j][0], std::to_string(j));
    EXPECT_EQ(number(csv.rows[j][1]), static_cast<double>(j) / 24);
    for (std::size_t d = 0; d < 3; ++d) {
      EXPECT_SAME_BITS(number(csv.rows[j][2 + d]), json["axes"][d]["position"][j].get<double>());
    }
  }
}

TEST(PlanCsv, HasARowPerTickOfTheRig) {
  const std::vector<std::string> arguments = {examples + "reveal.toml", "--rig", examples + "camera_rig.toml",
                                              "--per", "tick"};
  const Csv csv = csv_of(arguments);
  const Json json = json_of(arguments);
  EXPECT_EQ(csv.header, "tick,time_s,slide (mm),pan (deg),tilt (deg)");
  ASSERT_THAT(csv.rows, SizeIs(2001));
  for (std::size_t k = 0; k < csv.rows.size(); ++k) {
    EXPECT_EQ(csv.rows[k][0], std::to_string(k));
    EXPECT_EQ(number(csv.rows[k][1]), static_cast<double>(k) / 250);
    EXPECT_SAME_BITS(number(csv.rows[k][3]), json["axes"][1]["position"][k].get<double>());
  }
  EXPECT_EQ(csv.rows.back()[2], "1640");
}

TEST(PlanPicture, ShowsTheAxesOfTheMoveOnly) {
  const std::string move = with(drift, ", \\\"up\\\"", "");
  const std::string rig = metres_of({"idle", "z", "y", "x"});
  const PlotMove plot = plot_of(Plan(parse_move(move, "move.toml"), parse_rig(rig, "rig.toml"), {}));
  ASSERT_THAT(plot.axes, SizeIs(3));
  EXPECT_EQ(plot.axes[0].name, "z");
  EXPECT_THAT(plot.tracks[0].axes, ElementsAre(2, 1));
  EXPECT_THAT(plot.tracks[1].axes, ElementsAre(0));
  EXPECT_EQ(plot.axes[2].positions.front(), 0);
  EXPECT_THAT(plot.tracks[1].control_values, ElementsAre(3, 3));
}

TEST(Plot, AnAxisIsDrawnAsItMovesBetweenFramesToo) {
  const Plan plan(parse_move(R"(name = "swing"
fps = 24
frames = 4
[[track]]
axes = ["arm"]
overshoot = false
keys = [{ at = [0] }, { at = [9] }, { at = [9] }, { at = [0] }]
speed = [0, 0, 3, 0, 0]
)",
                             "swing.toml"),
                  std::nullopt, {});
  const PlotAxis axis = plot_of(plan).axes[0];
  const std::size_t samples = (axis.line.size() - 1) / 4;
  ASSERT_GT(samples, 8);
  std::vector<double> at(1);
  for (std::size_t i = 0; i < axis.line.size(); ++i) {
    const auto frame = static_cast<std::int32_t>(i / samples);
    plan.tracks()[0].track().positions(
        {frame, static_cast<double>(i % samples) / static_cast<double>(samples)}, at);
    EXPECT_NEAR(axis.line[i], at[0], 1.1 * 9 / (1 << 30)) << i;
  }
  for (std::size_t frame = 0; frame <= 4; ++frame)
    EXPECT_EQ(axis.line[frame * samples], axis.positions[frame]);
}

TEST(Plot, AKeyInSpaceShowsWhereTheCameraLooksAndAtWhat) {
  const RigFile rig = read_rig_file(examples + "crane/rig.toml");
  const Plan plan(read_move_file(examples + "crane/round_the_puppet.toml"), rig,
                  {.kinematics = std::make_shared<const Kinematics>(read_kinematics(rig))});
  const PlotMove plot = plot_of(plan);
  ASSERT_THAT(plot.tips, SizeIs(1));
  ASSERT_THAT(plot.tips[0].postures, SizeIs(4));
  for (const PlotPosture& posture : plot.tips[0].postures) {
    ASSERT_TRUE(posture.aim.has_value());
    const PlotPlace puppet{4.2, 2.4, 1};
    double square = 0, along = 0;
    for (std::size_t d = 0; d < 3; ++d) {
      EXPECT_NEAR((*posture.aim)[d], puppet[d], 1e-9);
      square += std::pow(puppet[d] - posture.tip[d], 2);
      along += (puppet[d] - posture.tip[d]) * posture.view[d];
    }
    EXPECT_NEAR(along, std::sqrt(square), 1e-6) << "on frame " << posture.frame << " it looks at the puppet";
  }
}

TEST(Plot, AHeldKeyIsWhereItRestsAndForAsLong) {
  const PlotMove plot = plot_of(Plan(parse_move(R"(name = "held"
fps = 24
frames = 192
[[track]]
axes = ["slide"]
keys = [{ at = [40] }, { at = [400], frame = 78, hold = 36 }, { at = [760] }]
speed = [0, 0, 3, 3, 3, 0, 0]
)",
                                                "held.toml"),
                                     std::nullopt, {}));
  EXPECT_THAT(plot.tracks[0].key_frames, ElementsAre(0, 78, 192));
  EXPECT_THAT(plot.tracks[0].key_holds, ElementsAre(0, 36, 0));
  for (std::size_t frame = 78; frame <= 114; ++frame) EXPECT_NEAR(plot.axes[0].positions[frame], 400, 1e-9);
}

}  // namespace plan_output_test
}  // namespace inbetween
