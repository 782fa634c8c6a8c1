#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "motion_enclosure.hpp"
#include "time_pieces.hpp"

namespace inbetween {

/// How often branch and bound halves a part of a stretch.
struct HalvingLimits {
  std::int32_t max = 0;              ///< a part halved so often is given as it is
  std::int32_t before_rounding = 0;  ///< from here on most of the width of a bound can be rounding
};

/// Bounds the motion of every axis of a track on a part of a stretch by branch and bound: a box is halved
/// for the axes whose bounds are not close enough on it. `rules` decides:
/// - take(group, open, range, frame): takes what the motion of the open axes of a group is at a point of the
///   box, and the bounds on it of those whose bounds are all close enough; returns the bits of the others;
/// - allowed(d, i): the highest bound of quantity i of axis d that is close enough;
/// - accept(d, bounds, frame): takes the bounds on a box.
template <HalvingLimits halvings, Precise Real, class Rules>
void branch_and_bound(const MotionEnclosure<Real>& enclosure, const StretchWalk<Real>& walk,
                      const Stretch<Real>& stretch, const MotionBox<Real>& part, std::size_t axes,
                      Rules& rules) {
  // Each begins where the one on top of it ends.
  struct Box {
    Real end = 0, tau_end = 0;
    std::uint64_t open = 0;  ///< axes whose bounds are not close enough yet
    std::int32_t halved = 0;
  };
  // Halving does not help any more where rounding alone, at the very point and with that of the place at a
  // time, takes the bound half as far.
  const auto is_rounding = [&](std::size_t d, const MotionTriple<Real>& bounds, const MotionBox<Real>& box) {
    const MotionTriple<Real> floor = enclosure.range(d, enclosure.around(stretch, box.middle())).bound;
    for (std::size_t i = 0; i < motion_quantities; ++i) {
      const Real allowed = rules.allowed(d, i);
      if (!(bounds[i] <= allowed) && !(bounds[i] <= 2 * floor[i] && floor[i] > allowed)) return false;
    }
    return true;
  };
  std::array<Box, static_cast<std::size_t>(halvings.max) + 2> stack;
  std::size_t count = 0;
  stack[count++] = {part.end, part.tau_end,
                    axes < max_bounded_axes ? (std::uint64_t{1} << axes) - 1 : ~std::uint64_t{0}, 0};
  MotionBox<Real> box{.begin = part.begin, .tau_begin = part.tau_begin};
  while (count > 0) {
    const Box next = stack[--count];
    box.end = next.end;
    box.tau_end = next.tau_end;
    box.x = stretch.divide(box.begin, box.end);
    box.tau = walk.tau_at(stretch, box.x);
    const MotionSurroundings<Real> surroundings = enclosure.around(stretch, box);
    const bool is_last = next.halved >= halvings.max || box.x <= box.begin || box.x >= box.end;
    const Real frame = stretch.time.frame(box.x);
    std::uint64_t open = 0;
    const auto take = [&](std::size_t group, std::uint64_t bits, const MotionRange<Group<Real>>& range) {
      bits = rules.take(group, bits, range, frame);
      for (std::size_t d = group * group_size; bits != 0; ++d, bits >>= 1) {
        if ((bits & 1) == 0) continue;
        const MotionTriple<Real> bounds = lane_of<Real>(range.bound, d % group_size);
        if (is_last || (next.halved >= halvings.before_rounding && is_rounding(d, bounds, box))) {
          rules.accept(d, bounds, frame);
        } else {
          open |= std::uint64_t{1} << d;
        }
      }
    };
    enclosure.ranges(next.open, surroundings, take);
    if (open == 0) {
      box.begin = box.end;
      box.tau_begin = box.tau_end;
      continue;
    }
    stack[count++] = {box.end, box.tau_end, open, next.halved + 1};
    stack[count++] = {box.x, box.tau, open, next.halved + 1};
  }
}

}  // namespace inbetween
