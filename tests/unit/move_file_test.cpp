#include "host_tools/move_model/move_file.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>

#include "tests/support/refused_text.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace move_file_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* reveal = R"(name = "reveal"
fps = 24
frames = 240

[[track]]
axes = ["track", "lift"]
keys = [
  { at = [0.0, 0.0] },
  { at = [900, 80.0], frame = 150 },
  { at = [1500.0, -1e-3] },
]
speed = [0, 0, 10, 4.5, 0, 0]
weights = [1.0, 0.5]
)";

constexpr const char* locked = R"(name = "a bow"
fps = "24000/1001"
frames = 100
[[track]]
axes = ["tilt"]
spline = "tcb"
closed = true
keys = [
  { at = [0], tension = 1, continuity = -1, bias = 0.25 },
  { at = [5], frame = 40, break = true, hold = 12 },
]
speed = [1]
[[track]]
axes = ["pan"]
spline = "linear"
timing = "frames"
kinetic = "monotone"
keys = [ { at = [0], frame = 0 }, { at = [5], frame = 100 } ]
)";

void expect_move_refused(const std::string& marked, std::initializer_list<std::string_view> words) {
  expect_refused([](std::string_view text, const std::string& file) { parse_move(text, file); }, marked,
                 words);
}

/// The reveal with one thing changed; the mark @ is in `to`.
void expect_change_refused(std::string_view from, std::string_view to,
                           std::initializer_list<std::string_view> words) {
  expect_move_refused(with(reveal, from, to), words);
}

std::string error_of_file(const std::filesystem::path& path) {
  try {
    read_move_file(path);
  } catch (const InputError& error) {
    EXPECT_EQ(error.place().line, 0U);
    return error.what();
  }
  return "accepted";
}

// ---- what is accepted

TEST(MoveFile, WordsWithoutQuotesAndDecimalCommasAreNamed) {
  const std::string keys = "keys = [{at=[0]},{at=[1]MORE},{at=[2]}]\nspeed = [5]\n";
  const auto refused = [&](const std::string& axes, const std::string& more, const std::string& word) {
    expect_move_refused(
        "name = \"m\"\nfps = 24\nframes = 9\n[[track]]\naxes = [" + axes + "]\n" + with(keys, "MORE", more),
        {word});
  };
  refused("@jaw", "", "jaw is neither a number nor in quotes; write \"jaw\"");
  refused("\"jaw\"", ", ease = @yes", "write true");
  refused("\"jaw\"", ", ease = @False", "write false");
  refused("\"jaw\"", ", @hodl = 1", "did you mean \"hold\"?");
  refused("\"jaw\"", ", @att = 1", "did you mean \"at\"?");
  expect_move_refused("name = \"m\"\nfps = 29@,97\n", {"29,97 has a decimal comma; write 29.97"});
  expect_move_refused("a = { jaw = 12,5 @}\n", {"12,5 has a decimal comma; write 12.5"});
}

TEST(MoveFile, KeysThatAllHaveAFrameAreToldOfTiming) {
  expect_move_refused(
      "name = \"m\"\nfps = 24\nframes = 9\n@[[track]]\naxes = [\"a\"]\n"
      "keys = [{at=[0],frame=0},{at=[1],frame=9}]\n",
      {"every key has a frame; add timing = \"frames\", or speed ="});
}

