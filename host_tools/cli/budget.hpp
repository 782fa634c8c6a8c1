#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string_view>

#include "inbetween/base/precision.hpp"

/// The resources that the core takes of a machine: bytes of memory, bytes of stack, instructions per tick.

namespace inbetween {

/// The size of the largest move that the memory is for.
struct BudgetCapacity {
  std::int32_t keys = 8;
  std::int32_t axes = 3;
  std::int32_t control_values = 10;  ///< of the curve that is played: locked keys may refine the drawn one
  std::int32_t frames = 240;
  double delta = Precision::default_delta;
  std::int32_t locks = 0;      ///< keys that must be met on a frame
  std::int32_t rate_hz = 250;  ///< ticks of a CAN bus
};

/// The largest sizes that `budget` accepts (delta excluded). It accepts every move that the reader of moves
/// accepts.
inline constexpr BudgetCapacity largest_budget{.keys = 10'000,
                                               .axes = 64,
                                               .control_values = 100'000,
                                               .frames = 1'000'000,
                                               .delta = 0.1,
                                               .locks = 10'000,
                                               .rate_hz = 10'000};

/// The size of one object of the core, in bytes; 0 where the move has none.
struct BudgetObject {
  std::string_view name;
  std::int64_t bytes = 0;
};

inline constexpr std::size_t budget_object_count = 16;

/// The number of cells into which the time line is cut for the bounds of stops.
inline constexpr std::int64_t budget_stop_cells = 256;

/// The memory of every object of the core that its caller provides. Elements have the same size on x86-64,
/// arm64 and Cortex-M (held by Embedded.CortexM7HasTheBitsOfThisMachine and its neighbours). The inverse has
/// usual_pieces_per_segment() pieces a segment, a trajectory usual_trajectory_pieces(). Rolls, stop bounds
/// and playhead are those of a move of one track. The playhead is an object itself and holds two pointers: on
/// a Cortex-M it takes 8 bytes less. So do drives and their bus, which hold pointers and lengths.
std::array<BudgetObject, budget_object_count> budget_objects(const BudgetCapacity& capacity);

/// The number of pieces that the trajectory of a smooth path at a drawn speed usually takes, and its counts.
/// It suffices for every example. The core says how many it needs.
std::int64_t usual_trajectory_pieces(std::int64_t segments, std::int64_t spans);

/// The number of pieces that the inverse of arc length usually takes for a segment, averaged over a path. It
/// suffices for every example and, at the default delta, for three of four smooth paths through random keys.
/// Paths that turn sharply at every key take up to four times as many. The core says how many it needs.
std::int32_t usual_pieces_per_segment(double delta);

/// The limits of a function on two processors. scripts/measure-budget measures the function, and a test
/// (tests/embedded/budget_test.cpp) holds the measured values below the limits.
struct FunctionBudget {
  std::string_view name;
  std::int32_t cortex_m7 = 0;   ///< with a unit for double precision
  std::int32_t cortex_m4f = 0;  ///< with one for single precision
};

/// Worst stack in bytes, with all that is called: of what every tick calls and of what solves a move.
std::span<const FunctionBudget> stack_limits();
/// The two programs of examples/firmware, which play examples/reveal.toml on three axes: reveal_firmware
/// solves it, play_table has it as a table. Bytes of flash (code and constants), of RAM (without the stack),
/// and of stack.
std::span<const FunctionBudget> program_limits();
/// Instructions for three axes: for a tick, and for the time of a tick's number; of a program all that it
/// does in a tick but for the sending. Once per move of 8 keys and 7 control values: for solving it (solve:
/// path to track), for cutting it into counts, and for bounding its stops.
std::span<const FunctionBudget> instruction_limits();

/// The frames and the worst-case load of a CAN bus with a CiA 402 drive for each axis.
struct BusBudget {
  std::int64_t bitrate = 0;
  double load_percent = 0;
  std::int64_t max_drives = 0;  ///< within the load that may be used
};
inline constexpr std::size_t budget_bitrates = 4;
std::array<BusBudget, budget_bitrates> bus_budgets(const BudgetCapacity& capacity);

/// Prints memory, stack, instructions and the load of a bus as tables for people.
void print_budget(const BudgetCapacity& capacity, std::FILE* out);

}  // namespace inbetween
