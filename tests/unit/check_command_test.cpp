// `check` as its users meet it: the table, the verdict, exit statuses, JSON, the picture; and `run`, which
// refuses what `check` refuses.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "host_tools/check/check.hpp"
#include "tests/support/places.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace check_command_test {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::SizeIs;
using testing::StartsWith;

const std::string reveal = in_checkout("examples/reveal.toml");
const std::string camera_rig = in_checkout("examples/camera_rig.toml");

/// The example in so many frames.
std::string reveal_in(int frames) {
  return with(file_contents(reveal), "frames = 192", "frames = " + std::to_string(frames));
}

std::string with_corners() {
  return with(file_contents(reveal), "\"smooth\"", "\"linear\"");
}

ProgramRun check_file(const std::string& move, const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments = {"check", move, "--rig", camera_rig};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_program(arguments);
}

ProgramRun check_text(const std::string& text, const std::vector<std::string>& more = {}) {
  const TemporaryFile move("move.toml", text);
  return check_file(move.path().string(), more);
}

std::vector<std::string> fields(const Json& object) {
  std::vector<std::string> names;
  for (const auto& [name, value] : object.items()) names.push_back(name);
  return names;
}

TEST(CheckCommand, AMoveThatFitsIsStatus0WithATableAndAVerdict) {
  const ProgramRun run = check_file(reveal);
  EXPECT_EQ(run.status, 0);
  EXPECT_EQ(run.err, "") << "no progress bar in a pipe";
  EXPECT_THAT(run.out,
              StartsWith("reveal on slider with pan and tilt head: 192 frames at 24 fps, 8.000 s\n"));
  for (const char* words :
       {"slide ", "pan ", "tilt ", "lowest", "highest", "velocity", "acceleration", "jerk", " mm/s^2 ",
        " deg/s ", " 88 %\n", "the drives follow this motion within 1e-06"}) {
    EXPECT_THAT(run.out, HasSubstr(words));
  }
  EXPECT_THAT(run.out, testing::ContainsRegex("\nfits in 192 frames; [0-9]+ frames would do, [0-9]+ frames "
                                              "with another speed curve of as many control values\n$"));
}

TEST(CheckCommand, APeakJustAboveItsLimitIsShownWithTheDigitsThatDiffer) {
  const std::string json = check_file(reveal, {"--json", "-"}).out;
  const double peak = Json::parse(json)["axes"][0]["velocity"]["peak"];
  const std::string limit = fmt::format("{}", peak * (1 - 1e-9));
  const std::string rig_text =
      with(file_contents(camera_rig), "max_velocity = 500.0", "max_velocity = " + limit);
  const TemporaryFile rig("rig.toml", rig_text);
  const ProgramRun run = run_program({"check", reveal, "--rig", rig.path().string()});
  EXPECT_EQ(run.status, 3);
  EXPECT_THAT(run.err, HasSubstr(fmt::format("would reach {:.10g} mm/s at frame", peak)));
  EXPECT_THAT(run.err, HasSubstr(fmt::format("and max_velocity is {:.10g} mm/s\n", peak * (1 - 1e-9))));
}

TEST(CheckCommand, AMoveThatDoesNotFitIsStatus3AndEveryReasonIsALine) {
  const TemporaryFile move("move.toml", reveal_in(48));
  const std::string file = move.path().string();
  const ProgramRun run = check_file(file);
  EXPECT_EQ(run.status, 3);
  EXPECT_THAT(run.err, StartsWith(file + ":8:11: error: axis \"slide\" would reach "));
  EXPECT_THAT(run.err, HasSubstr(" mm/s at frame "));
  EXPECT_THAT(run.err, HasSubstr(", and max_velocity is 500 mm/s; give the move more frames"));
  EXPECT_THAT(run.out,
              testing::ContainsRegex("\ndoes not fit in 48 frames; [0-9]+ frames would do, [0-9]+ frames "
                                     "with another speed curve of as many control values\n$"));
}

