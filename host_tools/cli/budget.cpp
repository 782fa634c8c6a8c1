#include "host_tools/cli/budget.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "host_tools/text/diagnostics.hpp"
#include "inbetween/can/bus_load.hpp"
#include "inbetween/can/cia402_port.hpp"
#include "inbetween/limits/roll.hpp"
#include "inbetween/limits/stop_bounds.hpp"
#include "inbetween/play/playhead.hpp"
#include "inbetween/timing/frame_table.hpp"
#include "inbetween/timing/key_timing.hpp"
#include "inbetween/timing/track.hpp"
#include "inbetween/trajectory/count_trajectory.hpp"

namespace inbetween {
namespace {

/// The elements of the memories, counted.
struct ElementCounts {
  std::int64_t cubics, axes, pieces, segments, spans, rows, locks, fitted;
};

ElementCounts element_counts(const BudgetCapacity& capacity) {
  ElementCounts n{};
  // A closed path of as many keys has one segment more than an open one.
  n.segments = capacity.keys;
  n.axes = capacity.axes;
  n.cubics = (n.segments + 1) * n.axes;
  n.pieces = n.segments * usual_pieces_per_segment(capacity.delta);
  n.spans = std::max(capacity.control_values - 1, 1);
  n.rows = static_cast<std::int64_t>(capacity.frames) + 1;
  n.locks = capacity.locks;
  n.fitted = usual_trajectory_pieces(n.segments, n.spans);
  return n;
}

/// The sizes in the order of object_names.
std::array<std::int64_t, budget_object_count> bytes(const BudgetCapacity& capacity) {
  const ElementCounts n = element_counts(capacity);
  constexpr auto size = [](std::size_t bytes) { return static_cast<std::int64_t>(bytes); };
  const std::int64_t real = size(sizeof(double));
  const std::int64_t two_sum = size(sizeof(TwoSum));
  const std::int64_t index = size(sizeof(std::int32_t));
  const auto locks = static_cast<std::size_t>(n.locks);
  const auto numbers_of_rows = static_cast<std::int64_t>(
      lock_weight_count(locks, static_cast<std::size_t>(n.spans) + 1) + lock_entry_count(locks));
  std::array<std::int64_t, budget_object_count> result{
      n.cubics * size(sizeof(Cubic)) + n.axes * real,
      n.pieces * (size(sizeof(ArcPiece)) + real + index) + (n.segments + 1) * (index + two_sum),
      n.spans * size(sizeof(SpeedSpan)) + (n.spans + 1) * two_sum,
      (n.spans + 1) * size(sizeof(SpanDistance)),
      (n.locks + 1) * size(sizeof(Portion)),
      4 * (n.spans + 1) * real + (n.locks + 2) * size(sizeof(KeyLock)) +
          (n.locks + 1) * (5 * real + size(sizeof(LockRow))) + numbers_of_rows * real,
      n.segments * size(sizeof(KeyInterval)),
      n.rows * size(sizeof(PathPoint)),
      n.fitted * (size(sizeof(TrajectoryPiece)) + index) +
          (n.fitted + n.segments + n.spans + 1) * 4 * n.axes * real,
      n.fitted * (size(sizeof(CountTrajectoryPiece)) + n.axes * size(sizeof(CountPolynomial))),
      2 * n.axes * size(sizeof(RollAxis)),
      (budget_stop_cells + 1) * size(sizeof(StopCell)),
      n.axes * (budget_stop_cells + 1) * size(sizeof(MotionTriple)),
      size(sizeof(Playhead)),
      n.axes * size(sizeof(can::Cia402Drive)),
      size(sizeof(can::Cia402Bus)) +
          n.axes * size(sizeof(can::Cia402Axis) + sizeof(can::PortDrive) + sizeof(std::int32_t)) +
          size(can::frames_per_read(static_cast<std::size_t>(n.axes)) * sizeof(can::Frame)),
  };
  if (n.locks == 0) result[4] = result[5] = 0;
  return result;
}

constexpr std::array<std::string_view, budget_object_count> object_names{
    "path",
    "arc length",
    "speed profile",
    "track",
    "  with breaks at the locked keys, more",
    "  adjusted to the locked keys, more",
    "  timed by frames instead, more",
    "frame table",
    "trajectory",
    "its counts",
    "pre-roll and post-roll",
    "stop bounds, 256 cells",
    "  while they are made, more",
    "playhead",
    "CiA 402 drives, one for each axis",
    "  their CAN bus, with its frames"};

// These solve a move, or every tick calls them: the stack of another function is in neither of these.
constexpr std::array<FunctionBudget, 19> stack{{
    {"ArcLength::make", 2880, 3200},
    {"adjust_to_locks", 832, 1408},
    {"Track::make", 640, 672},
    {"closed_form_table", 1408, 1728},
    {"bound_move", 5536, 6080},
    {"StopBounds::make", 672, 864},
    {"Track::positions", 192, 480},
    {"Track::motion", 704, 960},
    {"fit_trajectory", 3680, 4072},
    {"Trajectory::positions", 448, 672},
    {"CountTrajectory::make", 1128, 1408},
    {"CountTrajectory::counts", 48, 48},
    {"Playhead::tick", 768, 864},
    {"supervise", 32, 32},
    {"StepGenerator::advance", 1408, 1600},
    {"StepMerge::merge", 2240, 2240},
    {"Cia402Drive::make", 8192, 8192},
    {"Cia402Bus::tick", 416, 416},
    {"Cia402Bus::receive", 288, 288},
}};

constexpr std::array<FunctionBudget, 6> programs{{
    {"reveal_firmware(flash)", 124'000, 178'000},
    {"reveal_firmware(ram)", 98'000, 98'000},
    {"reveal_firmware(stack)", 4300, 4650},
    {"play_table(flash)", 16'000, 18'200},
    {"play_table(ram)", 800, 800},
    {"play_table(stack)", 256, 256},
}};

// CountTrajectory::counts is asked for in 140 on a Cortex-M7 and 130 on a Cortex-M4F.
constexpr std::array<FunctionBudget, 16> instructions{{
    {"fit_trajectory", 1'200'000, 29'500'000},
    {"CountTrajectory::make", 890'000, 14'700'000},
    {"Trajectory::positions", 310, 7450},
    {"CountTrajectory::counts", 76, 76},
    {"CountTrajectory::counts(longest)", 76, 76},
    {"Track::positions", 170, 4000},
    {"Track::motion", 520, 15'700},
    {"frame_time_of_tick", 74, 820},
    {"frame_time_of_tick(float)", 74, 74},
    {"solve", 180'000, 6'900'000},
    {"Playhead::tick", 210, 1500},
    {"Playhead::tick(ramps)", 1150, 16'000},
    {"bound_move", 3'000'000, 60'500'000},
    {"StopBounds::make", 225'000, 5'000'000},
    {"reveal_firmware(tick)", 170, 170},
    {"play_table(tick)", 420, 4700},
}};

std::string number(std::int64_t value) {
  return value > 0 ? std::to_string(value) : "-";
}

void print_limits(std::span<const FunctionBudget> limits, std::FILE* out) {
  fmt::print(out, "  {:<40}{:>12}{:>12}\n", "", "Cortex-M7", "Cortex-M4F");
  for (const FunctionBudget& limit : limits)
    fmt::print(out, "  {:<40}{:>12}{:>12}\n", limit.name, limit.cortex_m7, limit.cortex_m4f);
}

can::BusUse bus_use(const BudgetCapacity& capacity, std::int64_t bitrate) {
  return {.bitrate = bitrate, .rate_hz = capacity.rate_hz, .drives = capacity.axes};
}

void print_buses(const BudgetCapacity& capacity, std::FILE* out) {
  const auto drives = static_cast<std::size_t>(capacity.axes);
  const std::size_t cyclic = 2 * drives + 1;
  fmt::print(out, "\nCAN bus with {} at {} Hz (--axes, --rate):\n", counted(capacity.axes, "CiA 402 drive"),
             capacity.rate_hz);
  fmt::print(out, "  frames in every tick: {} (SYNC, and of each drive a setpoint and a feedback)\n", cyclic);
  fmt::print(out,
             "  and at most: {} (besides, the heartbeat of the program, one message of set-up, and of each "
             "drive a\n"
             "    question and an answer whether it lives; the answer to the set-up, and emergencies)\n",
             can::Cia402Bus::frames_per_tick(drives) + 3 * drives + 1);
  fmt::print(out, "  {:<28}{:>24}{:>24}\n", "bit/s", "load at worst, %", "drives that fit");
  for (const BusBudget& bus : bus_budgets(capacity)) {
    fmt::print(out, "  {:<28}{:>24.1f}{:>24}\n", bus.bitrate, bus.load_percent, bus.max_drives);
  }
  fmt::print(out, "  at most {} % may be used; a rig that needs more is refused\n",
             can::bus_load_limit_percent);
}

}  // namespace

std::array<BusBudget, budget_bitrates> bus_budgets(const BudgetCapacity& capacity) {
  std::array<BusBudget, budget_bitrates> buses;
  constexpr std::array<std::int64_t, budget_bitrates> bitrates{125'000, 250'000, 500'000, 1'000'000};
  for (std::size_t i = 0; i < buses.size(); ++i) {
    const can::BusUse use = bus_use(capacity, bitrates.at(i));
    buses.at(i) = {.bitrate = use.bitrate,
                   .load_percent = static_cast<double>(can::bus_load_per_mille(use)) / 10,
                   .max_drives = can::max_drives(use)};
  }
  return buses;
}

std::span<const FunctionBudget> stack_limits() {
  return stack;
}

std::span<const FunctionBudget> program_limits() {
  return programs;
}

std::span<const FunctionBudget> instruction_limits() {
  return instructions;
}

std::int64_t usual_trajectory_pieces(std::int64_t segments, std::int64_t spans) {
  return 20 * segments + 4 * spans;
}

std::int32_t usual_pieces_per_segment(double delta) {
  // Septic interpolation: the error of the speed falls with the seventh power of the length of a piece. At a
  // coarse delta it falls more slowly, because a piece is then as long as a turn of the path.
  const double exponent = delta < 1e-6 ? 1.0 / 7 : 0.08;
  return static_cast<std::int32_t>(std::ceil(26 * std::pow(1e-6 / delta, exponent)));
}

std::array<BudgetObject, budget_object_count> budget_objects(const BudgetCapacity& capacity) {
  const auto sizes = bytes(capacity);
  std::array<BudgetObject, budget_object_count> objects;
  for (std::size_t i = 0; i < objects.size(); ++i) objects[i] = {object_names[i], sizes[i]};
  return objects;
}

void print_budget(const BudgetCapacity& capacity, std::FILE* out) {
  fmt::print(out, "Memory in bytes for {}, {} {}, {}, {}, {}:\n", counted(capacity.keys, "key"),
             capacity.axes, capacity.axes == 1 ? "axis" : "axes",
             counted(capacity.control_values, "control value"), counted(capacity.frames, "frame"),
             counted(capacity.locks, "locked key"));
  fmt::print(out, "  {:<40}{:>12g}\n", "with a speed error (delta) of", capacity.delta);
  fmt::print(out, "  {:<40}{:>12}\n", "and as many pieces a segment, as a rule",
             usual_pieces_per_segment(capacity.delta));
  for (const BudgetObject& object : budget_objects(capacity))
    fmt::print(out, "  {:<40}{:>12}\n", object.name, number(object.bytes));
  fmt::print(out, "\nStack of a function with all that it calls, at most, in bytes:\n");
  print_limits(stack_limits(), out);
  fmt::print(out, "\nInstructions for three axes, on average over a move, at most:\n");
  print_limits(instruction_limits(), out);
  fmt::print(out, "\nPrograms that play a move of three axes (examples/firmware), at most, in bytes:\n");
  print_limits(program_limits(), out);
  print_buses(capacity, out);
}

}  // namespace inbetween
