// What a take was like against its plan: which setpoint a position answers, the figures, the picture of the
// lens.
#include "host_tools/takes/take_errors.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "host_tools/takes/take_budget.hpp"
#include "tests/support/played_take.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace take_errors_test {

using testing::HasSubstr;

const std::string rig = rig_text({{.name = "slide"}, {.name = "pan", .unit = "deg"}});

/// 4 ticks a frame; rests on frames 40 to 50.
const std::string there = R"(name = "there"
fps = 25
frames = 50
[[track]]
axes = ["slide"]
timing = "frames"
keys = [{ at = [0], frame = 0 }, { at = [100], frame = 40 }, { at = [100], frame = 50 }]
)";

TEST(LensView, SeesFarPointsNearTheMiddle) {
  // 5000 px a unit of the slope: 1 m to the left in 10 m is 500 px to the left of the middle.
  const LensView lens({50, {36, 24}, {3600, 2400}, 2, "camera", {}});
  const Pose camera{{}, {1, 2, 3}};
  const auto image = [&](const Vector3& point) { return lens.image_of(camera, point).value(); };
  EXPECT_DOUBLE_EQ(image({11, 2, 3}).x, 1800);
  EXPECT_DOUBLE_EQ(image({11, 2, 3}).y, 1200);
  EXPECT_DOUBLE_EQ(image({11, 3, 3}).x, 1300) << "y is to the left";
  EXPECT_DOUBLE_EQ(image({11, 2, 4}).y, 700) << "z is up";
  EXPECT_FALSE(lens.image_of(camera, {1, 2, 3}));
  EXPECT_FALSE(lens.image_of(camera, {0, 2, 3})) << "it is behind";
}

TEST(LensView, AStepAsideMovesEveryMarkAlike) {
  const LensView lens({50, {36, 24}, {3600, 2400}, 2, "camera", {}});
  EXPECT_NEAR(lens.shift({}, {{}, {0, 0.0004, 0}}), 1, 1e-9);
  EXPECT_NEAR(lens.shift({}, {{}, {0, 0.0003, 0.0004}}), 1.25, 1e-9);
  EXPECT_EQ(lens.shift({}, {}), 0);
  // A step forward leaves the middle where it is and moves the corners outwards: 2163 px * 0.002 / 1.998.
  EXPECT_NEAR(lens.shift({}, {{}, {0.002, 0, 0}}), std::hypot(1800, 1200) * 0.002 / 1.998, 1e-9);
}

TEST(LensView, APixelNeedNotBeSquare) {
  const LensView lens({50, {36, 24}, {3600, 4800}, 2, "camera", {}});
  EXPECT_NEAR(lens.shift({}, {{}, {0, 0, 0.0004}}), 2, 1e-9);
}

TEST(LensView, ATurnCountsWhereItMovesThePictureMost) {
  const LensView lens({50, {36, 24}, {3600, 2400}, 2, "camera", {}});
  const double angle = 0.001;
  const Pose panned{turned_about({0, 0, 1}, sine_cosine(angle)), {}};
  // The middle goes by 5 px, the side by 5 (1 + 0.36^2), and the corner goes up or down too.
  const double shift = lens.shift({}, panned);
  EXPECT_GT(shift, 5 * (1 + 0.36 * 0.36));
  EXPECT_LT(shift, 5 * (1 + 0.36 * 0.36) * 1.03);
  // Rolled, only the corners move.
  const Pose rolled{turned_about({1, 0, 0}, sine_cosine(angle)), {}};
  EXPECT_NEAR(lens.shift({}, rolled), 2 * std::sin(angle / 2) * std::hypot(1800, 1200), 1e-9);
  const Pose away{turned_about({0, 0, 1}, sine_cosine(2)), {}};
  EXPECT_EQ(lens.shift({}, away), std::numeric_limits<double>::infinity());
}

TEST(TakeMeasures, AnAngleIsExactWhereItIsSmallAndWhereItIsHalfATurn) {
  for (const double angle : {0.0, 1e-9, 0.5, 3.0, std::numbers::pi}) {
    const Rotation3 turn = turned_about({0.6, 0, 0.8}, sine_cosine(angle));
    EXPECT_NEAR(angle_between({}, turn), angle * 180 / std::numbers::pi, 1e-12 + 1e-13 * angle);
  }
}

