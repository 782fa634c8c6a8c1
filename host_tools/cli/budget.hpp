#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <span>
#include <string_view>

/// What the core takes of a machine: bytes of memory, bytes of stack, instructions per tick.

namespace inbetween {

/// A move as large as the memory must be for.
struct BudgetCapacity {
  std::int32_t keys = 8;
  std::int32_t axes = 3;
  std::int32_t control_values = 10;  ///< of the curve that is played: locked keys may refine the drawn one
  std::int32_t frames = 240;
  std::optional<double> delta = {};  ///< absent: the default of each precision
  std::int32_t locks = 0;            ///< keys that must be met on a frame
};

/// The largest that are told, delta excluded; what the reader of moves takes is never refused.
inline constexpr BudgetCapacity largest_budget{.keys = 10'000,
                                               .axes = 64,
                                               .control_values = 100'000,
                                               .frames = 1'000'000,
                                               .delta = 0.1,
                                               .locks = 10'000};

/// One object of the core, in bytes. Absent: there is none in that precision.
struct BudgetObject {
  std::string_view name;
  std::optional<std::int64_t> in_double;
  std::optional<std::int64_t> in_float;
};

inline constexpr std::size_t budget_object_count = 14;

/// Into so many cells the time line is cut where the bounds of stops are told.
inline constexpr std::int64_t budget_stop_cells = 256;

/// The memory of every object of the core that its caller provides. Elements have the same size on x86-64,
/// arm64 and Cortex-M (Embedded.CortexM7HasTheBitsOfThisMachine and its neighbours hold it). The number of
/// pieces of the inverse is usual_pieces_per_segment() a segment. A count track in single precision is one of
/// a track in double, which is how it is within 0.1 counts. Rolls, stop bounds and playhead are those of a
/// move of one track. The playhead is an object itself and holds two pointers: on a Cortex-M it takes 8 bytes
/// less.
std::array<BudgetObject, budget_object_count> budget_objects(const BudgetCapacity& capacity);

/// How many pieces a segment the inverse of arc length takes as a rule, on the average of a path's segments:
/// enough for every example and, at the default delta, for three of four smooth paths through random keys;
/// paths with a sharp bend at every key take up to four times as many. The core says how many it needs.
std::int32_t usual_pieces_per_segment(double delta);

/// What something may take at most on one processor. 0: it is not measured.
struct BudgetLimit {
  std::int32_t in_double = 0;
  std::int32_t in_float = 0;
};

/// The limits of a function; scripts/measure-budget measures what they are about, and a test
/// (tests/embedded/budget_test.cpp) holds the measured values below the limits.
struct FunctionBudget {
  std::string_view name;
  BudgetLimit cortex_m7;
  BudgetLimit cortex_m4f;
};

/// Worst stack in bytes, with all that is called: of what every tick calls and of what solves a move.
std::span<const FunctionBudget> stack_limits();
/// Instructions for three axes: of a tick and of a time from a tick's number; and, once per move of 8 keys
/// and 7 control values, of solving it (solve: path to track), of cutting it into counts and of bounding its
/// stops.
std::span<const FunctionBudget> instruction_limits();

/// The three as tables for people.
void print_budget(const BudgetCapacity& capacity, std::FILE* out);

}  // namespace inbetween