TEST(CheckCommand, TheNumberOfFramesItNamesFitsAndOneLessDoesNot) {
  const TemporaryFolder folder;
  const std::string json = (folder.path() / "a.json").string();
  EXPECT_EQ(check_text(reveal_in(48), {"--json", json}).status, 3);
  const int smallest = Json::parse(file_contents(json))["smallest_frames"];
  EXPECT_EQ(check_text(reveal_in(smallest)).status, 0);
  EXPECT_EQ(check_text(reveal_in(smallest - 1)).status, 3);
  EXPECT_THAT(check_text(reveal_in(smallest)).out,
              HasSubstr("\nfits in " + std::to_string(smallest) + " frames; "));
}

TEST(CheckCommand, TheNumberOfFramesItNamesSaysWhatMovesWithIt) {
  const std::string text = with(reveal_in(48), "[[track]]\n", "[[track]]\nease_in = 4\n");
  EXPECT_THAT(check_text(text).out, HasSubstr(", with ease_in and ease_out in proportion\n"));
}

TEST(CheckCommand, ACornerIsRefusedWithItsRemedyAndNoNumberOfFramesCuresIt) {
  const ProgramRun run = check_text(with_corners());
  EXPECT_EQ(run.status, 3);
  EXPECT_THAT(run.err, HasSubstr("which no drive can follow\n"));
  EXPECT_THAT(run.err, HasSubstr("note: it fits with spline = \"smooth\"; this was tried\n"));
  EXPECT_THAT(run.out, HasSubstr("  steps:\n"));
  EXPECT_THAT(
      run.out,
      HasSubstr("\ndoes not fit in 192 frames; no number of frames would do: axis \"slide\" would step by "));
}

TEST(CheckCommand, ItsJsonHasTheFieldsOfItsFormatInTheirOrder) {
  const ProgramRun run = check_file(reveal, {"--json", "-"});
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.err, StartsWith("reveal on slider")) << "the table makes way";
  const Json json = Json::parse(run.out);
  EXPECT_THAT(fields(json), ElementsAre("format", "fits", "smallest_frames", "smallest_frames_other_curve",
                                        "reason", "axes", "steps", "stop", "highest_rate"));
  EXPECT_EQ(json["format"], 1);
  EXPECT_EQ(json["fits"], true);
  EXPECT_EQ(json["reason"], nullptr);
  EXPECT_THAT(json["steps"], SizeIs(0));
  ASSERT_THAT(json["axes"], SizeIs(3));
  const Json& pan = json["axes"][1];
  EXPECT_THAT(fields(pan), ElementsAre("name", "position", "velocity", "acceleration", "jerk"));
  EXPECT_EQ(pan["name"], "pan");
  EXPECT_THAT(fields(pan["position"]), ElementsAre("min", "max", "limit_min", "limit_max"));
  EXPECT_EQ(pan["position"]["min"], -62);
  EXPECT_EQ(pan["position"]["limit_max"], 180);
  for (const char* quantity : {"velocity", "acceleration", "jerk"}) {
    EXPECT_THAT(fields(pan[quantity]), ElementsAre("peak", "frame", "limit"));
    EXPECT_GT(pan[quantity]["peak"], 0);
  }
  EXPECT_EQ(pan["jerk"]["limit"], 1800);
}

TEST(CheckCommand, ItsJsonReadsBackExactly) {
  const Json json = Json::parse(check_file(reveal, {"--json", "-"}).out);
  const CheckReport report = check(Plan(read_move_file(reveal), read_rig_file(camera_rig), {}));
  for (std::size_t a = 0; a < report.axes.size(); ++a) {
    EXPECT_EQ(json["axes"][a]["velocity"]["peak"], report.axes[a].velocity.value);
    EXPECT_EQ(json["axes"][a]["jerk"]["frame"], report.axes[a].jerk.frame);
    EXPECT_EQ(json["axes"][a]["position"]["max"], report.axes[a].range->highest.value);
  }
}

