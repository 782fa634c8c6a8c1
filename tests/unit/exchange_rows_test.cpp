// Formats that are rows of numbers: Raw Move, Maya .mov, Nuke .chan, Kuper ASCII, Flair CARTS_RAW.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <locale>
#include <string>

#include "host_tools/exchange/flair_carts.hpp"
#include "host_tools/exchange/kuper_ascii.hpp"
#include "host_tools/exchange/maya_mov.hpp"
#include "host_tools/exchange/nuke_chan.hpp"
#include "host_tools/exchange/raw_move.hpp"
#include "tests/support/refused_text.hpp"

namespace inbetween {
namespace exchange_rows_test {

using testing::ElementsAre;
using testing::HasSubstr;

/// Expects a refusal of a whole line, or of the file where `line` is 0.
template <class Read>
void expect_refused_line(Read read, const std::string& text, std::uint32_t line, const std::string& words) {
  try {
    read(text, "file.toml");
    ADD_FAILURE() << "accepted:\n" << text;
  } catch (const InputError& error) {
    EXPECT_EQ(error.place().line, line) << error.what();
    EXPECT_THAT(error.what(), HasSubstr(words));
    EXPECT_THAT(error.what(), HasSubstr(";")) << "no remedy";
  }
}

const char* const raw =
    "0.000000        -5.000000       \n1.250000        -4.500000       \n2.500000        -4.000000       \n";

TEST(ExchangeRows, ARawMoveHasAColumnForEachAxisAndNoNames) {
  const BakedTable table = read_raw_move(raw, "a.txt");
  ASSERT_EQ(table.columns.size(), 2U);
  EXPECT_THAT(table.columns[0].values, ElementsAre(0, 1.25, 2.5));
  EXPECT_THAT(table.columns[1].values, ElementsAre(-5, -4.5, -4));
  EXPECT_EQ(table.columns[0].name, "column 1");
  EXPECT_EQ(table.columns[0].decimals, 6);
  EXPECT_THAT(table.lines, ElementsAre(1, 2, 3));
  EXPECT_FALSE(table.has_names);
  EXPECT_FALSE(table.fps || table.first_frame || table.phase);
  EXPECT_EQ(write_raw_move(table), raw) << "BlenderMoco's own layout";
}

TEST(ExchangeRows, ANumberIsNeverCutSoThatItsExponentIsLost) {
  BakedTable table = read_raw_move(raw, "a.txt");
  table.columns[0].values = {1.2345678901e-05, -123456789.25, 1e15};
  const BakedTable back = read_raw_move(write_raw_move(table), "a.txt");
  EXPECT_THAT(back.columns[0].values, ElementsAre(1.2e-05, -123456789.25, 1e15));
}

TEST(ExchangeRows, LineEndsAndAMarkOfBytesAreThoseOfAnySystem) {
  for (const std::string end : {"\n", "\r\n", "\r"}) {
    const std::string text = "\xEF\xBB\xBF" + ("1 +2" + end) + "3\t4e0  " + end + "  " + end + end;
    const BakedTable table = read_raw_move(text, "a.txt");
    EXPECT_THAT(table.columns[0].values, ElementsAre(1, 3));
    EXPECT_THAT(table.columns[1].values, ElementsAre(2, 4));
    EXPECT_EQ(table.columns[1].decimals, std::nullopt) << "an exponent says nothing of digits";
  }
}

TEST(ExchangeRows, AWrongRowIsRefusedAtItsPlace) {
  expect_refused(read_raw_move, "1 2\n3 @nan\n", {"no position"});
  expect_refused(read_raw_move, "1 2\n3 @-Inf\n", {"no position"});
  expect_refused(read_raw_move, "1 2\n@3,5 4\n", {"comma", "12.5"});
  expect_refused(read_raw_move, "1 2\n3 @1e200\n", {"no number from"});
  expect_refused(read_raw_move, "1 2\n3 @0x10\n", {"no number"});
  expect_refused(read_raw_move, "1 2\n3 @4;\n", {"no number"});
  expect_refused_line(read_raw_move, "1 2\n3\n", 2, "has 1 number, and the table has 2 columns");
  expect_refused_line(read_raw_move, "1 2\n3 4 5\n", 2, "has 3 numbers");
  expect_refused_line(read_raw_move, "1 2\n\n3 4\n", 2, "is empty");
  expect_refused_line(read_raw_move, "1 2\n", 0, "1 row");
  expect_refused_line(read_raw_move, "", 0, "no column");
  expect_refused_line(read_raw_move, std::string("1 2\n3 4\0\n", 9), 0, "UTF-8");
}

/// Numbers with a decimal comma, as a German desktop has them.
struct Comma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
};

TEST(ExchangeRows, NoLocaleChangesWhatIsReadAndWritten) {
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  const BakedTable table = read_raw_move(raw, "a.txt");
  const std::string text = write_raw_move(table);
  std::locale::global(before);
  EXPECT_EQ(table.columns[0].values[1], 1.25);
  EXPECT_EQ(text, raw);
}

TEST(ExchangeRows, AChannelMoveOfMayaMayBeginWithComments) {
  const char* const rows = "0.000000 0.000000\n1.000000 15.000000\n2.000000 30.000000\n";
  const BakedTable table = read_maya_mov(std::string("# tx\n# ry\n") + rows, "a.mov");
  EXPECT_THAT(table.columns[1].values, ElementsAre(0, 15, 30));
  EXPECT_THAT(table.lines, ElementsAre(3, 4, 5));
  EXPECT_EQ(write_maya_mov(table), std::string("# column 1\n# column 2\n") + rows);
}

TEST(ExchangeRows, AFilmIsNoChannelMove) {
  for (const std::string kind : {"ftyp", "moov", "mdat", "wide"}) {
    expect_refused_line(read_maya_mov, std::string("\0\0\0\x14", 4) + kind + "qt  ", 0, "film");
  }
}

TEST(ExchangeRows, AChanFileHasFramesAndACameraInSpace) {
  const BakedTable table = read_nuke_chan(
      "# a camera\n1\t0.0\t1.5\t-3\t0\t90\t0\t36.5\t\n2\t0.1\t1.5\t-3\t0\t91.25\t0\t36.5\n", "a.chan");
  EXPECT_EQ(table.first_frame, 1);
  ASSERT_EQ(table.columns.size(), 7U);
  EXPECT_EQ(table.columns[0].name, "tx");
  EXPECT_FALSE(table.columns[0].unit);
  EXPECT_EQ(table.columns[4].unit, MoveUnit::deg);
  EXPECT_THAT(table.columns[4].values, ElementsAre(90, 91.25));
  EXPECT_EQ(table.columns[6].name, "vfov");
  EXPECT_TRUE(table.is_in_space && table.has_euler_angles);
  EXPECT_FALSE(table.up);
  EXPECT_THAT(write_nuke_chan(table, {2}),
              "1\t0.00\t1.50\t-3.00\t0.00\t90.00\t0.00\t36.50\n"
              "2\t0.10\t1.50\t-3.00\t0.00\t91.25\t0.00\t36.50\n");
}

TEST(ExchangeRows, AWrongChanFileIsRefused) {
  expect_refused(read_nuke_chan, "1 0 0 0 0 0 0\n@3 0 0 0 0 0 0\n", {"frame 3 follows frame 1"});
  expect_refused(read_nuke_chan, "1 0 0 0 0 0 0\n@1 0 0 0 0 0 0\n", {"frame 1 follows frame 1"});
  expect_refused(read_nuke_chan, "@1.5 0 0 0 0 0 0\n", {"no whole number"});
  expect_refused(read_nuke_chan, "1 0 0 0 0 0 0\n2 0 0 @NaN 0 0 0\n", {"no position"});
  expect_refused_line(read_nuke_chan, "1 0 0 0 0 0\n", 1, "tx ty tz");
  expect_refused_line(read_nuke_chan, "1 0 0 0 0 0 0\n2 0 0 0 0 0 0 36\n", 2, "has 7 numbers");
  BakedTable table = read_nuke_chan("1 0 0 0 0 0 0\n2 0 0 0 0 0 0\n", "a.chan");
  table.columns.pop_back();
  EXPECT_THROW(write_nuke_chan(table), InputError);
}

const char* const kuper =
    "Axes = vTrack, vPan\r\n    0.0000     0.0000\r\n   -1.0000     0.5000\r\n   -2.0000     1.0000\r\n";

TEST(ExchangeRows, AKuperFileNamesItsAxes) {
  const BakedTable table = read_kuper_ascii(
      "Axes = vTrack, vPan\r\n    0.0000    0.0000\r\n   -1.0000    0.5000\r\n   -2.0000    1.0000\r\n",
      "a.txt");
  ASSERT_EQ(table.columns.size(), 2U);
  EXPECT_EQ(table.columns[0].name, "vTrack");
  EXPECT_THAT(table.columns[0].values, ElementsAre(0, -1, -2));
  EXPECT_EQ(write_kuper_ascii(table), kuper);
  const BakedTable commas = read_kuper_ascii("AXES=East West , Pan\n1, 2\n3,4\n", "a.txt");
  EXPECT_EQ(commas.columns[0].name, "East West");
  EXPECT_THAT(commas.columns[1].values, ElementsAre(2, 4));
}

TEST(ExchangeRows, AWrongKuperFileIsRefused) {
  expect_refused(read_kuper_ascii, "@Pan, Tilt\n1 2\n3 4\n", {"Axes = vTrack, vPan"});
  expect_refused_line(read_kuper_ascii, "", 0, "is empty");
  expect_refused_line(read_kuper_ascii, "Axes = Pan, , Tilt\n1 2 3\n", 1, "axis 2 has no name");
  expect_refused_line(read_kuper_ascii, "Axes = Pan, Pan\n1 2\n3 4\n", 0, "both called");
  expect_refused_line(read_kuper_ascii, "Axes = Pan\n1,5\n2,5\n", 2, "decimal with a point");
  expect_refused_line(read_kuper_ascii, "Axes = Pan, Tilt\n1 2\n3\n", 3, "has 1 number");
  expect_refused(read_kuper_ascii, "Axes = Pan, Tilt\n1 2\n3 @nan\n", {"no position"});
  BakedTable table = read_kuper_ascii(kuper, "a.txt");
  table.columns[0].name = "left, right";
  EXPECT_THROW(write_kuper_ascii(table), InputError);
}

const char* const flair =
    "# test move\n"
    "DATA_TYPE  CARTS_RAW  MRMC_COORDS  IN_CENTIMETRES\n"
    "POINTS 2  SPEED 25\n"
    "FRAME     XV         YV         ZV         XT         YT         ZT         ROLL\n"
    "   1  100.00000    0.00000  150.00000  400.00000    0.00000  150.00000    0.00000\n"
    "   2  101.00000    0.00000  150.00000  400.00000    0.00000  150.00000    0.00000";

TEST(ExchangeRows, FlairSaysRateUnitsAndWhatIsUp) {
  const BakedTable table = read_flair_carts(flair, "a.txt");
  EXPECT_EQ(table.fps, (FrameRate{25, 1}));
  EXPECT_EQ(table.first_frame, 1);
  EXPECT_EQ(table.up, UpAxis::z);
  ASSERT_EQ(table.columns.size(), 7U);
  EXPECT_THAT(table.columns[0].values, ElementsAre(100, 101));
  EXPECT_EQ(table.columns[0].unit, MoveUnit::cm);
  EXPECT_EQ(table.columns[6].unit, MoveUnit::deg);
  const BakedTable back = read_flair_carts(write_flair_carts(table), "a.txt");
  EXPECT_EQ(back.fps, table.fps);
  EXPECT_THAT(back.columns[3].values, ElementsAre(400, 400));
}

TEST(ExchangeRows, FlairsColumnsGoByTheirHeadingsAndJunkMayFollow) {
  const BakedTable table = read_flair_carts(
      "data_type carts_raw mrmc_coords in_metres\npoints 2 speed 29.97\n"
      "roll frame xv yv zv xt yt zt focus\n"
      "7, 1, 1, 2, 3, 4, 5, 6, 900\n# between\n8 2 1 2 3 4 5 6 901\njunk of the writer\n",
      "a.txt");
  EXPECT_THAT(table.columns[0].values, ElementsAre(7, 8));
  EXPECT_EQ(table.columns[0].name, "ROLL");
  EXPECT_EQ(table.columns[1].unit, MoveUnit::m);
  EXPECT_EQ(table.columns[7].name, "focus");
  EXPECT_FALSE(table.fps) << "29.97 is not exact";
  EXPECT_EQ(table.about_fps, 29.97);
  ASSERT_EQ(table.warnings.size(), 1U);
  EXPECT_EQ(table.warnings[0].place.line, 7U);
}

TEST(ExchangeRows, AWrongFlairFileIsRefused) {
  const std::string text = flair;
  expect_refused_line(read_flair_carts, with(text, "POINTS 2", "POINTS 3"), 0,
                      "has 2 rows, and POINTS says 3");
  expect_refused_line(read_flair_carts, with(text, "POINTS 2", "POINTS 1"), 3, "whole number from 2");
  expect_refused_line(read_flair_carts, with(text, "SPEED 25", "SPEED 0"), 3, "above 0");
  expect_refused_line(read_flair_carts, with(text, "IN_CENTIMETRES", "IN_INCHES"), 2, "IN_METRES");
  expect_refused_line(read_flair_carts, with(text, "CARTS_RAW", "AXES"), 2, "DATA_TYPE");
  expect_refused_line(read_flair_carts, with(text, "         ROLL", ""), 4, "ROLL is missing");
  expect_refused_line(read_flair_carts, with(text, "FRAME     XV", "XV"), 4, "FRAME is missing");
  expect_refused_line(read_flair_carts, with(text, "101.00000", "101,5"), 6, "comma");
  expect_refused_line(read_flair_carts, with(text, "101.00000", "nan"), 6, "no position");
  expect_refused_line(read_flair_carts, with(text, "101.00000", ""), 6, "has 7 numbers");
  expect_refused_line(read_flair_carts, with(text, "   2  101", "   3  101"), 6, "frame 3 follows frame 1");
  expect_refused_line(read_flair_carts, "", 0, "ends here");
}

TEST(ExchangeRows, FlairIsNotWrittenWithoutWhatItSays) {
  const BakedTable table = read_flair_carts(flair, "a.txt");
  BakedTable wrong = table;
  wrong.fps.reset();
  EXPECT_THROW(write_flair_carts(wrong), InputError);
  wrong = table;
  wrong.columns[2].unit = MoveUnit::m;
  EXPECT_THROW(write_flair_carts(wrong), InputError);
  wrong = table;
  wrong.up = UpAxis::y;
  EXPECT_THROW(write_flair_carts(wrong), InputError);
  wrong = table;
  wrong.columns[0].values[0] = -1234567.5;  // wider than its column
  const BakedTable back = read_flair_carts(write_flair_carts(wrong), "a.txt");
  EXPECT_EQ(back.columns[0].values[0], -1234567.5);
}

}  // namespace exchange_rows_test
}  // namespace inbetween