TEST(MoveFile, ReadsAMoveWithTheDefaultsAndThePlaces) {
  const MoveFile move = parse_move(reveal, "reveal.toml");
  EXPECT_EQ(move.path, "reveal.toml");
  EXPECT_EQ(move.name, "reveal");
  EXPECT_EQ(move.fps.rate.numerator, 24);
  EXPECT_EQ(move.fps.rate.denominator, 1);
  EXPECT_EQ(move.fps.as_written, "24");
  EXPECT_TRUE(move.fps.written_as_integer);
  EXPECT_EQ(move.frames, 240);
  EXPECT_EQ(to_string(move.frames_place), "reveal.toml:3:10");

  ASSERT_EQ(move.tracks.size(), 1U);
  const MoveTrack& track = move.tracks[0];
  EXPECT_THAT(track.axes, ElementsAre("track", "lift"));
  EXPECT_EQ(to_string(track.axis_places.at(1)), "reveal.toml:6:18");
  EXPECT_EQ(track.spline, Spline::smooth);
  EXPECT_FALSE(track.closed);
  EXPECT_EQ(track.timing, Timing::speed);
  EXPECT_FALSE(track.kinetic.has_value());
  EXPECT_THAT(track.speed, ElementsAre(0, 0, 10, 4.5, 0, 0));
  EXPECT_THAT(track.weights, ElementsAre(1, 0.5));
  EXPECT_EQ(to_string(track.place), "reveal.toml:5:1");
  EXPECT_EQ(to_string(track.speed_place), "reveal.toml:12:9");
  EXPECT_EQ(to_string(track.speed_places.at(3)), "reveal.toml:12:20");
  EXPECT_EQ(to_string(track.weight_places.at(1)), "reveal.toml:13:17");

  ASSERT_EQ(track.keys.size(), 3U);
  EXPECT_THAT(track.keys[1].at, ElementsAre(900, 80));
  EXPECT_THAT(track.keys[2].at, ElementsAre(1500, -1e-3));
  EXPECT_EQ(track.keys[1].frame, 150);
  EXPECT_FALSE(track.keys[0].frame.has_value());
  EXPECT_FALSE(track.keys[0].hold.has_value());
  EXPECT_FALSE(track.keys[0].breaks);
  EXPECT_EQ(to_string(track.keys[1].place), "reveal.toml:9:3");
  EXPECT_EQ(to_string(track.keys[1].at_places.at(1)), "reveal.toml:9:16");
}

TEST(MoveFile, ReadsEveryFieldOfKeysAndTimings) {
  const MoveFile move = parse_move(locked, "bow.toml");
  EXPECT_EQ(move.fps.rate.numerator, 24000);
  EXPECT_EQ(move.fps.rate.denominator, 1001);
  EXPECT_EQ(move.fps.as_written, "24000/1001");
  EXPECT_FALSE(move.fps.written_as_integer);
  ASSERT_EQ(move.tracks.size(), 2U);

  const MoveTrack& tilt = move.tracks[0];
  EXPECT_EQ(tilt.spline, Spline::tcb);
  EXPECT_TRUE(tilt.closed);
  EXPECT_THAT(tilt.weights, IsEmpty());
  EXPECT_EQ(tilt.keys.at(0).tension, 1);
  EXPECT_EQ(tilt.keys.at(0).continuity, -1);
  EXPECT_EQ(tilt.keys.at(0).bias, 0.25);
  EXPECT_EQ(tilt.keys.at(1).frame, 40);
  EXPECT_TRUE(tilt.keys.at(1).breaks);
  EXPECT_EQ(tilt.keys.at(1).hold, 12);

  const MoveTrack& pan = move.tracks[1];
  EXPECT_EQ(pan.spline, Spline::linear);
  EXPECT_EQ(pan.timing, Timing::frames);
  EXPECT_EQ(pan.kinetic, MoveKinetic::monotone);
  EXPECT_THAT(pan.speed, IsEmpty());
}

TEST(MoveFile, KnowsEverySplineAndKinetic) {
  const auto spline = [](const char* name) {
    return parse_move(with(reveal, "keys = [", fmt::format("spline = \"{}\"\nkeys = [", name)), "m")
        .tracks[0]
        .spline;
  };
  EXPECT_EQ(spline("smooth"), Spline::smooth);
  EXPECT_EQ(spline("catmull-rom"), Spline::catmull_rom);
  EXPECT_EQ(spline("tcb"), Spline::tcb);
  EXPECT_EQ(spline("linear"), Spline::linear);
  const MoveFile move = parse_move(with(locked, "kinetic = \"monotone\"", "kinetic = \"linear\""), "m");
  EXPECT_EQ(move.tracks[1].kinetic, MoveKinetic::linear);
}

TEST(MoveFile, AByteOrderMarkAndWindowsLineEndsChangeNothing) {
  std::string text = "\xef\xbb\xbf";
  for (const char c : std::string_view(reveal)) text += c == '\n' ? std::string("\r\n") : std::string(1, c);
  const MoveFile move = parse_move(text, "m");
  EXPECT_THAT(move.tracks.at(0).speed, ElementsAre(0, 0, 10, 4.5, 0, 0));
  const auto parse_behind_the_mark = [](const std::string& rest, const std::string& file) {
    parse_move("\xef\xbb\xbf" + rest, file);
  };
  expect_refused(parse_behind_the_mark, with(reveal, "\"reveal\"", "@1\r"), {"name is a whole number"});
  expect_refused(parse_behind_the_mark, with(reveal, "\"reveal\"", "\"@\xff"), {"is not UTF-8"});
}

