#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/timing/speed_profile.hpp"

/// Keys that must be met on a frame, by the least change of the drawn speed curve.

namespace inbetween {

/// A request about when a key is met.
struct KeyLock {
  std::int32_t key = 0;
  std::int32_t frame = -1;  ///< -1: none, only for a hold; then where the drawn curve arrives
  std::int32_t hold = 0;    ///< frames that the rig rests at the key, from `frame` on
  bool breaks = false;      ///< the speed may jump here: each side keeps the drawn shape, with a K of its own
  /// The speed touches 0 here, with its derivative: three control values are 0, so the key is met on a knot
  /// of the curve. Without `frame` on the knot nearest to where the drawn curve arrives.
  bool ease = false;
  std::int16_t knot = -1;  ///< the answer: on which knot of the curve the speed touches 0
};

struct KeyTimingSpec {
  std::span<const double> control_values;  ///< as drawn, valid for SpeedProfile::make
  std::span<const double> key_distances;   ///< arc length from the start to each key; the last is the total
  std::span<const KeyLock> locks;          ///< in order of their keys
  std::int32_t frames = 0;                 ///< N
  /// The drawn curve has these ends. A periodic one stays so, and may touch 0 or rest at its seam, key 0.
  CurveEnds ends = CurveEnds::natural;
};

/// An equation of the adjustment: what the curve covers between two neighbouring locks.
struct LockRow {
  std::int32_t first =
      0;  ///< its first control value; of a periodic curve it may lie before the seam, below 0
  std::int32_t count = 0;    ///< of its control values
  std::int32_t weights = 0;  ///< where theirs begin in KeyTimingMemory::weights
  std::int32_t beside = 0;   ///< the first row that shares a control value with it
  std::int32_t entries =
      0;  ///< where its products with the rows from there on begin in KeyTimingMemory::matrix
};

/// A row reaches three control values beyond its spans on either side.
constexpr std::size_t lock_weight_count(std::size_t locks, std::size_t control_values) {
  return control_values + 6 * (locks + 1);
}
/// Between two rows that share a control value lie 11 control values at most: if there are more rows than
/// that between them, these follow from each other. At the seam of a periodic curve ten rows share control
/// values with all others.
constexpr std::size_t lock_entry_count(std::size_t locks) {
  const std::size_t rows = locks + 1;
  return std::min(rows * (rows + 1) / 2, 24 * rows);
}

/// The memory of the adjustment, owned by the caller. `locks` etc. are counts: the ends of the move are
/// two locks more.
struct KeyTimingMemory {
  std::span<double> adjusted;     ///< control values: the answer; its size bounds the refinement
  std::span<double> drawn;        ///< control values
  std::span<double> mobility;     ///< control values
  std::span<double> ceiling;      ///< control values
  std::span<KeyLock> locks;       ///< locks + 2
  std::span<double> targets;      ///< locks + 1
  std::span<double> multipliers;  ///< 4 * (locks + 1)
  std::span<LockRow> rows;        ///< locks + 1
  std::span<double> weights;      ///< lock_weight_count
  std::span<double> matrix;       ///< lock_entry_count
};

/// The changes of the drawn curve.
struct KeyTiming {
  std::span<const double> control_values;  ///< f + 1 of them, in KeyTimingMemory::adjusted
  std::span<const KeyLock> locks;      ///< the requests with every frame filled in, in KeyTimingMemory::locks
  std::int32_t refinements = 0;        ///< how often f was doubled (exactly, without changing the curve)
  double largest_change = 0;           ///< of a control value of the refined curve
  std::int32_t largest_change_at = 0;  ///< its index

  /// When a lock is met, in frames: a whole one unless it eases without a frame of its own.
  [[nodiscard]] double frame_of(const KeyLock& lock, std::int32_t frames) const {
    if (lock.knot < 0) return static_cast<double>(lock.frame);
    return static_cast<double>(lock.knot) * static_cast<double>(frames) /
           static_cast<double>(control_values.size() - 1);
  }
};

/// The control values x nearest to the drawn ones v, sum (x - v)^2 / w least, for which
/// Phi(a at the lock's frame) / Phi(f) is the key's share of the length, 0 <= x <= 100, and Phi between two
/// breaks is as drawn. Where the drawn curve stands still (is_rest) it goes on to. For a hold the drawn curve
/// is first brought to rest and back within one of its spans on either side. w is 1, so that the change is
/// the least in the ordinary sense, as long as the curve is not refined. On a refined curve w rises from 0 at
/// what stands still to 1 within one drawn span: otherwise all of the change would be piled up beside the
/// rests, and the rig would start with a jerk. If no such curve exists, the drawn one is refined, f -> 2 f,
/// up to the memory.
///
/// Method: the dual of the problem is smooth and concave in one multiplier per lock, x = clip(v + A^T
/// lambda); semismooth Newton steps (Qi and Sun 1993), each followed to where the dual is highest. A dual
/// value above the cost of every curve from 0 to 100 proves that there is none.
///
/// Accuracy: each lock is met within 1e-12 of the length.
///
/// Errors: out_of_range (no such key, a frame outside 0..N, the first key not on 0, the last not on N, order
/// reversed, two keys on one frame: with key and frame), no_solution (with a key that cannot be met; a key
/// that eases on a frame that is no knot), capacity.
///
/// Cost: linear in f and in the locks; tens of times as a rule, where there is no curve thousands of times.
Result<KeyTiming> adjust_to_locks(const KeyTimingSpec& spec, const KeyTimingMemory& memory);

template <std::size_t Locks, std::size_t Values>
struct KeyTimingStorage {
  std::array<double, Values> adjusted, drawn, mobility, ceiling;
  std::array<KeyLock, Locks + 2> locks;
  std::array<double, Locks + 1> targets;
  std::array<double, 4 * (Locks + 1)> multipliers;
  std::array<LockRow, Locks + 1> rows;
  std::array<double, lock_weight_count(Locks, Values)> weights;
  std::array<double, lock_entry_count(Locks)> matrix;

  [[nodiscard]] KeyTimingMemory memory() {
    return {adjusted, drawn, mobility, ceiling, locks, targets, multipliers, rows, weights, matrix};
  }
};

}  // namespace inbetween