TEST(CheckCommand, ItsJsonListsStepsAndSaysWhyThereIsNoNumberOfFrames) {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "a.json").string();
  EXPECT_EQ(check_text(with_corners(), {"--json", file}).status, 3) << "written all the same";
  const Json json = Json::parse(file_contents(file));
  EXPECT_EQ(json["fits"], false);
  EXPECT_EQ(json["smallest_frames"], nullptr);
  EXPECT_THAT(json["reason"].get<std::string>(), HasSubstr("which no drive can follow"));
  ASSERT_THAT(json["steps"], SizeIs(9)) << "three axes at three keys";
  EXPECT_THAT(fields(json["steps"][0]),
              ElementsAre("key", "frame", "axis", "velocity_step", "acceleration_step"));
  EXPECT_EQ(json["steps"][0]["key"], 1);
  EXPECT_EQ(json["steps"][1]["axis"], "pan");
}

TEST(CheckCommand, ThePeakOfAMoveWithoutBoundIsNull) {
  const std::string cusp =
      with(with(file_contents(reveal), "\"smooth\"", "\"tcb\""), "{ at = [ 860.0, -30.0,   4.0] }",
           "{ at = [ 860.0, -30.0,   4.0], tension = 1 }");
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "a.json").string();
  const ProgramRun run = check_text(cusp, {"--json", file});
  EXPECT_EQ(run.status, 3);
  EXPECT_THAT(run.out, HasSubstr("no bound"));
  EXPECT_EQ(Json::parse(file_contents(file))["axes"][0]["acceleration"]["peak"], nullptr);
}

/// Adds the names of all fields at any depth.
void collect_fields(const Json& json, std::set<std::string>& names) {
  for (const auto& [name, value] : json.items()) {
    if (json.is_object()) names.insert(name);
    if (value.is_structured()) collect_fields(value, names);
  }
}

TEST(CheckCommand, EveryFieldOfItsJsonIsDocumented) {
  const std::string document = file_contents(in_checkout("docs/formats.md"));
  const std::size_t begin = document.find("### JSON of check");
  const std::string section = document.substr(begin, document.find("\n### ", begin) - begin);
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "a.json").string();
  check_text(with_corners(), {"--json", file});
  std::set<std::string> names;
  collect_fields(Json::parse(file_contents(file)), names);
  EXPECT_GE(names.size(), 18U);
  for (const std::string& name : names) {
    EXPECT_THAT(section, HasSubstr("`" + name + "`"));
  }
}

TEST(CheckCommand, DrawsPicturesOfMovesThatFitAndOfMovesThatDoNot) {
  const TemporaryFolder folder;
  for (const char* name : {"a.svg", "a.png", "a.pdf"}) {
    const std::string file = (folder.path() / name).string();
    EXPECT_EQ(check_file(reveal, {"--plot", file}).status, 0);
    EXPECT_GT(fs::file_size(file), 1000U) << name;
    fs::remove(file);
    EXPECT_EQ(check_text(with_corners(), {"--plot", file}).status, 3);
    EXPECT_GT(fs::file_size(file), 1000U) << name;
  }
}

TEST(CheckCommand, ItsHelpNamesEveryOptionAndSaysWhatItProves) {
  const ProgramRun run = run_program({"check", "--help"});
  EXPECT_EQ(run.status, 0);
  for (const char* words : {"MOVE", "--rig ", "--json ", "--plot ", "--help", "svg",
                            "not below the true one and at most 0.001 % above it", "spline = \"smooth\"",
                            "Exit status: 0 the move fits, or --fit found a curve; 3 it does not"}) {
    EXPECT_THAT(run.out, HasSubstr(words));
  }
}

TEST(CheckCommand, WrongUsageIsStatus2AndBadInputStatus1) {
  EXPECT_EQ(run_program({"check", reveal}).status, 2) << "a rig has the limits";
  EXPECT_EQ(run_program({"check", reveal, "--rig", camera_rig, "--plot", "a.gif"}).status, 2);
  EXPECT_EQ(run_program({"check", reveal, "--rig", camera_rig, "--json", camera_rig}).status, 2);
  EXPECT_EQ(run_program({"check", "no.toml", "--rig", camera_rig}).status, 1);
  EXPECT_EQ(run_program({"check", reveal, "--rig", camera_rig, "--json", "/dev/full"}).status, 1);
}

TEST(CheckCommand, ShowsItsProgressOnATerminal) {
  const ProgramRun run = run_program({"check", reveal, "--rig", camera_rig},
                                     {.out_path = {}, .err_path = {}, .err_on_terminal = true});
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.err, testing::ContainsRegex("trying [0-9]+ frames"));
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << "the line is ended once";
}

