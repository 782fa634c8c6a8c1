// A take beside others: differences, accuracy and repeatability, what shows wear.
#include "host_tools/takes/take_compare.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/takes/take_budget.hpp"
#include "host_tools/takes/take_errors_output.hpp"
#include "host_tools/takes/take_line.hpp"
#include "host_tools/takes/take_passes.hpp"
#include "host_tools/takes/take_trend.hpp"
#include "tests/support/played_take.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace take_compare_test {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;
using Json = nlohmann::json;

const std::string rig = rig_text({{.name = "slide"}, {.name = "pan", .unit = "deg"}});

/// 4 ticks a frame: there and back, and a rest.
const std::string there_and_back = R"(name = "there and back"
fps = 25
frames = 100
[[track]]
axes = ["slide"]
timing = "frames"
keys = [{ at = [0], frame = 0 }, { at = [100], frame = 40 }, { at = [0], frame = 80 }, { at = [0], frame = 100 }]
[[track]]
axes = ["pan"]
timing = "frames"
keys = [{ at = [0], frame = 0 }, { at = [30], frame = 90 }, { at = [30], frame = 100 }]
)";

/// The slide alone.
const std::string one_way =
    "name = \"m\"\nfps = 25\nframes = 100\n[[track]]\naxes = [\"slide\"]\n"
    "keys = [{ at = [0] }, { at = [9] }]\nspeed = [0, 0, 9, 0, 0]\n";

using Error = std::function<double(std::int64_t tick, std::size_t axis)>;

TakeSamples samples_of(const Plan& plan, const PlayedTake& played) {
  return TakeSamples(played_take(plan, played));
}

/// An error of one axis at one tick.
Error bump(std::int64_t at, std::size_t of, double size) {
  return [=](std::int64_t tick, std::size_t axis) { return tick == at && axis == of ? size : 0.0; };
}

template <class Print>
std::string printed(const Print& print) {
  const TemporaryFile file("out", "");
  std::FILE* out = std::fopen(file.path().c_str(), "w");
  print(out);
  std::fclose(out);
  return file_contents(file.path());
}

template <class Write>
Json written(const Write& write) {
  return Json::parse(printed([&](std::FILE* out) {
    JsonWriter json(out);
    json.begin_object();
    write(json);
    json.end_object();
    json.finish();
  }));
}

TEST(TakeCompare, SaysTheLargestDifferenceAndItsFrame) {
  const Plan plan = plan_of(there_and_back, rig);
  const TakeSamples first = samples_of(plan, {.number = 1, .error = bump(50, 0, 0.0625)});
  const TakeSamples second = samples_of(plan, {.number = 4, .error = bump(50, 0, -0.125)});
  const TakeComparison comparison = compare_takes(first, second, measures_of(plan));
  // Tick 50 answers tick 49, frame 12.25.
  EXPECT_NEAR(comparison.measures[0].errors.all().worst(), -0.1875, 1e-12);
  EXPECT_EQ(comparison.measures[0].errors.all().worst_at(), (FrameTime{12, 0.25}));
  EXPECT_EQ(comparison.measures[0].interpolation, 0) << "both have ticks at the same times";
  EXPECT_EQ(comparison.measures[1].errors.all().worst(), 0);
  EXPECT_EQ(comparison.places, 401) << "of the rest at the end the last tick";
  EXPECT_EQ(comparison.only_second, 0);
  EXPECT_EQ(in_one_sentence(comparison),
            "take 4 differs from take 1 by at most 0.19 mm at frame 12, 0 deg at frame 0");
}