TEST(TakeMeasures, AtMostIsRoundedUp) {
  const Measure mm{.kind = Measure::Kind::distance, .name = "camera", .unit = "mm"};
  EXPECT_EQ(in_words(0.18, mm), "0.18 mm");
  EXPECT_EQ(in_words(-0.1801, mm), "0.19 mm");
  EXPECT_EQ(in_words(2.04, mm), "2.1 mm");
  EXPECT_EQ(in_words(0.0999, mm), "0.100 mm");
  EXPECT_EQ(in_words(123, mm), "130 mm");
  EXPECT_EQ(in_words(0, mm), "0 mm");
  EXPECT_EQ(in_words(1.01e-7, mm), "1.1e-07 mm");
  EXPECT_EQ(in_words(std::numeric_limits<double>::infinity(), mm), "out of sight");
}

TEST(ErrorFigures, OfAFewErrors) {
  MeasuredErrors errors;
  errors.add(1, {3, 0.5}, true);
  errors.add(-4, {4, 0}, false);
  errors.add(4, {4, 0.25}, false);
  errors.add(-2, {3, 0.75}, false);
  EXPECT_EQ(errors.all().count(), 4);
  EXPECT_EQ(errors.all().worst(), -4) << "the first of two that are as large";
  EXPECT_EQ(in_frames(errors.all().worst_at()), 4);
  EXPECT_EQ(errors.all().mean(), -0.25);
  EXPECT_EQ(errors.all().rms(), std::sqrt(37.0 / 4));
  EXPECT_EQ(errors.at_rest().count(), 1);
  EXPECT_EQ(errors.moving().mean(), -2.0 / 3);
  ASSERT_EQ(errors.frames().size(), 2U);
  EXPECT_EQ(errors.frames()[0].frame, 3) << "though it came again";
  EXPECT_EQ(errors.frames()[0].figures.worst(), -2);
  EXPECT_EQ(errors.frames()[1].figures.mean(), 0);
}

TEST(TakeSamples, APositionAnswersTheSetpointOfTheTickBefore) {
  const Plan plan = plan_of(there, rig);
  const Take take = played_take(plan);
  const TakeSamples samples(take);
  ASSERT_EQ(samples.size(), take.ticks_of_take.size() - 1);
  EXPECT_EQ(samples[10].tick, 11);
  EXPECT_EQ(samples[10].time, (FrameTime{2, 0.5}));
  for (std::size_t i = 0; i < samples.size(); ++i) EXPECT_EQ(samples.commanded(i)[0], samples.actual(i)[0]);
  EXPECT_GT(samples.commanded(80)[0], samples.commanded(79)[0]);
}

TEST(TakeSamples, BehindLostTicksThereIsNoSetpointToAnswer) {
  const Plan plan = plan_of(there, rig);
  Take take = played_take(plan);
  take.ticks_of_take.erase(take.ticks_of_take.begin() + 20, take.ticks_of_take.begin() + 23);
  const TakeSamples samples(take);
  EXPECT_EQ(samples.size(), take.ticks_of_take.size() - 2);
  EXPECT_EQ(samples[18].tick, 19);
  EXPECT_EQ(samples[19].tick, 24);
}

TEST(TakeSamples, ARigThatIsToldNothingIsNotMeasured) {
  const Plan plan = plan_of(there, rig);
  Take take = played_take(plan);
  std::vector<TakeTick>& ticks = take.ticks_of_take;
  for (std::size_t i = 0; i < 10; ++i) ticks[i].state = SupervisorState::ready;
  for (std::size_t i = 100; i < 110; ++i) ticks[i].state = SupervisorState::cut_off;
  for (std::size_t i = 110; i < 120; ++i) ticks[i].state = SupervisorState::ready;
  const TakeSamples samples(take);
  // Ready before the start holds where the rig stood, and so does ready after a loss of power.
  EXPECT_EQ(samples[0].tick, 11);
  EXPECT_EQ(samples[88].tick, 99);
  EXPECT_EQ(samples[89].tick, 121);
}