TEST(CheckCommand, RunRefusesWhatCheckRefusesAndMovesNothing) {
  const TemporaryFolder folder;
  const std::string json = (folder.path() / "report.json").string();
  for (const std::string& text : {reveal_in(48), with_corners()}) {
    const TemporaryFile move("move.toml", text);
    const std::string file = move.path().string();
    const ProgramRun run = run_program({"run", file, "--rig", camera_rig, "--sim", "--fast", "--json", json});
    EXPECT_EQ(run.status, 3);
    EXPECT_EQ(run.out, "");
    const std::string first_reason = check_file(file).err;
    const std::string what = first_reason.substr(0, first_reason.find_first_of(";\n"));
    EXPECT_THAT(run.err, StartsWith(what + "; ")) << "with what cures such a fault as a rule";
    EXPECT_TRUE(fs::is_empty(folder.path())) << "no report of what did not move";
  }
}

TEST(CheckCommand, TellsHowLongTheLongestStopTakesAndHowFastTheMoveCouldBePlayed) {
  const ProgramRun run = check_file(reveal, {"--json", "-"});
  const Json json = Json::parse(run.out);
  const Json& stop = json["stop"];
  EXPECT_THAT(fields(stop), ElementsAre("longest_s", "longest_frames", "from_frame", "forward", "axes"));
  EXPECT_GT(stop["longest_s"], 0.1);
  EXPECT_LT(stop["longest_s"], 2);
  EXPECT_LT(stop["longest_frames"].get<double>(), 24 * stop["longest_s"].get<double>());
  ASSERT_THAT(stop["axes"], SizeIs(3));
  EXPECT_THAT(fields(stop["axes"][0]), ElementsAre("name", "position", "velocity", "acceleration", "jerk"));
  EXPECT_EQ(stop["axes"][0]["acceleration"]["limit"], 1.5 * 800);
  EXPECT_EQ(stop["axes"][0]["jerk"]["limit"], 1.5 * 8000);
  for (const Json& axis : stop["axes"]) {
    EXPECT_LE(axis["acceleration"]["peak"], axis["acceleration"]["limit"]);
    EXPECT_LE(axis["jerk"]["peak"], axis["jerk"]["limit"]);
  }
  // At this rate the move would have as many frames as are named.
  EXPECT_NEAR(192 / json["highest_rate"].get<double>(), json["smallest_frames"].get<double>(), 1.5);
  EXPECT_THAT(run.err, HasSubstr("a controlled stop takes"));
  EXPECT_THAT(run.err, HasSubstr("every limit holds up to"));
}

TEST(CheckCommand, AMoveThatCouldNotBeStoppedInsideItsLimitsIsRefused) {
  // The motion takes 788.796 mm/s^2 of what is allowed, and a stop may take no more than the motion.
  const auto rig_with = [](const std::string& acceleration) {
    std::string rig = with(file_contents(camera_rig), "max_acceleration = 800.0",
                           "max_acceleration = " + acceleration + "\nstop_acceleration = " + acceleration);
    rig = with(with(rig, "max_velocity = 500.0", "max_velocity = 5000.0"), "= 8000.0", "= 80000.0");
    rig = with(with(rig, "max_velocity = 90.0", "max_velocity = 900.0"), "= 180.0\nmax_jerk = 1800.0",
               "= 1800.0\nmax_jerk = 18000.0");
    return rig;
  };
  const TemporaryFile move("move.toml", reveal_in(102));
  const auto check_on = [&](const std::string& acceleration) {
    const TemporaryFile machine("rig.toml", rig_with(acceleration));
    return run_program({"check", move.path().string(), "--rig", machine.path().string()});
  };
  const ProgramRun refused = check_on("788.8");
  EXPECT_EQ(refused.status, 3) << refused.out;
  EXPECT_THAT(refused.err, HasSubstr("axis \"slide\" could not be stopped at frame"));
  EXPECT_THAT(refused.err, HasSubstr("and stop_acceleration is 788.8 mm/s^2\n"));
  EXPECT_THAT(refused.err,
              HasSubstr("note: it fits with the speed curve that --fit OUT writes; this was tried\n"));
  // Named is the peak of the motion itself, and no bound of a stretch that is above it.
  const ProgramRun loose = check_on("900.0");
  const std::string words = "the motion alone takes ";
  const std::size_t at = refused.err.find(words);
  ASSERT_NE(at, std::string::npos);
  EXPECT_NEAR(std::stod(refused.err.substr(at + words.size())), 788.796, 0.01);
  EXPECT_EQ(loose.status, 0);
}