TEST(TakeCompare, OfACraneNamesTipAndPicture) {
  const Plan plan = plan_of_crane();
  const TakeComparison comparison = compare_takes(
      samples_of(plan, {}), samples_of(plan, {.number = 4, .error = bump(1001, 0, 0.18)}), measures_of(plan));
  const double pixels = comparison.measures[8].errors.all().worst();
  const std::string in_pixels = in_words(pixels, comparison.measures[8].measure);
  EXPECT_EQ(in_one_sentence(comparison),
            fmt::format("take 4 differs from take 1 by at most 0.18 mm, {}, at frame 96", in_pixels));
  const BudgetVerdict over = judge({.largest = 0.9 * pixels, .unit = TakeBudget::Unit::px}, comparison);
  EXPECT_FALSE(over.holds);
  EXPECT_THAT(over.sentence, HasSubstr(fmt::format("\"camera\" is off by {} at frame 96, over", in_pixels)));
  EXPECT_TRUE(judge({.largest = 1.1 * pixels, .unit = TakeBudget::Unit::px}, comparison).holds);
  EXPECT_TRUE(judge({.largest = 0.1801, .unit = TakeBudget::Unit::mm}, comparison).holds);
  EXPECT_FALSE(judge({.largest = 0.1799, .unit = TakeBudget::Unit::mm}, comparison).holds);
}

TEST(TakeCompare, BetweenTicksTheBoundOfTheInterpolationHolds) {
  const Plan plan = plan_of(there_and_back, rig);
  const TakeComparison comparison =
      compare_takes(samples_of(plan, {}), samples_of(plan, {.number = 2, .phase = 0.5}), measures_of(plan));
  const TakeComparison::Of& slide = comparison.measures[0];
  const double missed = std::fabs(slide.errors.all().worst());
  EXPECT_GT(missed, 1e-4) << "both were on the path exactly: the whole difference is interpolation";
  EXPECT_LE(missed, slide.interpolation);
  EXPECT_LE(slide.interpolation, 1.2 * missed);
  // What may be missing counts against a budget.
  const TakeBudget budget{.largest = missed + slide.interpolation / 2, .unit = TakeBudget::Unit::mm};
  EXPECT_FALSE(judge(budget, comparison).holds);
}

TEST(TakeCompare, NothingIsMadeUpAcrossLostTicks) {
  const Plan plan = plan_of(there_and_back, rig);
  Take holed = played_take(plan);
  holed.ticks_of_take.erase(holed.ticks_of_take.begin() + 100, holed.ticks_of_take.begin() + 110);
  const TakeSamples second = samples_of(plan, {.number = 2, .phase = 0.5});
  const TakeComparison comparison = compare_takes(TakeSamples(holed), second, measures_of(plan));
  // The gap begins behind the answer to tick 98, and ends with that to tick 110.
  EXPECT_EQ(comparison.only_second, 12);
  // The pan rests at the end: the place behind which the first has no further tick is the end itself.
  EXPECT_EQ(comparison.places + comparison.only_second, 401);
}

TEST(TakeCompare, OfATakeThatWentBackAndForthIsWhatLeadsOn) {
  const Plan plan = plan_of(there_and_back, rig);
  Take take = played_take(plan, {.number = 3});
  // 20 ticks back from tick 200 and on again, off by 5 meanwhile.
  const std::vector<TakeTick> whole = take.ticks_of_take;
  take.ticks_of_take.assign(whole.begin(), whole.begin() + 200);
  for (int k = 0; k < 40; ++k) {
    TakeTick tick = whole[static_cast<std::size_t>(k < 20 ? 198 - k : 160 + k)];
    tick.actual[0] += 5;
    take.ticks_of_take.push_back(tick);
  }
  take.ticks_of_take.insert(take.ticks_of_take.end(), whole.begin() + 200, whole.end());
  for (std::size_t i = 0; i < take.ticks_of_take.size(); ++i) {
    take.ticks_of_take[i].number = static_cast<std::int64_t>(i);
  }
  const TakeComparison comparison =
      compare_takes(TakeSamples(take), samples_of(plan, {.number = 4}), measures_of(plan));
  EXPECT_EQ(comparison.only_second, 0);
  // Tick 200 answers the last setpoint of the way there, and is off already, and so does that which leads on.
  EXPECT_LT(std::fabs(comparison.measures[0].errors.frames()[48].figures.worst()), 1e-12);
  EXPECT_LT(std::fabs(comparison.measures[0].errors.frames()[51].figures.worst()), 1e-12);
}

