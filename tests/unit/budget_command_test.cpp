// `inbetween budget` as its users meet it, and what it says against the memory that moves really take.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <sstream>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "host_tools/cli/budget.hpp"
#include "host_tools/move_model/move_file.hpp"
#include "host_tools/plan/fitted_trajectory.hpp"
#include "host_tools/plan/plan.hpp"
#include "inbetween/can/cia402_drive.hpp"
#include "inbetween/limits/roll.hpp"
#include "inbetween/limits/stop_bounds.hpp"
#include "inbetween/play/playhead.hpp"
#include "inbetween/timing/key_timing.hpp"
#include "inbetween/timing/track.hpp"
#include "inbetween/trajectory/count_trajectory.hpp"
#include "inbetween/trajectory/fit.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"

namespace inbetween {
namespace budget_command_test {

using testing::HasSubstr;
using testing::StartsWith;

std::int64_t bytes_of(const BudgetCapacity& capacity, std::string_view name) {
  for (const BudgetObject& object : budget_objects(capacity)) {
    if (object.name.find(name) != std::string_view::npos) {
      return object.bytes;
    }
  }
  ADD_FAILURE() << "the budget has no " << name;
  return 0;
}

/// What a Track of a drawn curve takes.
std::int64_t bytes_of_track(const BudgetCapacity& capacity) {
  std::int64_t sum = 0;
  for (const char* part : {"path", "arc length", "speed profile", "track"}) {
    sum += bytes_of(capacity, part);
  }
  return sum;
}

/// In the order of their lines; "-" is 0.
std::vector<std::int64_t> numbers_behind(const std::string& text, const std::string& name) {
  std::vector<std::int64_t> numbers;
  const std::size_t begin = text.find("\n  " + name + " ");
  if (begin == std::string::npos) return numbers;
  std::istringstream words(
      text.substr(begin + 3 + name.size(), text.find('\n', begin + 1) - begin - 3 - name.size()));
  for (std::string word; words >> word;) numbers.push_back(word == "-" ? 0 : std::stoll(word));
  return numbers;
}

TEST(BudgetCommand, PrintsTheMemoryAndTheLimitsThatTheTestsHold) {
  const ProgramRun run = run_program({"budget"});
  EXPECT_EQ(run.status, 0);
  EXPECT_EQ(run.err, "");
  EXPECT_THAT(
      run.out,
      StartsWith("Memory in bytes for 8 keys, 3 axes, 10 control values, 240 frames, 0 locked keys:\n"));
  for (const BudgetObject& object : budget_objects({})) {
    EXPECT_EQ(numbers_behind(run.out, std::string(object.name)), (std::vector{object.bytes})) << object.name;
  }
  for (const auto& limits : {stack_limits(), instruction_limits()}) {
    EXPECT_GE(limits.size(), 5U);
    for (const FunctionBudget& function : limits) {
      EXPECT_THAT(run.out, HasSubstr(fmt::format("\n  {:<40}{:>12}{:>12}\n", function.name,
                                                 function.cortex_m7, function.cortex_m4f)));
    }
  }
}

/// By the standard: 55 bits of SYNC, 115 and 125 of a setpoint and its feedback.
TEST(BudgetCommand, CountsTheFramesAndTheLoadOfACanBus) {
  const ProgramRun run = run_program({"budget", "--axes", "4", "--rate", "500"});
  EXPECT_THAT(run.out, HasSubstr("CAN bus with 4 CiA 402 drives at 500 Hz"));
  EXPECT_THAT(run.out, HasSubstr("frames in every tick: 9 "));
  EXPECT_THAT(run.out, testing::ContainsRegex("\n  500000 +101.5 +2\n"));
  EXPECT_THAT(run.out, testing::ContainsRegex("\n  1000000 +50.8 +5\n"));
  EXPECT_EQ(bytes_of({.axes = 4}, "CiA 402 drives"), static_cast<std::int64_t>(4 * sizeof(can::Cia402Drive)));
  EXPECT_GE(bytes_of({.axes = 4}, "their CAN bus"), static_cast<std::int64_t>(32 * sizeof(can::Frame)));
}

TEST(BudgetCommand, TakesEveryPartOfTheCapacityFromItsOption) {
  const ProgramRun run = run_program({"budget", "--keys", "21", "--axes", "5", "--control-values", "33",
                                      "--frames", "1000", "--locks", "4", "--delta", "1e-4"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(
      run.out,
      StartsWith("Memory in bytes for 21 keys, 5 axes, 33 control values, 1000 frames, 4 locked keys:\n"));
  const BudgetCapacity capacity{
      .keys = 21, .axes = 5, .control_values = 33, .frames = 1000, .delta = 1e-4, .locks = 4};
  for (const BudgetObject& object : budget_objects(capacity)) {
    EXPECT_EQ(numbers_behind(run.out, std::string(object.name)), (std::vector{object.bytes})) << object.name;
  }
}

TEST(BudgetCommand, ItsHelpNamesEveryOptionAndSaysWhatTheTablesAre) {
  EXPECT_THAT(run_program({"--help"}).out, HasSubstr("\n  budget "));
  const ProgramRun run = run_program({"budget", "--help"});
  EXPECT_EQ(run.status, 0);
  for (const char* words : {"--keys", "--axes", "--control-values", "--frames", "--delta", "--locks",
                            "1 to 10000", "worst stack", "instructions", "inbetween budget --keys 100"}) {
    EXPECT_THAT(run.out, HasSubstr(words));
  }
}

void expect_refused(const std::vector<std::string>& options, std::initializer_list<const char*> words) {
  std::vector<std::string> arguments{"budget"};
  arguments.insert(arguments.end(), options.begin(), options.end());
  const ProgramRun run = run_program(arguments);
  EXPECT_EQ(run.status, 2) << options.front();
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  EXPECT_THAT(run.err, StartsWith("inbetween: error: "));
  EXPECT_THAT(run.err, HasSubstr("; see inbetween budget --help\n"));
  for (const char* word : words) EXPECT_THAT(run.err, HasSubstr(word));
}

TEST(BudgetCommand, RefusesWhatIsNoCapacity) {
  for (const char* option : {"--keys", "--axes", "--control-values", "--frames"}) {
    for (const char* number : {"0", "-1", "1000001", "99999999999", "3.5", "many", "nan", ""}) {
      expect_refused({std::string(option) + "=" + number}, {option});
    }
  }
  expect_refused({"--keys", "10001"}, {"--keys", "10001", "1 to 10000"});
  expect_refused({"--axes", "65"}, {"--axes", "65", "1 to 64"});
  expect_refused({"--control-values", "100001"}, {"--control-values", "100001"});
  expect_refused({"--locks=-1"}, {"--locks", "-1"});
  expect_refused({"--keys", "5", "--locks", "6"}, {"--locks 6 is more than --keys 5", "raise --keys"});
  for (const char* delta : {"0", "0.1", "1e-10", "-1e-6", "nan", "inf", "small"}) {
    expect_refused({std::string("--delta=") + delta}, {"--delta", "range 1e-09 to below 0.1"});
  }
  expect_refused({"--delta="}, {"--delta"});
  expect_refused({"move.toml"}, {"move.toml"});
  expect_refused({"--keys", "5", "--keys", "6"}, {"--keys"});
}

/// But for what the compiler puts between the parts of a storage.
void expect_size(std::int64_t bytes, std::size_t size_of_storage) {
  EXPECT_NEAR(static_cast<double>(bytes), static_cast<double>(size_of_storage), 16);
}

TEST(Budget, IsWhatTheStoragesOfTheCoreTake) {
  constexpr BudgetCapacity capacity{.keys = 8, .axes = 3, .control_values = 10, .locks = 3};
  expect_size(bytes_of_track(capacity), sizeof(TrackStorage<8, 3, 10, std::size_t{8} * 26>));
  expect_size(bytes_of(capacity, "adjusted"), sizeof(KeyTimingStorage<3, 10>));
  expect_size(bytes_of(capacity, "frame table"), sizeof(std::array<PathPoint, 241>));
  expect_size(bytes_of(capacity, "breaks"), sizeof(std::array<Portion, 4>));
  expect_size(bytes_of(capacity, "timed by frames"), sizeof(std::array<KeyInterval, 8>));
  // 8 segments and 9 spans; the joints between them may be breaks, each with a row of its own.
  expect_size(bytes_of(capacity, "trajectory"), sizeof(std::array<TrajectoryPiece, 196>) +
                                                    sizeof(std::array<std::uint32_t, 196>) +
                                                    sizeof(std::array<double, (196 + 17 + 1) * 4 * 3>));
  expect_size(bytes_of(capacity, "its counts"),
              sizeof(std::array<CountTrajectoryPiece, 196>) + sizeof(std::array<CountPolynomial, 3 * 196>));
}

TEST(Budget, IsWhatPlayingTakes) {
  constexpr std::size_t cells = 256;
  EXPECT_EQ(budget_stop_cells, std::int64_t{cells});
  constexpr BudgetCapacity capacity{.axes = 5};
  expect_size(bytes_of(capacity, "pre-roll and post-roll"), sizeof(std::array<RollAxis, 10>));
  expect_size(bytes_of(capacity, "stop bounds, 256 cells"), sizeof(std::array<StopCell, cells + 1>));
  expect_size(bytes_of(capacity, "stop bounds, 256 cells") + bytes_of(capacity, "while they are made"),
              sizeof(std::array<StopCell, cells + 1>) + sizeof(std::array<MotionTriple, 5 * (cells + 1)>));
  expect_size(bytes_of(capacity, "playhead"), sizeof(Playhead));
}

TEST(Budget, HasRoomForThePiecesOfEveryExample) {
  for (const char* name : {"reveal", "nod", "paper_figure_4", "paper_figure_5", "paper_figure_6"}) {
    const Plan plan(read_move_file(in_checkout("examples/") + name + ".toml"), {}, {});
    for (const SolvedTrack& solved : plan.tracks()) {
      const Path& path = solved.track().path();
      for (const double delta : {1e-3, 1e-4, 1e-6, 1e-8, 1e-9}) {
        std::vector<ArcPiece> pieces(10'000);
        std::vector<double> begins(pieces.size());
        std::vector<std::int32_t> buckets(1);
        std::vector<std::int32_t> first_pieces(static_cast<std::size_t>(path.segment_count()) + 1);
        std::vector<TwoSum> segment_begins(first_pieces.size());
        const auto inverse =
            ArcLength::make(path, {.delta = delta}, {pieces, begins, buckets, first_pieces, segment_begins});
        ASSERT_TRUE(inverse);
        EXPECT_LE(inverse->piece_count(), usual_pieces_per_segment(delta) * path.key_count())
            << name << " at " << delta;
      }
      const FittedTrajectory fitted(solved.track());
      const std::int64_t usual =
          usual_trajectory_pieces(path.segment_count(), solved.track().profile().span_count());
      const std::vector<double> counts_per_unit(fitted->axis_count(), 1000);
      EXPECT_LE(static_cast<std::int64_t>(fitted->pieces().size()), usual) << name;
      EXPECT_LE(static_cast<std::int64_t>(*CountTrajectory::piece_count(*fitted, counts_per_unit)), usual)
          << name;
    }
  }
}

#ifndef INBETWEEN_SANITIZED  // a sanitizer has an allocator of its own, which mallinfo2() does not know
TEST(Budget, CoversTheHeapThatTheExampleTakes) {
  const Plan plan(read_move_file(in_checkout("examples/reveal.toml")), {}, {});
  const MoveTrack& move = plan.move().tracks.front();
  const Track& track = plan.tracks().front().track();
  std::vector<double> keys;
  for (const MoveKey& key : move.keys) keys.insert(keys.end(), key.at.begin(), key.at.end());
  const TrackSpec spec{.path = {.spline = track.path().spline(),
                                .axis_count = track.path().axis_count(),
                                .keys = keys,
                                .weights = track.path().weights()},
                       .control_values = plan.tracks().front().control_values(),
                       .frames = track.frames(),
                       .fps = track.frame_rate(),
                       .arc_length = {}};
  std::int64_t taken = 0;
  std::jthread(
      [&] {  // a thread of its own has no blocks that earlier tests gave back and malloc still counts as used
        { const std::vector<int> first(1); }
        const std::size_t before = mallinfo2().uordblks;
        const SolvedTrack solved(spec, Solver::closed_form);
        taken = static_cast<std::int64_t>(mallinfo2().uordblks - before);
      })
      .join();
  const BudgetCapacity capacity{.keys = static_cast<std::int32_t>(move.keys.size()),
                                .axes = spec.path.axis_count,
                                .control_values = static_cast<std::int32_t>(spec.control_values.size()),
                                .frames = spec.frames};
  // The control values, and at most 24 bytes for the allocator with each of about 15 vectors.
  const std::int64_t besides = 8 * static_cast<std::int64_t>(spec.control_values.size()) + 15 * 24;
  const std::int64_t budget = bytes_of_track(capacity) + bytes_of(capacity, "frame table");
  EXPECT_LE(taken, budget + besides);
  EXPECT_GE(2 * taken, budget);  // this path is one of few pieces, and open
}
#endif

}  // namespace budget_command_test
}  // namespace inbetween