TEST(TakeSamples, AMotionThatIsNotTheMoveIsNotMeasured) {
  const Plan plan = plan_of(there, rig);
  Take take = played_take(plan);
  for (std::size_t i = 100; i < 110; ++i) take.ticks_of_take[i].time.reset();
  const TakeSamples samples(take);
  EXPECT_EQ(samples.size(), take.ticks_of_take.size() - 1 - 10);
  EXPECT_EQ(samples[99].tick, 100);
  EXPECT_EQ(samples[100].tick, 111);
}

TEST(TakeSamples, BehindTheEndTheLastSetpointIsHeld) {
  const Plan plan = plan_of(there, rig);
  Take take = played_take(plan);
  for (auto tick = take.ticks_of_take.end() - 30; tick != take.ticks_of_take.end(); ++tick) {
    tick->state = SupervisorState::ready;
    tick->time.reset();
  }
  const TakeSamples samples(take);
  EXPECT_EQ(samples.size(), take.ticks_of_take.size() - 1);
  EXPECT_EQ(samples[samples.size() - 1].time, (FrameTime{50, 0}));
}

TEST(TakeSamples, OfAnotherRigAreRefused) {
  const Plan plan = plan_of(there, rig);
  const Plan other = plan_of(there, rig_text({{.name = "slide"}, {.name = "tilt", .unit = "deg"}}));
  EXPECT_THROW(errors_of(TakeSamples(played_take(plan)), measures_of(other)), std::runtime_error);
  const Plan in_m =
      plan_of(there, rig_text({{.name = "slide", .unit = "m"}, {.name = "pan", .unit = "deg"}}));
  EXPECT_THROW(errors_of(TakeSamples(played_take(plan)), measures_of(in_m)), std::runtime_error);
  Take damaged = played_take(plan);
  damaged.ticks_of_take[7].actual.pop_back();
  EXPECT_THROW(TakeSamples{damaged}, std::runtime_error);
}

TEST(TakeErrors, AreThoseOfTheAxesWhileTheyRestAndWhileTheyMove) {
  const Plan plan = plan_of(there, rig);
  // The slide is 0.5 mm behind while it moves, up to the setpoint of frame 40, which tick 161 answers; then
  // it is 0.125 beyond. The pan is in no track.
  const auto error = [](std::int64_t tick, std::size_t axis) {
    if (axis == 1) return tick == 30 ? 0.25 : 0.0;
    return tick <= 161 ? -0.5 : 0.125;
  };
  const TakeErrors errors =
      errors_of(TakeSamples(played_take(plan, {.number = 4, .error = error})), measures_of(plan));
  EXPECT_EQ(errors.number, 4);
  ASSERT_EQ(errors.measures.size(), 2U);
  const MeasuredErrors& slide = errors.measures[0].errors;
  EXPECT_NEAR(slide.moving().worst(), -0.5, 1e-12);
  EXPECT_NEAR(slide.moving().mean(), -0.5, 1e-12);
  EXPECT_NEAR(slide.at_rest().worst(), 0.125, 1e-12);
  EXPECT_EQ(slide.at_rest().worst_at(), (FrameTime{40, 0.25}));
  EXPECT_EQ(slide.moving().count() + slide.at_rest().count(), errors.samples);
  ASSERT_EQ(slide.frames().size(), 51U);
  EXPECT_EQ(slide.frames()[20].figures.count(), 4);
  EXPECT_NEAR(slide.frames()[40].figures.rms(), std::sqrt((0.25 + 3 * 0.125 * 0.125) / 4), 1e-12);
  EXPECT_TRUE(errors.measures[1].is_held);
  EXPECT_EQ(errors.measures[1].errors.moving().count(), 0);
  EXPECT_EQ(errors.measures[1].errors.all().worst(), 0.25);
  EXPECT_EQ(in_frames(errors.measures[1].errors.all().worst_at()), 7.25);
}