TEST(TakeCompare, OfOtherRigsAndOtherFramesIsRefused) {
  const Plan plan = plan_of(there_and_back, rig);
  Take late = played_take(plan);
  late.ticks_of_take.erase(late.ticks_of_take.begin(), late.ticks_of_take.begin() + 200);
  Take early = played_take(plan);
  early.ticks_of_take.resize(100);
  EXPECT_THROW(compare_takes(TakeSamples(late), TakeSamples(early), measures_of(plan)), std::runtime_error);
  const Plan other = plan_of(one_way, rig_text({{.name = "slide"}}));
  EXPECT_THROW(compare_takes(TakeSamples(late), samples_of(other, {}), measures_of(other)),
               std::runtime_error);
}

TEST(TakePasses, AreAsAccurateAsTheirBarycentreAndAsRepeatableAsTheirDistances) {
  const Plan plan = plan_of(there_and_back, rig);
  std::vector<TakeSamples> takes;
  for (const double off : {0.25, 0.5, 0.75}) {
    takes.push_back(
        samples_of(plan, {.number = static_cast<std::int64_t>(4 * off), .error = bump(9, 0, off)}));
  }
  const PathReport report = path_report(takes, measures_of(plan));
  EXPECT_THAT(report.takes, ElementsAre(1, 2, 3));
  EXPECT_EQ(report.places, 401);
  const PathReport::Of& slide = report.measures[0];
  // Barycentre 0.5; distances 0.25, 0, 0.25 with the mean 1/6 and S = sqrt((2/144 + 1/36) / 2) = 0.1443.
  EXPECT_NEAR(slide.largest.accuracy, 0.5, 1e-12);
  EXPECT_NEAR(slide.largest.repeatability, 1.0 / 6 + 3 * std::sqrt((2.0 / 144 + 1.0 / 36) / 2), 1e-12);
  EXPECT_EQ(slide.accuracy_at, (FrameTime{2, 0}));
  EXPECT_EQ(slide.frames[2].frame, 2);
  EXPECT_NEAR(slide.frames[2].figures.accuracy, 0.5, 1e-12);
  EXPECT_NEAR(slide.frames[3].figures.repeatability, 0, 1e-12);
}

TEST(TakePasses, OfOneTakeAreNone) {
  const Plan plan = plan_of(there_and_back, rig);
  EXPECT_THROW(path_report(std::vector{samples_of(plan, {})}, measures_of(plan)), std::runtime_error);
}

TEST(TakeTrend, SettlesFromTheLastSetpointUntilItStaysWithin) {
  const std::string can =
      rig_text({{.name = "slide",
                 .more = "reference = \"drive\"",
                 .drive = cia402_text(1) + ", max_following_error = 2, in_position = 0.25"},
                {.name = "pan", .unit = "deg"}},
               {.more = bus_can0});
  const Plan plan = plan_of(there_and_back, can);
  // The last setpoint that differs is that of frame 80, tick 320; it is answered in tick 321.
  const auto error = [](std::int64_t tick, std::size_t axis) {
    if (axis == 1 || tick < 300) return 0.0;
    return tick == 330 || tick <= 325 ? 0.5 : 0.25;
  };
  const TakeTrend trend = trend_of(samples_of(plan, {.number = 9, .error = error}), *plan.rig());
  EXPECT_EQ(trend.number, 9);
  EXPECT_EQ(trend.axes[0].tolerance, 0.25);
  ASSERT_TRUE(trend.axes[0].settle_s);
  EXPECT_NEAR(*trend.axes[0].settle_s, 0.10, 1e-12) << "tick 331, though it was within once before";
  EXPECT_EQ(trend.axes[0].following_error_peak, 0.5);
  EXPECT_EQ(trend.axes[1].settle_s, 0) << "it is where it is told to be";
  EXPECT_EQ(trend.axes[1].turns, 0);
  EXPECT_FALSE(trend.axes[1].reversal_error);
}