TEST(MoveFile, NumbersReachOneToTheHundred) {
  const MoveFile move = parse_move(with(reveal, "1500.0", "-1e100"), "m");
  EXPECT_EQ(move.tracks.at(0).keys.at(2).at.at(0), -1e100);
}

TEST(MoveFile, TheLargestFramesAndRatesAreAccepted) {
  EXPECT_EQ(parse_move(with(reveal, "240", "1_000_000"), "m").frames, 1'000'000);
  EXPECT_EQ(parse_move(with(with(reveal, ", frame = 150", ""), "240", "1"), "m").frames, 1);
  EXPECT_EQ(parse_move(with(reveal, "fps = 24", "fps = 1000"), "m").fps.rate.numerator, 1000);
  EXPECT_EQ(parse_move(with(reveal, "fps = 24", "fps = \"1000000/1000\""), "m").fps.rate.denominator, 1000);
}

// ---- the file as a whole

TEST(MoveFile, ReadsAFileByItsPath) {
  const TemporaryFile file("reveal.toml", reveal);
  const MoveFile move = read_move_file(file.path());
  EXPECT_EQ(move.path, file.path().string());
  EXPECT_EQ(move.frames_place.file, file.path().string());
}

TEST(MoveFile, AMissingFileIsNamed) {
  EXPECT_EQ(error_of_file("no/such/move.toml"),
            "no/such/move.toml: error: there is no such file; check the path");
}

TEST(MoveFile, ADirectoryIsNotAFile) {
  const TemporaryFolder folder;
  EXPECT_EQ(error_of_file(folder.path()),
            folder.path().string() + ": error: is a directory; name the file in it");
}

TEST(MoveFile, AnUnreadableFileSaysWhy) {
  const TemporaryFolder folder;
  const std::filesystem::path loop = folder.path() / "loop.toml";
  std::filesystem::create_symlink(loop, loop);
  EXPECT_THAT(error_of_file(loop), HasSubstr("cannot be read: Too many levels of symbolic links"));
}

TEST(MoveFile, AFileWhoseReadingFailsSaysWhy) {
  // It opens, but nobody may read at address 0 of a process.
  EXPECT_THAT(error_of_file("/proc/self/mem"), HasSubstr("cannot be read: Input/output error"));
}

TEST(MoveFile, AFileOfOneHundredMegabytesIsRefusedUnread) {
  const TemporaryFile file("huge.toml", "");
  std::filesystem::resize_file(file.path(), 100'000'000);
  EXPECT_THAT(error_of_file(file.path()), HasSubstr("has 100000000 bytes, more than the 8388608 allowed"));
}

TEST(MoveFile, AnEndlessFileIsReadToTheLimitOnly) {
  EXPECT_THAT(error_of_file("/dev/zero"), HasSubstr("goes on beyond the 8388608 bytes allowed"));
}

TEST(MoveFile, AnEmptyFileSaysWhatAMoveHas) {
  expect_move_refused("@", {"the file is empty", "name, fps, frames and a [[track]]"});
  expect_move_refused("@# only a comment\n", {"the file is empty"});
}

TEST(MoveFile, InvalidUtf8IsFoundAtItsByte) {
  expect_change_refused("\"reveal\"", "\"r\xc3\xa9v@\xff\"",
                        {"byte 0xff is not UTF-8", "save the file as UTF-8"});
  for (const std::string_view bytes :
       {"\xc0\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xe2\x82", "\x80", "\xf0\x80\x80\x80"}) {
    expect_move_refused("name = \"@" + std::string(bytes) + "\"", {"is not UTF-8"});
  }
  expect_move_refused("# @\xe2\x82", {"byte 0xe2 is not UTF-8"});
}