TEST(CheckCommand, FitWritesTheSameFileWithASpeedCurveThatFits) {
  const TemporaryFolder folder;
  const std::string fitted = (folder.path() / "fitted.toml").string();
  const std::string text = reveal_in(150);
  EXPECT_EQ(check_text(text).status, 3);
  const ProgramRun run = check_text(text, {"--fit", fitted});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.err, "");
  EXPECT_THAT(run.out, HasSubstr("does not fit in 150 frames"));
  EXPECT_THAT(run.out, HasSubstr("new speed curve of slide, pan, tilt: 10 control values; changed by"));
  EXPECT_THAT(run.out, EndsWith("with it the move fits in its 150 frames: " + fitted + "\n"));
  EXPECT_EQ(check_file(fitted).status, 0);
  const std::string written = file_contents(fitted);
  const auto around = [](const std::string& all) {
    const std::size_t begin = all.find("speed   = [");
    return all.substr(0, begin) + all.substr(all.find(']', begin));
  };
  EXPECT_EQ(around(written), around(text)) << "nothing but the numbers of the curve";
}

TEST(CheckCommand, FitOfAMoveThatFitsIsACopyOfIt) {
  const ProgramRun run = check_file(reveal, {"--fit", "-"});
  EXPECT_EQ(run.status, 0);
  EXPECT_EQ(run.out, file_contents(reveal));
  EXPECT_THAT(run.err, HasSubstr("nothing to change"));
}

TEST(CheckCommand, FitThatFindsNothingSaysWhyAndWritesNothing) {
  const TemporaryFolder folder;
  const std::string fitted = (folder.path() / "fitted.toml").string();
  const ProgramRun run = check_text(reveal_in(48), {"--fit", fitted, "--json", "-"});
  EXPECT_EQ(run.status, 3);
  EXPECT_THAT(run.err, HasSubstr("no speed curve was found for 48 frames: the path takes at least"));
  EXPECT_THAT(run.err, HasSubstr("the curve as it is fits in 169 frames"));
  EXPECT_TRUE(fs::is_empty(folder.path()));
  const Json json = Json::parse(run.out);
  EXPECT_EQ(json["fit"]["found"], false);
  EXPECT_GT(json["fit"]["least_frames"], 48);
  EXPECT_THAT(json["fit"]["tracks"], SizeIs(0));
}

double height_of_picture(const std::string& svg) {
  const std::string text = file_contents(svg);
  const std::size_t at = text.find("height=\"");
  return at == std::string::npos ? 0 : std::stod(text.substr(at + 8));
}