TEST(TakeTrend, DoesNotSettleWhereTheTakeEndsBefore) {
  const Plan plan = plan_of(there_and_back, rig);
  const TakeTrend off = trend_of(samples_of(plan, {.error = bump(440, 0, 3)}), *plan.rig());
  EXPECT_FALSE(off.axes[0].settle_s) << "it is off at the last tick";
  Take cut = played_take(plan);
  cut.ticks_of_take.resize(200);
  EXPECT_FALSE(trend_of(TakeSamples(cut), *plan.rig()).axes[0].settle_s) << "it still moves";
}

TEST(TakeTrend, ATurnShowsThePlayOfAGear) {
  const Plan plan = plan_of(there_and_back, rig);
  // With a play of 0.5 mm the slide is 0.25 behind in each direction; it turns on frame 40, tick 160.
  const auto error = [](std::int64_t tick, std::size_t axis) {
    if (axis == 1) return 0.0;
    return tick <= 161 ? -0.25 : 0.25;
  };
  const TakeTrend trend = trend_of(samples_of(plan, {.error = error}), *plan.rig());
  EXPECT_EQ(trend.axes[0].turns, 1);
  ASSERT_TRUE(trend.axes[0].reversal_error);
  EXPECT_NEAR(*trend.axes[0].reversal_error, 0.5, 1e-12);
  EXPECT_EQ(trend.axes[0].reversal_at, (FrameTime{40, 0}));
}

TEST(TakeTrend, OnlyTheTicksBesideATurnCount) {
  const Plan plan = plan_of(there_and_back, rig);
  const auto error = [](std::int64_t tick, std::size_t) { return tick < 149 || tick > 175 ? 9.0 : 0.0; };
  const TakeTrend trend = trend_of(samples_of(plan, {.error = error}), *plan.rig());
  EXPECT_NEAR(trend.axes[0].reversal_error.value_or(1), 0, 1e-12);
}

TEST(TakeErrorsOutput, JsonHasWhatTheFunctionsGive) {
  const Plan plan = plan_of(there_and_back, rig);
  const TakeSamples first = samples_of(plan, {});
  const TakeSamples second = samples_of(plan, {.number = 4, .error = bump(50, 0, -0.125)});
  const TakeComparison comparison = compare_takes(first, second, measures_of(plan));
  const BudgetVerdict verdict = judge({.largest = 0.1, .unit = TakeBudget::Unit::mm}, comparison);
  const Json json = written([&](JsonWriter& out) { write_comparison(out, comparison, verdict); });
  EXPECT_EQ(json["format"], 1);
  EXPECT_EQ(json["sentence"], in_one_sentence(comparison));
  EXPECT_EQ(json["measures"][0]["all"]["worst"], comparison.measures[0].errors.all().worst());
  EXPECT_EQ(json["measures"][0]["all"]["worst_frame"], 12.25);
  EXPECT_EQ(json["measures"][0]["frames"][12]["count"], 4);
  EXPECT_EQ(json["budget"]["holds"], false);
  const Json errors =
      written([&](JsonWriter& out) { write_errors(out, errors_of(second, measures_of(plan)), {}); });
  EXPECT_EQ(errors["take"], 4);
  EXPECT_EQ(errors["measures"][0]["kind"], "axis");
  EXPECT_EQ(errors["measures"][1]["at_rest"]["worst"], 0);
  EXPECT_FALSE(errors.contains("budget"));
  const Json path = written([&](JsonWriter& out) {
    write_path_report(out, path_report(std::vector{first, second}, measures_of(plan)));
  });
  EXPECT_NEAR(path["measures"][0]["accuracy"].get<double>(), 0.0625, 1e-12);
  EXPECT_EQ(path["measures"][0]["repeatability_frame"], 12.25);
  const Json trends = written([&](JsonWriter& out) {
    write_trends(out, std::vector{trend_of(first, *plan.rig()), trend_of(second, *plan.rig())});
  });
  EXPECT_EQ(trends["takes"][1]["axes"][0]["following_error_peak"], 0.125);
  EXPECT_TRUE(trends["takes"][1]["axes"][1]["reversal_error"].is_null());
}