TEST(MoveFile, LettersBeyondAsciiStandInQuotesOrComments) {
  const MoveFile move =
      parse_move(with(reveal, "\"reveal\"", "\"r\xc3\xa9v\xc3\xa8le \xf0\x9f\x8e\xa5\"  # \xc3\xa9"), "m");
  EXPECT_EQ(move.name, "r\xc3\xa9v\xc3\xa8le \xf0\x9f\x8e\xa5");
  expect_move_refused("n @\xc3\xa9 = 1", {"\"\xc3\xa9\" outside quotes; put the text in double quotes"});
  expect_move_refused("[@\xe4\xb8\xad]", {"\"\xe4\xb8\xad\" outside quotes"});
  expect_change_refused("frames = 240", "frames = 240@\xc2\xa0", {"outside quotes"});
}

TEST(MoveFile, ZeroBytesAreNotToml) {
  expect_move_refused("@" + std::string(3, '\0'), {"not valid TOML"});
}

// ---- TOML

TEST(MoveFile, ASyntaxErrorHasItsPlace) {
  expect_change_refused("fps = 24", "fps = @", {"not valid TOML", "correct it here"});
  expect_change_refused("fps = 24", "fps @24", {"not valid TOML", "expected '='"});
}

TEST(MoveFile, ADuplicateKeyIsFoundAtTheSecondOne) {
  expect_change_refused("frames = 240", "frames = 240\n  @frames   = 250",
                        {"\"frames\" is given a second time; keep one of the two"});
  expect_change_refused("{ at = [0.0, 0.0] }", "{ at = [0.0, 0.0], @at = [1.0, 0.0] }",
                        {"\"at\" is given a second time"});
  expect_move_refused("a = { \"\xc3\xa9\xc3\xa9\xc3\xa9\xc3\xa9\xc3\xa9\" = 1, at = 1, @at = 2 }",
                      {"\"at\" is given a second time"});
  expect_change_refused("[[track]]", "[[track]]\n@[track]", {"\"track\" is given a second time"});
}

TEST(MoveFile, NumbersBeyondTheirTypeAreFoundAtTheNumber) {
  expect_change_refused("240", "@99999999999999999999", {"\"99999999999999999999\" is too large"});
  expect_change_refused("80.0", "@1e400", {"\"1e400\" is too large"});
}

TEST(MoveFile, DeepArraysAreRefusedBeforeTheStackSuffers) {
  const std::string sixteen(16, '[');
  expect_move_refused("name = " + sixteen + "@" + std::string(1'000'000, '['),
                      {"nested deeper than 16 levels"});
}

