#include "host_tools/move_model/speed_rewrite.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/text/text_file.hpp"
#include "tests/support/places.hpp"
#include "tests/support/refused_text.hpp"

namespace inbetween {
namespace speed_rewrite_test {

using testing::ElementsAreArray;

/// A move of one track that ends with this line.
std::string move_with(const std::string& speed_line) {
  return "name = \"m\"\nfps = 24\nframes = 48\n[[track]]\naxes = [\"x\"]\nkeys = [{ at = [0] }, { at = [5] "
         "}]\n" +
         speed_line + "\n";
}

/// What becomes of the line of speed, and of nothing else.
std::string line_with(const std::string& speed_line, const std::vector<double>& speed) {
  const std::string result = with_speed(move_with(speed_line), "file.toml", 0, speed);
  const std::string before = move_with("");
  const std::string_view head = std::string_view(before).substr(0, before.size() - 1);
  EXPECT_EQ(std::string_view(result).substr(0, head.size()), head);
  EXPECT_EQ(result.back(), '\n');
  return result.substr(head.size(), result.size() - head.size() - 1);
}

TEST(SpeedRewrite, PutsEachNumberWhereTheOldOneStood) {
  EXPECT_EQ(line_with("speed   =  [0,0 ,  10.50,4 ]  # drawn by hand", {0, 12.25, 7, 0}),
            "speed   =  [0,12.25 ,  7,0 ]  # drawn by hand");
}

TEST(SpeedRewrite, KeepsCommentsAndLinesInsideTheList) {
  EXPECT_EQ(line_with("speed = [ # from rest, [not] a list\n"
                      "  0, 0,  # ]\n"
                      "\t10#peak, 7\n"
                      "  , 4,\n"
                      "  # the end: \"\n"
                      "]",
                      {1, 2, 3, 4.5}),
            "speed = [ # from rest, [not] a list\n"
            "  1, 2,  # ]\n"
            "\t3#peak, 7\n"
            "  , 4.5,\n"
            "  # the end: \"\n"
            "]");
}

TEST(SpeedRewrite, FurtherNumbersAreSpacedAsTheLastTwo) {
  EXPECT_EQ(line_with("speed = [1,2]", {1, 2, 3, 4}), "speed = [1,2,3,4]");
  EXPECT_EQ(line_with("speed = [\n  1,\n  2,\n]", {1, 2, 3}), "speed = [\n  1,\n  2,\n  3,\n]");
  EXPECT_EQ(line_with("speed = [1 # one\n  , # then\n  2 # two\n]", {1, 2, 3}),
            "speed = [1 # one\n  , # then\n  2, 3 # two\n]");
  EXPECT_EQ(line_with("speed = [7]", {1, 2, 3}), "speed = [1, 2, 3]");
}

TEST(SpeedRewrite, SurplusNumbersGoWithTheCommaBeforeThem) {
  EXPECT_EQ(line_with("speed = [1, 2, 3]", {4}), "speed = [4  ]");
  EXPECT_EQ(line_with("speed = [1, 2, 3,]", {4, 5}), "speed = [4, 5 ,]");
  EXPECT_EQ(line_with("speed = [1, # a\n 2, # b\n 3 # c\n]", {4}), "speed = [4 # a\n  # b\n  # c\n]");
}

TEST(SpeedRewrite, NumbersReadBackToTheLastBit) {
  const std::vector<double> speed = {
      0.1,  1.0 / 3, std::nextafter(100.0, 0.0), 5e-324, std::numeric_limits<double>::min(), 1e-7, 100,
      -0.0, 1};
  const std::string text = with_speed(move_with("speed = [1]"), "file.toml", 0, speed);
  EXPECT_THAT(parse_move(text, "").tracks[0].speed, ElementsAreArray(speed));
  EXPECT_EQ(line_with("speed = [1]", {0.1, 100, -0.0}), "speed = [0.1, 100, 0]");
}

TEST(SpeedRewrite, KnowsEveryWayToWriteANumberOrTheName) {
  EXPECT_EQ(line_with("\"speed\" = [+1.5e0, 0x10, 1_0.0, 0b1, 0o7]", {1, 2, 3, 4, 5}),
            "\"speed\" = [1, 2, 3, 4, 5]");
  EXPECT_EQ(line_with("'speed'=[1]", {2}), "'speed'=[2]");
  EXPECT_EQ(line_with("\"sp\\u0065ed\" = [1]", {2}), "\"sp\\u0065ed\" = [2]");
}

TEST(SpeedRewrite, FindsTheListInAnInlineTable) {
  const std::string text =
      "name = \"m\"\nfps = 24\nframes = 48\n"
      "track = [ { axes = ['[x', \"]\"], speed = [ 1 ], keys = [{at=[0,0]},{at=[1,2]}] }, "
      "{ speed = [2], axes = [\"z\"], keys = [{at=[0]},{at=[1]}] } ] # speed = [3]";
  EXPECT_EQ(with_speed(text, "file.toml", 0, std::vector<double>{4, 5}), with(text, "[ 1 ]", "[ 4, 5 ]"));
  EXPECT_EQ(with_speed(text, "file.toml", 1, std::vector<double>{4, 5}), with(text, "[2]", "[4, 5]"));
}

TEST(SpeedRewrite, CountsColumnsInCharactersNotBytes) {
  const std::string text =
      "name = \"\"\"speed = [9] \xF0\x9F\x8E\xA5\"\"\"\nfps = 24\nframes = 48\n"
      "track = [ { axes = [\"Kran \xC3\xBC\xE2\x86\x92\xF0\x9F\x8E\xA5\"], keys = [{at=[0]},{at=[1]}], "
      "speed = [1] } ]\n";
  EXPECT_EQ(with_speed(text, "file.toml", 0, std::vector<double>{2}),
            with(text, "speed = [1]", "speed = [2]"));
}

TEST(SpeedRewrite, KeepsWindowsLineEndsAndTheByteOrderMark) {
  std::string text = move_with("speed = [ # a\r\n  1,\r\n  2 ]");
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2)
    if (text[at - 1] != '\r') text.insert(at, "\r");
  for (const std::string mark : {"", "\xef\xbb\xbf"}) {
    EXPECT_EQ(with_speed(mark + text, "file.toml", 0, std::vector<double>{1, 3, 5}),
              mark + with(text, "1,\r\n  2", "1,\r\n  3,\r\n  5"));
  }
  // The list in the first line of the file, behind the mark.
  const std::string first =
      "\xef\xbb\xbftrack = [{speed=[1],axes=['x'],keys=[{at=[0]},{at=[1]}]}]\r\n"
      "name = 'm'\r\nfps = 24\r\nframes = 3";
  EXPECT_EQ(with_speed(first, "file.toml", 0, std::vector<double>{8}), with(first, "speed=[1]", "speed=[8]"));
}

TEST(SpeedRewrite, LeavesTheOtherTracksAlone) {
  const std::string text = move_with("speed = [1, 2]") +
                           "[[track]]\naxes = [\"y\"]\nspeed = [1, 2] # the second\n"
                           "keys = [{ at = [0] }, { at = [1], frame = 20, hold = 3 }, { at = [5] }]\n"
                           "[[track]]\naxes = [\"z\"]\nkeys = [{ at = [0] }, { at = [5] }]\nspeed = [3]\n";
  EXPECT_EQ(with_speed(text, "file.toml", 1, std::vector<double>{0, 0.5, 0}),
            with(text, "[1, 2] # the second", "[0, 0.5, 0] # the second"));
}

TEST(SpeedRewrite, ExamplesKeepAllButTheirNumbers) {
  for (const auto& file : std::filesystem::directory_iterator(in_checkout("examples"))) {
    if (file.path().extension() != ".toml") continue;
    const std::string text = read_text_file(file.path());
    if (text.find("[[track]]") == std::string::npos) continue;
    const MoveFile move = parse_move(text, file.path().string());
    for (std::size_t track = 0; track < move.tracks.size(); ++track) {
      if (move.tracks[track].timing == Timing::frames) continue;
      std::vector<double> speed = move.tracks[track].speed;
      EXPECT_EQ(parse_move(with_speed(text, "example", track, speed), "example").tracks[track].speed, speed);
      speed.insert(speed.end(), 40, 12.5);
      if (move.tracks[track].periodic) speed.back() = speed.front();
      const std::string changed = with_speed(text, "example", track, speed);
      speed.resize(move.tracks[track].speed.size());
      EXPECT_EQ(parse_move(with_speed(changed, "example", track, speed), "example").tracks[track].speed,
                speed);
    }
  }
}

TEST(SpeedRewrite, ATrackTimedByFramesHasNoSpeedToChange) {
  const std::vector<double> speed = {1};
  expect_refused([&](std::string_view text, const std::string& file) { with_speed(text, file, 1, speed); },
                 move_with("speed = [1]") +
                     "@[[track]]\naxes = [\"y\"]\ntiming = \"frames\"\n"
                     "keys = [{ at = [0], frame = 0 }, { at = [5], frame = 48 }]\n",
                 {"track 1", "timing = \"frames\"", "no speed curve"});
}

TEST(SpeedRewrite, RefusesWhatAFileCannotHold) {
  const std::vector<double> many(max_control_values + 1, 1.0);
  expect_refused([&](std::string_view text, const std::string& file) { with_speed(text, file, 0, many); },
                 move_with("speed = @[1]"), {"2049", "2048"});
  const std::vector<double> speed(100, 1.0 / 3);
  const std::string comment(max_file_bytes - move_with("speed = [1]").size() - 3, 'x');
  expect_refused([&](std::string_view text, const std::string& file) { with_speed(text, file, 0, speed); },
                 move_with("speed = @[1]") + "#" + comment, {"bytes", "8388608"});
  expect_refused([&](std::string_view text, const std::string& file) { with_speed(text, file, 0, speed); },
                 move_with("speed = @\"fast\""), {"speed is text"});
}

TEST(SpeedRewrite, RefusesNumbersThatAreNoControlValues) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::string text = move_with("speed = [1]");
  for (const std::vector<double>& wrong : {std::vector<double>{}, {-1}, {100.5}, {nan}})
    EXPECT_THROW(with_speed(text, "file.toml", 0, wrong), std::invalid_argument);
  EXPECT_THROW(with_speed(text, "file.toml", 1, std::vector<double>{1}), std::out_of_range);
}

}  // namespace speed_rewrite_test
}  // namespace inbetween