TEST(TakeErrors, OfACraneAreThoseOfItsTipAndItsPicture) {
  const Plan plan = plan_of_crane();
  // The track is 0.3 mm further at one tick.
  const auto error = [](std::int64_t tick, std::size_t axis) {
    return tick == 1000 && axis == 0 ? 0.3 : 0.0;
  };
  const TakeErrors errors = errors_of(TakeSamples(played_take(plan, {.error = error})), measures_of(plan));
  ASSERT_EQ(errors.measures.size(), 9U);
  EXPECT_EQ(errors.measures[6].measure.name, "camera");
  EXPECT_NEAR(errors.measures[6].errors.all().worst(), 0.3, 1e-9);
  EXPECT_NEAR(errors.measures[7].errors.all().worst(), 0, 1e-9);
  EXPECT_LT(errors.measures[6].errors.at_rest().count(), 60) << "not wherever the roll rests";
  EXPECT_EQ(errors.measures[5].errors.moving().count(), 0);
  const double pixels = errors.measures[8].errors.all().worst();
  EXPECT_GT(pixels, 0.1);
  EXPECT_LT(pixels, 1.2) << "5689 px a unit of the slope, 2 m away";
  EXPECT_EQ(errors.measures[8].errors.all().worst_at(), frame_time_of_tick(999, {24, 1}, 250));
}

TEST(TakeErrors, WhereTheLensLooksElsewhereAreOutOfSight) {
  const Plan plan = plan_of_crane();
  const auto error = [](std::int64_t tick, std::size_t axis) {
    return tick == 1000 && axis == 3 ? 100.0 : 0.0;
  };
  const TakeErrors errors = errors_of(TakeSamples(played_take(plan, {.error = error})), measures_of(plan));
  EXPECT_TRUE(std::isinf(errors.measures[8].errors.all().worst()));
  const BudgetVerdict verdict = judge({.largest = 1e9, .unit = TakeBudget::Unit::px}, errors);
  EXPECT_FALSE(verdict.holds);
  EXPECT_THAT(verdict.sentence, HasSubstr("\"camera\" is out of sight at frame 95, over the budget"));
}

TEST(TakeBudget, IsANumberAndAUnit) {
  EXPECT_EQ(parse_budget("1px").unit, TakeBudget::Unit::px);
  EXPECT_EQ(parse_budget("0.25 mm").largest, 0.25);
  EXPECT_EQ(parse_budget("0deg").unit, TakeBudget::Unit::deg);
  for (const char* text : {"", "1", "px", "-1px", "nan px", "inf mm", "1 cm", "1px more", "1e999mm"}) {
    try {
      parse_budget(text);
      ADD_FAILURE() << text;
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr("such as 1px or 0.2mm"));
    }
  }
}

TEST(TakeBudget, HoldsForTheTipsOrElseForTheAxesOfItsUnit) {
  const Plan plan =
      plan_of(there, rig_text({{.name = "slide", .unit = "m"}, {.name = "pan", .unit = "turn"}}));
  const auto error = [](std::int64_t, std::size_t axis) { return axis == 0 ? -0.25 : 0; };
  const TakeErrors errors = errors_of(TakeSamples(played_take(plan, {.error = error})), measures_of(plan));
  const BudgetVerdict over = judge({.largest = 249, .unit = TakeBudget::Unit::mm}, errors);
  EXPECT_FALSE(over.holds);
  EXPECT_NEAR(over.largest, 250, 1e-9);
  EXPECT_THAT(over.sentence, HasSubstr("\"slide\" is off by 250 mm at frame"));
  EXPECT_THAT(over.sentence, HasSubstr("over the budget of 249 mm"));
  EXPECT_TRUE(judge({.largest = 251, .unit = TakeBudget::Unit::mm}, errors).holds);
  EXPECT_TRUE(judge({.largest = 0, .unit = TakeBudget::Unit::deg}, errors).holds);
  EXPECT_THROW(judge({.largest = 1, .unit = TakeBudget::Unit::px}, errors), std::runtime_error);
}

}  // namespace take_errors_test
}  // namespace inbetween