TEST(CheckCommand, FitsInTheFewestFramesForWhichACurveIsFound) {
  const std::string move =
      "name = \"slide\"\nfps = 24\nframes = 120 # five seconds\n[[track]]\naxes = [\"slide\"]\n"
      "keys = [{ at = [60] }, { at = [500], frame = 55 }, { at = [1240] }]\nspeed = [0, 0, 2, 30, 2, 0, 0]\n";
  const TemporaryFolder folder;
  const auto file = [&](const char* name) { return (folder.path() / name).string(); };
  const ProgramRun run = check_text(move, {"--fit", file("fitted.toml"), "--fewest", "--json",
                                           file("report.json"), "--plot", file("fitted.svg")});
  ASSERT_EQ(run.status, 0) << run.err;
  const Json report = Json::parse(file_contents(file("report.json")));
  const int fewest = report["fit"]["frames"];
  EXPECT_LT(fewest, report["smallest_frames"].get<int>());
  EXPECT_GE(fewest, report["fit"]["least_frames"].get<int>());
  EXPECT_EQ(report["smallest_frames_other_curve"], fewest);
  const std::string along = ", with the frames of the keys in proportion\n";
  EXPECT_THAT(run.out, HasSubstr(std::to_string(fewest) + " frames with another speed curve" + along));
  // Without the file to write the curve has as many control values as the drawn one, and no fewer frames.
  const ProgramRun plain = check_text(move, {"--json", file("plain.json")});
  EXPECT_THAT(plain.out, HasSubstr(" with another speed curve of as many control values" + along));
  EXPECT_GE(Json::parse(file_contents(file("plain.json")))["smallest_frames_other_curve"], fewest);
  const std::string text = file_contents(file("fitted.toml"));
  EXPECT_THAT(text, HasSubstr("frames = " + std::to_string(fewest) + " # five seconds"));
  EXPECT_THAT(text, HasSubstr("frame = " + std::to_string((110 * fewest + 120) / 240) + " }"));
  EXPECT_EQ(check_text(text).status, 0);
  EXPECT_EQ(check_text(move, {"--plot", file("drawn.svg")}).status, 3);
  EXPECT_GT(height_of_picture(file("fitted.svg")), height_of_picture(file("drawn.svg")) + 100)
      << "with a row for the curves";
}

TEST(CheckCommand, FitIsInTheJsonWhereItIsAskedFor) {
  const TemporaryFolder folder;
  const std::string report = (folder.path() / "report.json").string();
  const ProgramRun run = check_text(reveal_in(150), {"--fit", "-", "--start", "curvature", "--json", report});
  EXPECT_EQ(run.status, 0) << run.err;
  const Json json = Json::parse(file_contents(report));
  EXPECT_THAT(fields(json["fit"]),
              ElementsAre("found", "was_ended", "reason", "frames", "least_frames", "tracks"));
  const Json& track = json["fit"]["tracks"][0];
  EXPECT_THAT(fields(track), ElementsAre("track", "start", "speed", "change", "change_share",
                                         "largest_change", "alpha", "frame"));
  EXPECT_THAT(run.out, HasSubstr("speed   = [0, 0, "));
  EXPECT_EQ(check_text(run.out).status, 0);
  const std::string document = file_contents(in_checkout("docs/formats.md"));
  const std::string section = document.substr(document.find("In `fit`:"));
  for (const Json* object : {&json["fit"], &track}) {
    for (const std::string& name : fields(*object)) EXPECT_THAT(section, HasSubstr("`" + name + "`"));
  }
}

TEST(CheckCommand, StartAndSecondsNeedFit) {
  for (const auto& [option, value] : {std::pair{"--start", "curvature"}, {"--seconds", "10"}}) {
    const ProgramRun run = check_file(reveal, {option, value});
    EXPECT_EQ(run.status, 2);
    EXPECT_THAT(run.err, HasSubstr("--fit"));
  }
  for (const char* seconds : {"0", "-1", "nan", "soon"}) {
    EXPECT_EQ(check_file(reveal, {"--fit", "-", std::string("--seconds=") + seconds}).status, 2) << seconds;
  }
}

TEST(CheckCommand, FitThatHasNoTimeSaysSoAndWritesNothing) {
  const TemporaryFolder folder;
  const std::string fitted = (folder.path() / "fitted.toml").string();
  const ProgramRun run = check_text(reveal_in(150), {"--fit", fitted, "--seconds", "1e-9", "--json", "-"});
  EXPECT_EQ(run.status, 3);
  EXPECT_THAT(run.err, HasSubstr("no speed curve was found for 150 frames: the search was ended"));
  EXPECT_THAT(run.err, HasSubstr("note: the search ended after 1e-09 s; --seconds lets it go on"));
  EXPECT_THAT(run.err,
              HasSubstr("does not fit in 150 frames; the search for the frames that would do was ended"));
  EXPECT_TRUE(fs::is_empty(folder.path()));
  const Json json = Json::parse(run.out);
  EXPECT_EQ(json["fit"]["was_ended"], true);
  EXPECT_EQ(json["smallest_frames"], nullptr);
}

}  // namespace check_command_test
}  // namespace inbetween
