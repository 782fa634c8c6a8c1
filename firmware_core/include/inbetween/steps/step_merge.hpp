#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/base/fixed_vector.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/steps/edge_instant.hpp"
#include "inbetween/steps/step_generator.hpp"

/// Merges the edges of all axes of one chip into instants. At each instant one call sets all lines that
/// change.

namespace inbetween {

/// The lines of one axis by their number in the request, 0..63, and the timing that its edges keep.
struct StepLines {
  std::int32_t step = 0;
  std::int32_t dir = 0;
  StepTiming timing;
};

/// Puts the edges of the axes of a chip in order.
///
/// Edges at the same time share an instant. Edges that are at most a grain apart share one too, if the
/// minimum times of every axis permit it: an earlier edge is delayed until the later one, by at most the
/// grain. The last edge of an axis in a tick, and the last fall of its STEP, are never delayed, because the
/// first edge of the next tick may follow them as closely as the minimum times permit. So every tick stands
/// by itself, and nothing is kept between ticks. A grain of 0 moves no edge.
///
/// The choice is greedy: the earliest edge waits for all that it can wait for. No allocation.
class StepMerge {
 public:
  static constexpr std::size_t max_axes = 32;  ///< two lines each of the 64 of a request

  /// Errors: wrong_count (no axis); capacity (more than max_axes); out_of_range with `axis` (a line not from
  /// 0 to 63, or of two uses; a negative grain).
  static Result<StepMerge> make(std::span<const StepLines> axes, std::int64_t grain_ns = 0);

  /// The instants of a tick that starts at `start_ns`, in the order of time; returns how many. `edges` has an
  /// entry for every axis: what StepGenerator::advance() wrote. `out` needs one instant an edge at most.
  /// Errors: wrong_count (entries of `edges`); out_of_range with `axis` (edges out of order, or nearer
  /// to each other than the timing of the axis); capacity (`out`; `needed` always suffices). Then
  /// `out` means nothing.
  /// Cost: O(axes) an instant; with a grain, a little more an edge.
  Result<std::size_t> merge(std::int64_t start_ns, std::span<const std::span<const StepEdge>> edges,
                            std::span<EdgeInstant> out) const;

 private:
  StepMerge() = default;

  FixedVector<StepLines, max_axes> axes_;
  std::int64_t grain_ns_ = 0;
};

}  // namespace inbetween
