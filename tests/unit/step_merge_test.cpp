#include "inbetween/steps/step_merge.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <ostream>
#include <span>
#include <utility>
#include <vector>

namespace inbetween {
namespace step_merge_test {

constexpr StepTiming timing{.pulse_ns = 30, .pause_ns = 50, .dir_setup_ns = 20, .dir_hold_ns = 10};
constexpr std::int64_t start_ns = 1'000'000;

constexpr StepEdge rise(std::int64_t at_ns) {
  return {.at_ns = at_ns, .line = StepLine::step, .level = true};
}
constexpr StepEdge fall(std::int64_t at_ns) {
  return {.at_ns = at_ns, .line = StepLine::step, .level = false};
}
constexpr StepEdge dir(std::int64_t at_ns, bool level) {
  return {.at_ns = at_ns, .line = StepLine::dir, .level = level};
}
using Edges = std::vector<StepEdge>;

/// Axis i has STEP on line 2 i and DIR on line 2 i + 1.
std::vector<StepLines> lines_of(std::size_t axes) {
  std::vector<StepLines> lines;
  for (std::size_t i = 0; i < axes; ++i) {
    const auto first = static_cast<std::int32_t>(2 * i);
    lines.push_back({.step = first, .dir = first + 1, .timing = timing});
  }
  return lines;
}

/// From start_ns.
struct Instant {
  std::int64_t at_ns = 0;
  std::uint64_t levels = 0;
  std::uint64_t mask = 0;
  friend bool operator==(const Instant&, const Instant&) = default;
};
void PrintTo(const Instant& instant, std::ostream* out) {
  *out << instant.at_ns << " ns: " << instant.levels << " of " << instant.mask;
}

std::vector<Instant> merged(const std::vector<Edges>& axes, std::int64_t grain_ns = 0) {
  const StepMerge merge = StepMerge::make(lines_of(axes.size()), grain_ns).value();
  std::vector<std::span<const StepEdge>> edges(axes.begin(), axes.end());
  std::vector<EdgeInstant> memory(100);
  const std::size_t size = merge.merge(start_ns, edges, memory).value();
  std::vector<Instant> instants;
  for (std::size_t i = 0; i < size; ++i)
    instants.push_back({memory[i].at_ns - start_ns, memory[i].levels, memory[i].mask});
  return instants;
}

TEST(StepMerge, PutsTheEdgesOfAllAxesInOrder) {
  EXPECT_EQ(merged({{dir(0, true), rise(100), fall(130)}, {rise(90), fall(120)}}),
            (std::vector<Instant>{{0, 2, 2}, {90, 4, 4}, {100, 1, 1}, {120, 0, 4}, {130, 0, 1}}));
  EXPECT_TRUE(merged({{}, {}}).empty());
}

TEST(StepMerge, EdgesAtTheSameTimeShareAnInstant) {
  EXPECT_EQ(merged({{rise(100), fall(130)}, {dir(100, true), rise(130), fall(160)}, {dir(100, false)}}),
            (std::vector<Instant>{{100, 1 + 8, 1 + 8 + 32}, {130, 4, 1 + 4}, {160, 0, 4}}));
}

TEST(StepMerge, AGrainJoinsTheStepsOfTwoAxes) {
  const std::vector<Edges> axes{{rise(100), fall(130), rise(300), fall(330)},
                                {rise(105), fall(135), rise(303), fall(333)}};
  EXPECT_EQ(merged(axes).size(), 8U);
  // The last pulses are not moved; their successors may be near.
  EXPECT_EQ(
      merged(axes, 5),
      (std::vector<Instant>{{105, 5, 5}, {135, 0, 5}, {300, 1, 1}, {303, 4, 4}, {330, 0, 1}, {333, 0, 4}}));
  EXPECT_EQ(merged(axes, 4).size(), 8U);
}

TEST(StepMerge, AnEdgeWaitsOnlyAsFarAsThePausePermits) {
  // The first pulse of axis 0 has a second one 3 ns more than the least behind it.
  EXPECT_EQ(
      merged({{rise(100), fall(130), rise(183), fall(213)}, {rise(103), fall(133), rise(400), fall(430)}},
             10),
      (std::vector<Instant>{{103, 5, 5}, {133, 0, 5}, {183, 1, 1}, {213, 0, 1}, {400, 4, 4}, {430, 0, 4}}));
  EXPECT_EQ(
      merged({{rise(100), fall(130), rise(182), fall(212)}, {rise(103), fall(133), rise(400), fall(430)}}, 10)
          .front(),
      (Instant{100, 1, 1}));
}

TEST(StepMerge, ThePauseHoldsAcrossAChangeOfDir) {
  // From the fall to DIR and on to the rise there is room, but from the fall to the rise there is just the
  // pause: the rise is delayed with the fall,
  const Edges other{rise(105), fall(135), rise(600), fall(630)};
  EXPECT_EQ(
      merged({{rise(100), fall(130), dir(145, false), rise(180), fall(210), rise(500), fall(530)}, other}, 5),
      (std::vector<Instant>{{105, 5, 5},
                            {135, 0, 5},
                            {145, 0, 2},
                            {185, 1, 1},
                            {215, 0, 1},
                            {500, 1, 1},
                            {530, 0, 1},
                            {600, 4, 4},
                            {630, 0, 4}}));
  // or, where it cannot be, neither is.
  EXPECT_EQ(merged({{rise(100), fall(130), dir(145, false), rise(180)}, other}, 5).front(),
            (Instant{100, 1, 1}));
}

TEST(StepMerge, TheLastFallOfATickStaysEvenWithADirBehindIt) {
  EXPECT_EQ(merged({{fall(100), dir(150, true)}, {dir(105, true), rise(300)}}, 10).front(),
            (Instant{100, 0, 1}));
}

TEST(StepMerge, NoEdgeIsDelayedByMoreThanTheGrain) {
  // A chain of edges, each near the next: the first takes only what it can wait for.
  const std::vector<Edges> axes{{dir(100, true), dir(900, false)},
                                {dir(106, true), dir(900, false)},
                                {dir(112, true), dir(900, false)}};
  EXPECT_EQ(merged(axes, 10), (std::vector<Instant>{{106, 2 + 8, 2 + 8}, {112, 32, 32}, {900, 0, 42}}));
}

TEST(StepMerge, LinesThatCannotBeAreRefused) {
  const auto refused = [](const std::vector<StepLines>& lines, std::int64_t grain_ns = 0) {
    const Result<StepMerge> made = StepMerge::make(lines, grain_ns);
    EXPECT_FALSE(made);
    return made ? Error{} : made.error();
  };
  EXPECT_EQ(refused({}).code, ErrorCode::wrong_count);
  EXPECT_EQ(refused(lines_of(1), -1).code, ErrorCode::out_of_range);
  for (const auto& [step, dir_line] : {std::pair{-1, 3}, {64, 3}, {3, -1}, {3, 64}, {3, 3}, {0, 3}, {3, 1}}) {
    std::vector<StepLines> lines = lines_of(2);
    lines[1] = {.step = step, .dir = dir_line, .timing = timing};
    const Error error = refused(lines);
    EXPECT_EQ(error.code, ErrorCode::out_of_range) << step << " " << dir_line;
    EXPECT_EQ(error.axis, 1);
  }
  EXPECT_TRUE(StepMerge::make(lines_of(32)));
}

TEST(StepMerge, EdgesThatBreakTheTimingAreRefused) {
  const StepMerge merge = StepMerge::make(lines_of(2)).value();
  std::vector<EdgeInstant> memory(20);
  const Edges good{rise(0), fall(30), rise(80)};
  const auto error_of = [&](const Edges& edges) {
    const std::vector<std::span<const StepEdge>> axes{good, edges};
    const Result<std::size_t> result = merge.merge(0, axes, memory);
    EXPECT_FALSE(result);
    return result ? Error{} : result.error();
  };
  for (const Edges& edges :
       {Edges{rise(0), fall(29)}, Edges{fall(0), rise(49)}, Edges{dir(0, true), rise(19)},
        Edges{fall(0), dir(9, true)}, Edges{dir(0, true), dir(19, false)}, Edges{rise(50), fall(0)},
        Edges{rise(0), dir(100, true)}, Edges{dir(0, true), fall(100)}, Edges{rise(0), rise(100)},
        Edges{fall(0), dir(15, true), rise(45)}}) {
    EXPECT_EQ(error_of(edges).code, ErrorCode::out_of_range);
    EXPECT_EQ(error_of(edges).axis, 1);
  }
}

TEST(StepMerge, MissingListsAndTooLittleMemoryAreRefused) {
  const StepMerge merge = StepMerge::make(lines_of(2)).value();
  const Edges edges{rise(0), fall(30)};
  std::vector<EdgeInstant> memory(1);
  const std::vector<std::span<const StepEdge>> one{edges};
  EXPECT_EQ(merge.merge(0, one, memory).error().code, ErrorCode::wrong_count);
  const std::vector<std::span<const StepEdge>> two{edges, edges};
  const Result<std::size_t> refused = merge.merge(0, two, memory);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::capacity);
  EXPECT_EQ(refused.error().needed, 4);
}

}  // namespace step_merge_test
}  // namespace inbetween