TEST(TakeErrorsOutput, WhatNeverMovedHasNoError) {
  const Plan plan = plan_of(one_way, rig);
  const TakeErrors errors = errors_of(samples_of(plan, {}), measures_of(plan));
  EXPECT_THAT(printed([&](std::FILE* out) { print_errors(errors, {}, out); }),
              HasSubstr("             -         -  deg\n"));
}

TEST(TakeErrorsOutput, TextSaysItInLines) {
  const Plan plan = plan_of(there_and_back, rig);
  const TakeSamples first = samples_of(plan, {});
  const TakeSamples second = samples_of(plan, {.number = 4, .phase = 0.5, .error = bump(50, 0, -0.125)});
  const TakeComparison comparison = compare_takes(first, second, measures_of(plan));
  const std::string text = printed([&](std::FILE* out) { print_comparison(comparison, {}, out); });
  EXPECT_THAT(text, StartsWith("take 4 differs from take 1 by at most 0.1"));
  EXPECT_THAT(text, HasSubstr("slide: between ticks of take 1, whose interpolation may be off by 0.0"));
  const TakeErrors errors = errors_of(second, measures_of(plan));
  const BudgetVerdict verdict = judge({.largest = 1, .unit = TakeBudget::Unit::mm}, errors);
  EXPECT_THAT(printed([&](std::FILE* out) { print_errors(errors, verdict, out); }),
              HasSubstr("\"slide\" is off by 0.13 mm at frame 12, within the budget of 1 mm\n"));
  EXPECT_THAT(
      printed([&](std::FILE* out) {
        print_path_report(path_report(std::vector{first, second}, measures_of(plan)), out);
      }),
      AllOf(StartsWith("2 takes at 400 ticks (ISO 9283"), HasSubstr("slide: some are between ticks")));
  EXPECT_THAT(printed([&](std::FILE* out) { print_trends(std::vector{trend_of(second, *plan.rig())}, out); }),
              HasSubstr("     4  slide"));
}

TEST(TrendPlot, HasAPanelForEachAxisAndQuantity) {
  const Plan plan = plan_of(there_and_back, rig);
  std::vector<TakeTrend> trends;
  for (int day = 1; day <= 30; ++day) {
    const auto error = [day](std::int64_t tick, std::size_t axis) {
      const double worn = 0.02 * day / 30;
      const double wobble = 0.002 * std::sin(0.7 * static_cast<double>(tick) + day);
      if (tick > 321 + 2 * day % 7 + day / 3) return axis == 0 ? wobble : 0.0;
      return axis == 0 ? (tick <= 161 ? -worn : worn) + wobble
                       : 0.3 * std::sin(0.05 * static_cast<double>(tick));
    };
    trends.push_back(trend_of(samples_of(plan, {.number = day, .error = error}), *plan.rig()));
  }
  trends[12].axes.erase(trends[12].axes.begin());  // the rig had no slide that day
  const TrendPlot plot = trend_plot("there and back", trends);
  ASSERT_EQ(plot.axes.size(), 2U);
  ASSERT_EQ(plot.axes[0].rows.size(), 3U);
  EXPECT_FALSE(plot.axes[0].rows[0].values[12]);
  EXPECT_EQ(plot.axes[0].rows[2].values[29], trends[29].axes[0].reversal_error);
  const TemporaryFolder folder;
  for (const auto& [name, magic] : {std::pair("t.svg", "<?xml"), {"t.png", "\x89PNG"}, {"t.pdf", "%PDF"}}) {
    draw_trend_plot(plot, folder.path() / name);
    EXPECT_THAT(file_contents(folder.path() / name), StartsWith(magic));
  }
  draw_trend_plot(trend_plot("nothing", {}), folder.path() / "none.svg");
  TrendPlot short_row = plot;
  short_row.axes[0].rows[1].values.pop_back();
  EXPECT_THROW(draw_trend_plot(short_row, folder.path() / "short.svg"), std::invalid_argument);
}

}  // namespace take_compare_test
}  // namespace inbetween
