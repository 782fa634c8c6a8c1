// Tables of comma-separated values, and records of runs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "host_tools/exchange/record_table.hpp"
#include "host_tools/exchange/table_csv.hpp"
#include "tests/support/refused_text.hpp"

namespace inbetween {
namespace exchange_csv_test {

using testing::ElementsAre;
using testing::HasSubstr;

BakedTable read(const std::string& text, const std::string& file = "file.toml") {
  return read_table_csv(text, file);
}

std::string refusal(const std::string& text, const CsvReading& reading = {}) {
  try {
    read_table_csv(text, "a.csv", reading);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

const char* const pan_track = "frame,PAN [deg],TRACK [mm]\n1,0.0000,0.0000\n2,0.5000,10.0000\n";

TEST(ExchangeCsv, TheFirstRowNamesAxesAndUnits) {
  const BakedTable table = read(pan_track);
  EXPECT_EQ(table.first_frame, 1);
  ASSERT_EQ(table.columns.size(), 2U);
  EXPECT_EQ(table.columns[0].name, "PAN");
  EXPECT_EQ(table.columns[0].unit, MoveUnit::deg);
  EXPECT_EQ(table.columns[1].unit, MoveUnit::mm);
  EXPECT_THAT(table.columns[1].values, ElementsAre(0, 10));
  EXPECT_EQ(table.columns[1].decimals, 4);
  EXPECT_FALSE(table.fps);
  EXPECT_EQ(write_table_csv(table, {4}), pan_track);
}

TEST(ExchangeCsv, SemicolonsTabsQuotesAndNoNamesAreRead) {
  const BakedTable quoted = read("Frame;\"pan; left\";tilt (arm)\n-1;2;3\n0;4;5\n");
  EXPECT_EQ(quoted.columns[0].name, "pan; left");
  EXPECT_EQ(quoted.columns[1].name, "tilt (arm)") << "arm is no unit";
  EXPECT_EQ(quoted.first_frame, -1);
  EXPECT_THAT(read("a\tb\r\n1\t2\r\n3\t4\r\n").columns[1].values, ElementsAre(2, 4));
  const BakedTable bare = read("1.5,2\n3,4\n");
  EXPECT_FALSE(bare.has_names || bare.first_frame);
  EXPECT_EQ(bare.columns[1].name, "column 2");
  EXPECT_THAT(bare.columns[0].values, ElementsAre(1.5, 3));
}

TEST(ExchangeCsv, WhatPlanWritesIsReadAndItsSecondsHoldTheRateToIt) {
  const BakedTable table = read(
      "frame,time_s,slide (mm),pan (deg)\n0,0,60,-62\n1,0.041666666666666664,60.00002528696654,-61.9\n"
      "2,0.08333333333333333,61,-61\n");
  ASSERT_EQ(table.columns.size(), 2U);
  EXPECT_EQ(table.columns[0].name, "slide");
  EXPECT_EQ(table.columns[0].unit, MoveUnit::mm);
  EXPECT_NO_THROW(check_seconds(table, {24, 1}));
  EXPECT_THROW(check_seconds(table, {25, 1}), InputError);
}

TEST(ExchangeCsv, OtherNamesAndDecimalCommasAreStated) {
  const CsvReading german{.has_decimal_commas = true, .frame_column = "Bild", .seconds_column = "Zeit"};
  const BakedTable table =
      read_table_csv("Bild;Zeit;Schwenk [deg]\n1;0,000;0,5\n2;0,040;1,25\n3;0,080;2\n", "a.csv", german);
  EXPECT_THAT(table.columns[0].values, ElementsAre(0.5, 1.25, 2));
  EXPECT_NO_THROW(check_seconds(table, {25, 1}));
  EXPECT_THROW(check_seconds(table, {24, 1}), InputError);
  EXPECT_THAT(refusal("Bild;x\n1;1.5\n2;2\n", german), HasSubstr("a.csv:2:3: error: \"1.5\" has a point"));
}

TEST(ExchangeCsv, GapsAreFilledWhereSomebodyAsksForIt) {
  EXPECT_THAT(refusal("frame,x\n1,0\n4,9\n"), HasSubstr("a.csv:3:1: error: frame 4 follows frame 1"));
  const BakedTable table = read_table_csv("frame,x\n1,0\n4,9\n5,3\n", "a.csv", {.fills_gaps = true});
  EXPECT_THAT(table.columns[0].values, ElementsAre(0, 3, 6, 9, 3));
  EXPECT_THAT(table.lines, ElementsAre(2, 3, 3, 3, 4));
  ASSERT_EQ(table.warnings.size(), 1U);
  EXPECT_THAT(table.warnings[0].message, HasSubstr("2 frames before frame 4 were missing"));
  EXPECT_THAT(refusal("frame,x\n1,0\n9000000,9\n", {.fills_gaps = true}),
              HasSubstr("more than 1000001 rows"));
  EXPECT_THAT(refusal("frame,x\n4,0\n1,9\n", {.fills_gaps = true}), HasSubstr("frame 1 follows frame 4"));
}

TEST(ExchangeCsv, AWrongFileIsRefusedAtItsPlace) {
  expect_refused(read, "frame,x\n1,0\n2,@nan\n", {"no position"});
  expect_refused(read, "frame,x\n1,0\n2,@\n", {"no number"});
  expect_refused(read, "frame;x\n1;@0,5\n", {"comma", "state that"});
  expect_refused(read, "frame,x,y\n1,\"2\",0\n2, @ä,0\n", {"no number"});
  expect_refused(read, "frame,ä,y\n1,2,0\n2,3,@0x1\n", {"no number"});
}

TEST(ExchangeCsv, AWrongShapeIsRefusedAtItsLine) {
  EXPECT_THAT(refusal("frame,x\n1,0,5\n2,1,5\n"), HasSubstr("a.csv:2: error: the row has 3 fields"));
  EXPECT_THAT(refusal("frame,x\n1\n"), HasSubstr("a.csv:2: error: the row has 1 field"));
  EXPECT_THAT(refusal("frame,x\n1,0\n"), HasSubstr("1 row"));
  EXPECT_THAT(refusal("frame\n1\n2\n"), HasSubstr("no column of positions"));
  EXPECT_THAT(refusal(""), HasSubstr("is empty"));
  EXPECT_THAT(refusal("frame,x,x\n1,0,0\n2,0,0\n"), HasSubstr("both called"));
  EXPECT_THAT(refusal("frame,x,frame\n1,0,1\n"), HasSubstr("a.csv:1:9: error: column 1 says already"));
  EXPECT_THAT(refusal("frame,,x\n1,0,1\n"), HasSubstr("a.csv:1:7: error: column 2 has no name"));
  EXPECT_THAT(refusal("frame,x [furlong]\n1,0\n"), HasSubstr("a.csv:1:7: error: \"furlong\" is no unit"));
  EXPECT_THAT(refusal("frame,[deg]\n1,0\n"), HasSubstr("a.csv:1:7: error: \"[deg]\" is a unit and no name"));
  EXPECT_THAT(refusal("0.5,nan,x\n1,2,3\n"), HasSubstr("names and numbers"));
  EXPECT_THAT(refusal("1;0,5\n2;0,7\n"), HasSubstr("more than one of comma, semicolon and tab"));
  EXPECT_THAT(refusal("frame,\"x\n1,0\n"), HasSubstr("quote is not closed"));
  EXPECT_THAT(refusal("frame,x\n1.5,0\n"), HasSubstr("a.csv:2:1: error: \"1.5\" is no whole number"));
}

TEST(ExchangeCsv, RowsOfTwoRatesAreRefusedWhereTheRateChanges) {
  EXPECT_THAT(refusal("seconds,x\n0.00,0\n0.04,1\n0.08,2\n0.12,3\n0.1617,4\n0.2033,5\n"),
              HasSubstr("a.csv:6: error: the row is 0.0417 s behind the row before"));
  EXPECT_THAT(refusal("seconds,x\n0,0\n0.04,1\n0.04,2\n"),
              HasSubstr("a.csv:4: error: 0.04 s are not behind"));
  EXPECT_EQ(refusal("seconds,x\n0,0\n0.042,1\n0.083,2\n0.125,3\n0.167,4\n"), "accepted") << "rounded to 1 ms";
}

TEST(ExchangeCsv, ANameThatWouldBeReadAsSomethingElseIsNotWritten) {
  for (const char* const name : {"frame", "Tick", "seconds", "pan [deg]", "pan (mm)", " pan", ""}) {
    BakedTable table = read(pan_track);
    table.columns[0].name = name;
    EXPECT_THROW(write_table_csv(table), InputError) << name;
  }
}

const std::string record =
    "tick,seconds,state,frame,pan,pan actual,\"a, b\",\"a, b actual\"\n"
    "0,0.000000,disarmed,,,1.0,,2.0\n"
    "1,0.004000,moving,-0.5,1.5,1.0,2.5,2.0\n"
    "2,0.008000,moving,-0.4,1.75,1.5,2.75,2.5\n"
    "3,0.012000,moving,-0.3,2,1.75,3,2.75\n"
    "4,0.016000,holding,,2,2,3,3\n";

BakedTable read_record(const std::string& text, const std::string& file = "file.toml") {
  return read_record_table(text, file);
}

TEST(ExchangeRecord, ARecordIsWhatWasPlayedAtTheRateOfItsRig) {
  const BakedTable told = read_record(record);
  EXPECT_EQ(told.fps, (FrameRate{250, 1})) << "the only whole number that all seconds agree with";
  ASSERT_EQ(told.columns.size(), 2U);
  EXPECT_EQ(told.columns[1].name, "a, b");
  EXPECT_THAT(told.columns[0].values, ElementsAre(1.5, 1.75, 2));
  EXPECT_THAT(told.lines, ElementsAre(3, 4, 5));
  EXPECT_FALSE(told.has_exposures);
  const BakedTable actual = read_record_table(record, "r.csv", RecordedPositions::actual);
  EXPECT_THAT(actual.columns[0].values, ElementsAre(1, 1.5, 1.75));
}

TEST(ExchangeRecord, ADamagedRecordIsRefusedAtItsLine) {
  const auto refused = [](const std::string& text) {
    try {
      read_record(text, "r.csv");
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refused(with(record, "2,0.008000,moving,-0.4,1.75,1.5,2.75,2.5\n", "")),
              HasSubstr("r.csv:4: error: tick 3 follows tick 1"));
  EXPECT_THAT(refused(with(record, "0.012000", "0.013000")), HasSubstr("r.csv:5: error: tick 3 at 0.013 s"));
  EXPECT_THAT(refused(with(record, "-0.4,1.75", "-0.4,")),
              HasSubstr("r.csv:4:24: error: \"pan\" has no setpoint"));
  EXPECT_THAT(refused(with(record, "-0.4,1.75", "-0.4,nan")), HasSubstr("r.csv:4:24"));
  EXPECT_THAT(refused(with(record, ",2.75,2.5\n", "\n")), HasSubstr("r.csv:4: error: the row has 6 fields"));
  EXPECT_THAT(refused(with(record, "pan actual", "pan told")), HasSubstr("no record of inbetween run"));
  EXPECT_THAT(refused(record + "5,0.020000,moving,1,2,2,3,3\n"),
              HasSubstr("r.csv:7: error: a second motion"));
  EXPECT_THAT(refused(record.substr(0, record.find("1,0.004"))), HasSubstr("no move was played"));
  EXPECT_THAT(refused(""), HasSubstr("is empty"));
}

}  // namespace exchange_csv_test
}  // namespace inbetween
