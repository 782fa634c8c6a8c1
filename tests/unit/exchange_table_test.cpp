// What a baked motion does not say is asked; which format a file has; a plan as such a motion.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "host_tools/exchange/exchange_format.hpp"
#include "host_tools/exchange/plan_table.hpp"
#include "host_tools/exchange/table_answers.hpp"
#include "host_tools/move_model/move_file.hpp"
#include "tests/support/refused_text.hpp"

namespace inbetween {
namespace exchange_table_test {

using testing::ElementsAre;
using testing::HasSubstr;

template <class Act>
std::string refusal(Act act) {
  try {
    act();
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

std::vector<TableAsks> asked(const BakedTable& table) {
  std::vector<TableAsks> asks;
  for (const TableQuestion& question : questions_of(table)) asks.push_back(question.asks);
  return asks;
}

BakedTable read(const std::string& text, const std::string& file) {
  return read_baked_table(exchange_format_of(file, text), text, file);
}

const char* const chan = "1 0 0 0 0 0 0\n2 1 0 0 0 0 0\n";
const char* const servos =
    R"({"fps":29.97,"frames":2,"servos":{"0":{"name":"Pan","positions":[1500,1600]}}})";

TEST(ExchangeTable, WhatAFileDoesNotSayIsAsked) {
  using enum TableAsks;
  EXPECT_THAT(asked(read("1 2\n3 4\n", "a.txt")), ElementsAre(fps, names, unit, unit, phase));
  EXPECT_THAT(asked(read(chan, "a.chan")),
              ElementsAre(fps, unit, unit, unit, up_axis, rotation_order, phase));
  EXPECT_THAT(asked(read(servos, "a.json")), ElementsAre(fps, count, phase));
  EXPECT_THAT(questions_of(read(servos, "a.json"))[0].words, HasSubstr("about 29.97"));
  EXPECT_THAT(asked(read("frame,x [mm]\n1,0\n2,1\n", "a.csv")), ElementsAre(fps, phase));
}

TEST(ExchangeTable, ATableIsCompleteWhenAllIsAnswered) {
  const BakedTable table = answered_table(
      read(servos, "a.json"),
      {.fps = FrameRate{30000, 1001},
       .columns = {{.column = "Pan", .axis = "pan", .unit = MoveUnit::deg, .count = -0.1, .zero = 1500}},
       .phase = ShutterPhase::exposure_centre});
  EXPECT_THAT(asked(table), ElementsAre());
  EXPECT_EQ(table.columns[0].name, "pan");
  EXPECT_EQ(table.columns[0].unit, MoveUnit::deg);
  EXPECT_THAT(table.columns[0].values, ElementsAre(0, -10));
  const BakedTable camera =
      answered_table(read(chan, "a.chan"), {.fps = FrameRate{24, 1},
                                            .columns = {{.column = "tx", .axis = "x", .unit = MoveUnit::m}},
                                            .up = UpAxis::y,
                                            .rotation_order = "ZXY",
                                            .phase = ShutterPhase::frame_boundary});
  const BakedTable turned = answered_table(read("frame,z [m]\n1,0\n2,1.5\n", "a.csv"),
                                           {.fps = FrameRate{24, 1},
                                            .columns = {{.column = "z", .axis = "y", .is_reversed = true}},
                                            .phase = ShutterPhase::frame_boundary});
  EXPECT_THAT(turned.columns[0].values, ElementsAre(0, -1.5));
  EXPECT_EQ(camera.rotation_order, "zxy");
  EXPECT_EQ(camera.warnings.size(), 5U) << "each column that is left out is told";
}

TEST(ExchangeTable, NothingIsGuessedAndNothingIsContradicted) {
  const BakedTable rows = read("1 2\n3 4\n", "a.txt");
  const ColumnAnswer first{.column = "column 1", .axis = "x", .unit = MoveUnit::mm};
  const auto answer = [&](const BakedTable& table, const TableAnswers& answers) {
    return refusal([&] { answered_table(table, answers); });
  };
  EXPECT_THAT(answer(rows, {.columns = {first}}),
              testing::AllOf(HasSubstr("how many rows"), HasSubstr("exposure")));
  EXPECT_THAT(answer(rows, {}), HasSubstr("which axis each column is"));
  EXPECT_THAT(answer(rows, {.columns = {{.column = "colum 1", .axis = "x"}}}),
              HasSubstr("did you mean \"column 1\"?"));
  EXPECT_THAT(answer(rows, {.columns = {first, first}}), HasSubstr("named twice"));
  EXPECT_THAT(answer(rows, {.columns = {first}, .up = UpAxis::z}), HasSubstr("has no meaning"));
  EXPECT_THAT(answer(rows, {.columns = {first}, .rotation_order = "XYZ"}),
              HasSubstr("no order of rotations"));
  EXPECT_THAT(answer(rows, {.columns = {{.column = "column 1", .axis = "x", .count = 2}}}),
              HasSubstr("no counts"));
  EXPECT_THAT(refusal([] {
                answered_table(read(servos, "a.json"),
                               {.columns = {{.column = "Pan", .axis = "p", .is_reversed = true}}});
              }),
              HasSubstr("with a minus"));
  const BakedTable units = read("frame,x [mm]\n1,0\n2,1\n", "a.csv");
  EXPECT_THAT(answer(units, {.columns = {{.column = "x", .axis = "x", .unit = MoveUnit::m}}}),
              HasSubstr("counts in mm, and m was given"));
}

TEST(ExchangeTable, TwoRatesAreOneTooMany) {
  const std::string flair =
      "DATA_TYPE CARTS_RAW MRMC_COORDS IN_METRES\nPOINTS 2 SPEED 25\nFRAME XV YV ZV XT YT ZT ROLL\n"
      "1 0 0 0 1 1 1 0\n2 0 0 0 1 1 1 0\n";
  const ColumnAnswer first{.column = "XV", .axis = "x"};
  const auto answer = [&](const BakedTable& table, const FrameRate& fps, const ColumnAnswer& column) {
    return refusal([&] {
      answered_table(table, {.fps = fps, .columns = {column}, .phase = ShutterPhase::frame_boundary});
    });
  };
  const BakedTable carts = read(flair, "a.txt");
  EXPECT_EQ(answer(carts, {25, 1}, first), "accepted");
  EXPECT_THAT(answer(carts, {24, 1}, first), HasSubstr("25 rows a second, and 24 were given"));
  const BakedTable about = read(with(flair, "25", "23.98"), "a.txt");
  EXPECT_EQ(answer(about, {24000, 1001}, first), "accepted");
  EXPECT_THAT(answer(about, {24, 1}, first), HasSubstr("about 23.98"));
  const BakedTable timed = read("seconds,x [mm]\n0.000,0\n0.040,1\n0.080,2\n", "a.csv");
  EXPECT_EQ(answer(timed, {25, 1}, {.column = "x", .axis = "x"}), "accepted");
  EXPECT_THAT(answer(timed, {24, 1}, {.column = "x", .axis = "x"}),
              HasSubstr("a.csv:3: error: the row is 0.04 s behind the first"));
}

TEST(ExchangeTable, AFormatIsTakenWhereExtensionAndContentAgree) {
  using enum ExchangeFormat;
  const auto format = [](const std::string& file, const std::string& text) {
    return exchange_format_of(file, text);
  };
  EXPECT_EQ(format("a.txt", "1.5 2\n3 4\n"), raw_move);
  EXPECT_EQ(format("a.MOV", "# tx\n1 2\n3 4\n"), maya_mov);
  EXPECT_EQ(format("a.chan", chan), nuke_chan);
  EXPECT_EQ(format("a.txt", "Axes = a\r\n1\r\n2\r\n"), kuper);
  EXPECT_EQ(format("a.kuper", "axes=a\n1\n2\n"), kuper);
  EXPECT_EQ(format("a", "# x\nDATA_TYPE CARTS_RAW\n"), flair);
  EXPECT_EQ(format("a.csv", "frame,x\n1,2\n"), csv);
  EXPECT_EQ(format("a.csv", "tick,seconds,state,frame,x,x actual\n"), record);
  EXPECT_EQ(format("a.json", servos), servo_json);
  EXPECT_EQ(format("a.txt", "1e3081 0 0 0 0 0 0\n2 0 0 0 0 0 0\n"), raw_move) << "found by the fuzzer";
  const std::string scene = "<s:scene xmlns:s=\"http://caliri.com/motion/scene\">";
  EXPECT_EQ(format("a.arcx", scene), arc_scene);
  EXPECT_EQ(format("a.arcm", scene + "<s:controlPoints/>"), arc_move);
}

TEST(ExchangeTable, AFormatThatIsNotSureIsAskedFor) {
  const auto refused = [](const std::string& file, const std::string& text) {
    return refusal([&] { exchange_format_of(file, text); });
  };
  EXPECT_THAT(refused("a.dat", "1 2\n3 4\n"), HasSubstr("may be maya-mov and raw-move; say which"));
  EXPECT_THAT(refused("a.txt", chan), HasSubstr("maya-mov, raw-move and nuke-chan")) << "renamed";
  EXPECT_THAT(refused("a.csv", servos),
              HasSubstr("by its extension it is csv and record, and what stands in it is "
                        "servo-json"));
  EXPECT_THAT(refused("a.xml", "<a/>"), HasSubstr("no scene"));
  EXPECT_THAT(refused("a.mov", std::string("\0\0\0\x14"
                                           "ftypqt  ",
                                           12)),
              HasSubstr("film"));
  EXPECT_THAT(refused("a.txt", " \n\n"), HasSubstr("is empty"));
  EXPECT_THAT(refusal([] { exchange_format_to_write("a.txt"); }),
              HasSubstr("raw-move, csv, kuper and flair"));
  EXPECT_THAT(refusal([] { exchange_format_to_write("a"); }), HasSubstr("raw-move"));
  EXPECT_EQ(exchange_format_to_write("a.arcm"), ExchangeFormat::arc_move);
  EXPECT_EQ(exchange_format_of_word("nuke-chan"), ExchangeFormat::nuke_chan);
  EXPECT_EQ(exchange_format_of_word("nuke"), std::nullopt);
}

Plan slide() {
  return {parse_move("name = \"slide\"\nfps = 24\nframes = 24\n[[track]]\naxes = [\"x\", \"y\"]\n"
                     "keys = [{ at = [0, 1] }, { at = [10, 5] }]\nspeed = [0, 0, 10, 0, 0]\n",
                     "slide.toml"),
          std::nullopt, PlanOptions{}};
}

double position_at(const Plan& plan, const FrameTime& time) {
  std::vector<double> positions(plan.motion().axis_count());
  plan.motion().positions(time, positions);
  return positions[0];
}

TEST(ExchangeTable, APlanIsATableOfWhatPlays) {
  const Plan plan = slide();
  const BakedTable table = table_of_plan(plan);
  ASSERT_EQ(table.columns.size(), 2U);
  ASSERT_EQ(table.rows(), 25U);
  EXPECT_EQ(table.fps, (FrameRate{24, 1}));
  EXPECT_EQ(table.first_frame, 0);
  EXPECT_EQ(table.columns[1].name, "y");
  EXPECT_NEAR(table.columns[0].values[0], 0, 1e-9);
  EXPECT_NEAR(table.columns[0].values[24], 10, 1e-9);
  for (std::int32_t frame = 0; frame <= 24; ++frame) {
    EXPECT_EQ(table.columns[0].values[static_cast<std::size_t>(frame)], position_at(plan, {frame, 0}));
  }
}

TEST(ExchangeTable, RowsOfAnotherRateAndTheMiddleOfTheExposureAreExact) {
  const Plan plan = slide();
  const BakedTable slow = table_of_plan(plan, {.fps = FrameRate{10, 1}});
  ASSERT_EQ(slow.rows(), 11U) << "1 s at 10 rows a second, both ends included";
  EXPECT_EQ(slow.columns[0].values[1], position_at(plan, {2, 0.4}));
  EXPECT_NEAR(slow.columns[0].values[10], 10, 1e-9);
  const BakedTable odd = table_of_plan(plan, {.fps = FrameRate{7, 2}});
  ASSERT_EQ(odd.rows(), 5U) << "rows at 0, 2/7, ... and the first at or after 1 s";
  const BakedTable centre = table_of_plan(plan, {.phase = ShutterPhase::exposure_centre});
  ASSERT_EQ(centre.rows(), 25U);
  EXPECT_EQ(centre.columns[0].values[3], position_at(plan, {3, 0.5}));
  EXPECT_NEAR(centre.columns[0].values[24], 10, 1e-9) << "it holds";
}

}  // namespace exchange_table_test
}  // namespace inbetween