TEST(MoveFile, DeepArraysInInlineTablesAreRefused) {
  std::string text = "name = ";
  for (int level = 0; level < 8; ++level) text += "{ a = [";
  text += " @";
  for (int level = 0; level < 100'000; ++level) text += "{ a = [";
  expect_move_refused(text, {"nested deeper than 16 levels"});
}

TEST(MoveFile, LongDottedKeysAreRefused) {
  std::string dots;
  for (int level = 0; level < 1'000'000; ++level) dots += ".a";
  const std::string sixteen = dots.substr(0, 32);
  expect_move_refused("a" + sixteen + "@" + dots + " = 1", {"nested deeper than 16 levels"});
  expect_move_refused("[a" + sixteen.substr(2) + "@" + dots + "]", {"nested deeper than 16 levels"});
  expect_move_refused("x = { \"a.b#\" . 'c' " + sixteen.substr(4) + "@" + dots + " = 1 }", {"nested deeper"});
}

TEST(MoveFile, QuotesAtTheEndOfAMultiLineStringHideNothing) {
  const std::string deep = std::string(15, '[') + "@" + std::string(100'000, '[');
  expect_move_refused("x = { a = '''b'''', c = " + deep, {"nested deeper than 16 levels"});
  expect_move_refused("x = { a = \"\"\"b\\\"\"\"\"\"\", c = " + deep, {"nested deeper than 16 levels"});
  expect_move_refused("x = { a = '', c = " + deep, {"nested deeper than 16 levels"});
}

TEST(MoveFile, BracketsAndDotsInTextAndCommentsDoNotNest) {
  const std::string many(100, '[');
  const std::string text =
      with(reveal, "name = \"reveal\"",
           "# " + many + "\nname = \"re\\\"veal " + many + "......................\" # '\"");
  EXPECT_EQ(parse_move(text, "m").name, "re\"veal " + many + "......................");
  const std::string multi_line = with(reveal, "\"reveal\"", "'''" + many + "''" + many + "'''''");
  EXPECT_EQ(parse_move(multi_line, "m").name, many + "''" + many + "''");
  expect_move_refused(with(reveal, "\"reveal\"", "@\"\"\"a\n" + many + "\"\"\""), {"control character"});
}

TEST(MoveFile, MoreFieldsThanAnyMoveHasAreRefused) {
  std::string text;
  for (int i = 0; i < 200'000; ++i) text += fmt::format("a{}.b=1\n", i);
  expect_move_refused(text + "a@=1", {"more than 200000 fields"});
  text.clear();
  for (int i = 0; i < 200'000; ++i) text += "[[track]]\n";
  expect_move_refused(text + " @[[track]]", {"more than 200000 fields"});
}

// ---- fields and types

TEST(MoveFile, AnUnknownFieldIsCorrected) {
  expect_change_refused("frames = 240", "@framse = 240",
                        {"the move has no field \"framse\"", "did you mean \"frames\"?"});
  expect_change_refused("weights", "@wieghts",
                        {"a track has no field \"wieghts\"", "did you mean \"weights\"?"});
  expect_change_refused("{ at = [0.0, 0.0] }", "{ at = [0.0, 0.0], @tensoin = 0 }",
                        {"key 0 has no field \"tensoin\"", "did you mean \"tension\"?"});
}

TEST(MoveFile, AnUnknownFieldLikeNoOtherMeetsTheListOfFields) {
  expect_change_refused("frames = 240", "frames = 240\n@colour = 1",
                        {"its fields are name, fps, frames, track"});
}

TEST(MoveFile, ControlCharactersOfAKeyDoNotReachTheTerminal) {
  expect_change_refused("frames = 240", "frames = 240\n@\"a\\n\\u001b[2J\" = 1", {"\"a\\x0a\\x1b[2J\""});
}

TEST(MoveFile, AVeryLongKeyIsShownShort) {
  expect_move_refused("@" + std::string(1000, 'k') + " = 1", {std::string(60, 'k') + "...\""});
}

TEST(MoveFile, MissingFieldsAreNamedWithAnExample) {
  expect_change_refused("name = \"reveal\"", "@", {"the move has no name; add name = "});
  expect_move_refused("@" + with(reveal, "fps = 24", ""), {"the move has no fps; add fps = 24"});
  expect_move_refused("@" + with(reveal, "frames = 240", ""), {"the move has no frames; add frames = "});
  expect_move_refused("@name = \"a\"\nfps = 24\nframes = 2", {"the move has no track; add a [[track]]"});
  expect_move_refused("name = \"a\"\nfps = 24\nframes = 2\ntrack = @[]", {"track is empty"});
  expect_move_refused(with(with(reveal, "[[track]]", "@[[track]]"), "axes = [\"track\", \"lift\"]", ""),
                      {"a track has no axes; add axes = "});
  expect_change_refused("{ at = [0.0, 0.0] }", "@{ }", {"key 0 has no at; add at = "});
}

TEST(MoveFile, WrongTypesSayWhatStandsThereAndWhatShould) {
  expect_change_refused("\"reveal\"", "@7", {"name is a whole number; write text in double quotes"});
  expect_change_refused("\"reveal\"", "@\"\"", {"name is empty"});
  expect_change_refused("[[track]]", "@[track]",
                        {"track is a single table; write a list of tables, [[...]]"});
  expect_change_refused("[\"track\", \"lift\"]", "@\"track\"", {"axes is text; write a list in [ ]"});
  expect_change_refused("[\"track\", \"lift\"]", "[\"track\", @2]",
                        {"axes[1] is a whole number; write text"});
  expect_change_refused("{ at = [0.0, 0.0] }", "@0.0",
                        {"keys[0] is a number with a fraction or exponent; write a table"});
  expect_change_refused("[900, 80.0]", "[900, @\"80\"]", {"at[1] is text; write a number"});
  expect_change_refused("[900, 80.0]", "[900, @true]", {"at[1] is true or false; write a number"});
  expect_change_refused("[900, 80.0]", "[900, @2020-02-02]", {"at[1] is a date; write a number"});
  expect_change_refused("keys = [", "closed = @1\nkeys = [",
                        {"closed is a whole number; write true or false"});
  expect_change_refused("[0, 0, 10, 4.5, 0, 0]", "@{ }", {"speed is a table; write a list"});
}

TEST(MoveFile, TextIsAtMost255Bytes) {
  const std::string longest(255, 'n');
  EXPECT_EQ(parse_move(with(reveal, "\"reveal\"", '"' + longest + '"'), "m").name, longest);
  expect_change_refused("\"reveal\"", "@\"n" + longest + "\"", {"name has 256 bytes; write at most 255"});
}

TEST(MoveFile, AnUnknownWordMeetsTheListOfWords) {
  expect_change_refused("keys = [", "spline = @\"smoth\"\nkeys = [",
                        {"spline is \"smoth\"; write \"smooth\", \"catmull-rom\", \"tcb\" or \"linear\""});
  expect_change_refused("keys = [", "timing = @\"frame\"\nkeys = [", {"write \"speed\" or \"frames\""});
  expect_move_refused(with(locked, "\"monotone\"", "@\"hermite\""),
                      {"write \"linear\", \"curves\", \"pace\" or \"monotone\""});
}

// ---- numbers

TEST(MoveFile, NotANumberAndInfinityAreRefused) {
  expect_change_refused("80.0", "@nan", {"at[1] is nan; write a number from -1e+100 to 1e+100"});
  expect_change_refused("80.0", "@inf", {"at[1] is inf; write a number"});
  expect_change_refused("80.0", "@-inf", {"at[1] is -inf; write a number"});
  expect_change_refused("4.5", "@nan", {"speed[3] is nan; write a number from 0 to 100"});
  expect_change_refused("0.5]", "@inf]", {"weights[1] is inf; write a number"});
  expect_change_refused("fps = 24", "fps = @nan", {"fps is nan; write a number from 1 to 1000"});
}

TEST(MoveFile, NumbersOfTooLargeMagnitudeAreRefused) {
  expect_change_refused("80.0", "@1e308", {"at[1] is 1e+308; write a number from -1e+100 to 1e+100"});
  expect_change_refused("80.0", "@-1.1e100", {"at[1] is -1.1e+100"});
}

TEST(MoveFile, FramesIsAWholeNumberFromOneToAMillion) {
  expect_change_refused("240", "@0", {"frames is 0; write a whole number from 1 to 1000000"});
  expect_change_refused("240", "@-240", {"frames is -240; write a whole number from 1"});
  expect_change_refused("240", "@1_000_001", {"frames is 1000001"});
  expect_change_refused("240", "@240.0", {"frames is a number with a fraction", "without a decimal point"});
  expect_change_refused("240", "@\"240\"", {"frames is text; write a whole number"});
}

TEST(MoveFile, FpsIsAWholeNumberOrAFraction) {
  expect_change_refused("fps = 24", "fps = @0", {"fps is 0; write a whole number from 1 to 1000"});
  expect_change_refused("fps = 24", "fps = @-24", {"fps is -24"});
  expect_change_refused("fps = 24", "fps = @1001", {"fps is 1001"});
  expect_change_refused("fps = 24", "fps = @0.0", {"fps is 0; write a number from 1"});
  expect_change_refused("fps = 24", "fps = @true", {"fps is true or false"});
  expect_change_refused("fps = 24", "fps = @\"24\"", {"fps is the text \"24\"; use 24 without quotes"});
  for (const char* text : {"24/0", "0/1", "-24/1", "24/1/1", "24 / 1", "/", "24/", "a/b", "24000/1001.0",
                           "1/1000001", "9999999999/1"}) {
    expect_change_refused("fps = 24", fmt::format("fps = @\"{}\"", text),
                          {"write two whole numbers from 1 to 1000000"});
  }
  expect_change_refused("fps = 24", "fps = @\"1001/1\"", {"write a rate of at most 1000"});
  expect_change_refused("fps = 24", "fps = @\"999001/999\"", {"write a rate of at most 1000"});
}

TEST(MoveFile, DecimalFpsIsRefusedWithTheExactRate) {
  const auto expect_advice = [](const char* fps, const char* advice) {
    expect_change_refused("fps = 24", fmt::format("fps = @{}", fps), {"not exact", advice});
  };
  expect_advice("23.976", "use \"24000/1001\"");
  expect_advice("23.98", "use \"24000/1001\"");
  expect_advice("29.97", "use \"30000/1001\"");
  expect_advice("47.952", "use \"48000/1001\"");
  expect_advice("59.94", "use \"60000/1001\"");
  expect_advice("119.88", "use \"120000/1001\"");
  expect_advice("24.0", "use 24");
  expect_advice("12.5", "use \"25/2\"");
  expect_advice("0.1", "use \"1/10\"");
  expect_advice("3.14159265", "use a fraction such as");
}

// ---- tracks and keys

TEST(MoveFile, ATrackWithoutKeysIsRefused) {
  expect_move_refused("name=\"a\"\nfps=24\nframes=2\n@[[track]]\naxes=[\"x\"]\nspeed=[1]",
                      {"a track has no keys; add keys = "});
  expect_move_refused("name=\"a\"\nfps=24\nframes=2\n[[track]]\naxes=[\"x\"]\nspeed=[1]\nkeys=@[]",
                      {"keys is empty; write at least one"});
}

TEST(MoveFile, KeysOfUnequalLengthNameTheKey) {
  expect_change_refused("[900, 80.0]", "@[900]",
                        {"key 1 has 1 number; write 2, one for each of its axes (track, lift)"});
  expect_change_refused("[1500.0, -1e-3]", "@[1, 2, 3]", {"key 2 has 3 numbers; write 2"});
  expect_change_refused("[900, 80.0]", "@[]", {"at is empty"});
}

TEST(MoveFile, ATrackNeedsAxes) {
  expect_change_refused("[\"track\", \"lift\"]", "@[]", {"axes is empty; write at least one"});
  expect_change_refused("\"lift\"", "@\"\"", {"axes[1] is empty"});
}

TEST(MoveFile, AnAxisIsInATrackOnce) {
  expect_change_refused("\"lift\"", "@\"track\"",
                        {"axes[1] is \"track\", which line 6 has already", "name each axis once"});
}

TEST(MoveFile, AnAxisIsInOneTrackOnly) {
  expect_move_refused(with(locked, "\"pan\"", "@\"tilt\""),
                      {"axes[0] is \"tilt\", which line 5 has already", "name each axis once in one track"});
}

TEST(MoveFile, TensionContinuityAndBiasAreWithinOne) {
  expect_move_refused(with(locked, "tension = 1", "tension = @1.001"),
                      {"tension is 1.001; write a number from -1 to 1"});
  expect_move_refused(with(locked, "continuity = -1", "continuity = @-2"), {"continuity is -2"});
  expect_move_refused(with(locked, "bias = 0.25", "bias = @nan"), {"bias is nan"});
}

TEST(MoveFile, TensionContinuityAndBiasBelongToTcb) {
  for (const char* field : {"tension", "continuity", "bias"}) {
    expect_change_refused("{ at = [0.0, 0.0] }", fmt::format("{{ at = [0.0, 0.0], {} = @0 }}", field),
                          {field, "only with spline = \"tcb\""});
  }
}

TEST(MoveFile, AFrameIsWithinTheMove) {
  expect_change_refused("= 150", "= @241", {"frame is 241; write a whole number from 0 to 240"});
  expect_change_refused("= 150", "= @-1", {"frame is -1"});
  expect_change_refused("= 150", "= @1.5", {"frame is a number with a fraction"});
  EXPECT_EQ(parse_move(with(reveal, "= 150", "= 240"), "m").tracks.at(0).keys.at(1).frame, 240);
}

TEST(MoveFile, AHoldLastsFromOneFrameToTheWholeMove) {
  expect_change_refused("frame = 150", "frame = 150, hold = @0",
                        {"hold is 0; write a whole number from 1 to 240"});
  expect_change_refused("frame = 150", "hold = @241", {"hold is 241"});
}

TEST(MoveFile, ABreakNeedsAFrame) {
  expect_change_refused("frame = 150", "break = @true", {"break needs the frame at which the key is met"});
  expect_change_refused("frame = 150", "frame = 150, break = @1",
                        {"break is a whole number; write true or false"});
}

TEST(MoveFile, KineticNeedsTimingByFrames) {
  expect_change_refused("keys = [", "kinetic = @\"linear\"\nkeys = [", {"kinetic needs timing = \"frames\""});
}

TEST(MoveFile, WhatKineticSmoothWasIsCalledMonotone) {
  expect_move_refused(with(locked, "\"monotone\"", "@\"smooth\""),
                      {"kinetic is \"smooth\"", "called \"monotone\"", "\"curves\""});
}

TEST(MoveFile, EaseRestCornersAndOvershootAreRefusedWhereTheyMeanNothing) {
  expect_change_refused("frame = 150", "frame = 150, hold = 3, ease = @true", {"ease is what a hold does"});
  expect_change_refused("frame = 150", "frame = 150, break = true, ease = @true", {"ease contradicts break"});
  expect_change_refused("keys = [", "spline = \"linear\"\novershoot = @false\nkeys = [",
                        {"overshoot has a meaning with spline = \"smooth\""});
}

// ---- speed and weights

TEST(MoveFile, SpeedIsMissing) {
  expect_move_refused(with(with(reveal, "speed = [0, 0, 10, 4.5, 0, 0]\n", ""), "[[track]]", "@[[track]]"),
                      {"a track has no speed; add speed = "});
  expect_change_refused("[0, 0, 10, 4.5, 0, 0]", "@[]", {"speed is empty"});
}

TEST(MoveFile, SpeedHasNoMeaningWithTimingByFrames) {
  expect_change_refused("speed = ", "timing = \"frames\"\nspeed = @",
                        {"speed has no meaning with timing = \"frames\""});
}

TEST(MoveFile, ControlValuesAreFromZeroToAHundred) {
  expect_change_refused("4.5", "@-0.001", {"speed[3] is -0.001; write a number from 0 to 100"});
  expect_change_refused("4.5", "@100.5", {"speed[3] is 100.5; write a number from 0 to 100"});
}

TEST(MoveFile, ACurveHasAtMost2048ControlValues) {
  std::string values = "1";
  for (int i = 1; i < 2048; ++i) values += ",1";
  EXPECT_EQ(
      parse_move(with(reveal, "[0, 0, 10, 4.5, 0, 0]", "[" + values + "]"), "m").tracks.at(0).speed.size(),
      2048U);
  expect_change_refused("[0, 0, 10, 4.5, 0, 0]", "@[" + values + ",1]",
                        {"speed has 2049 elements; write at most 2048"});
}

TEST(MoveFile, WeightsAreOnePerAxisAndNotNegative) {
  expect_change_refused("[1.0, 0.5]", "@[1.0]", {"weights has 1 number; write 2", "(track, lift)"});
  expect_change_refused("[1.0, 0.5]", "@[1, 2, 3]", {"weights has 3 numbers; write 2"});
  expect_change_refused("0.5]", "@-0.5]", {"weights[1] is -0.5; write a number from 0"});
  expect_change_refused("[1.0, 0.5]", "@[0, 0.0]", {"weights are all 0"});
}

// ---- capacity

TEST(MoveFile, ATrackHasAtMost64Axes) {
  std::string axes;
  for (int i = 0; i < 65; ++i) axes += fmt::format("\"a{}\",", i);
  expect_change_refused("[\"track\", \"lift\"]", "@[" + axes + "]",
                        {"axes has 65 elements; write at most 64"});
}

TEST(MoveFile, ATrackHasAtMost10000Keys) {
  std::string keys;
  for (int i = 0; i < 10'000; ++i) keys += "{at=[1]},";
  const std::string head = "name=\"a\"\nfps=24\nframes=2\n[[track]]\naxes=[\"x\"]\nspeed=[1]\nkeys=@[";
  EXPECT_EQ(parse_move(with(head, "@", "") + keys + "]", "m").tracks.at(0).keys.size(), 10'000U);
  expect_move_refused(head + keys + "{at=[1]}]", {"keys has 10001 elements; write at most 10000"});
}

TEST(MoveFile, AMoveHasAtMost64Tracks) {
  std::string tracks = "name=\"a\"\nfps=24\nframes=2\n@";
  for (int i = 0; i < 65; ++i)
    tracks += fmt::format("[[track]]\naxes=[\"a{}\"]\nspeed=[1]\nkeys=[{{at=[1]}}]\n", i);
  expect_move_refused(tracks, {"track has 65 elements; write at most 64"});
}

}  // namespace move_file_test
}  // namespace inbetween
