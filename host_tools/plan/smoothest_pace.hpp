// The smoothest speed along a path that meets every key on its frame.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace inbetween {

struct PaceSpec {
  std::span<const double>
      key_distances;  ///< from the start to each key, rising; the first 0, the last above 0
  std::span<const std::int32_t> key_frames;  ///< of each of them, rising: the first 0, the last N
  bool rests_at_start = true;
  bool rests_at_end = true;
  /// Inner keys, in order, at which the speed touches 0: three control values in a row are 0 there.
  std::span<const std::int32_t> touches = {};
};

/// Control values of a speed curve, the largest 100: phi >= 0, the integral between two keys is their
/// distance's share of the whole, and the integral of phi''^2 is the least of all such curves. Between keys
/// in one place, and at ends that rest, neighbouring control values are 0. At other ends phi'' is 0.
/// Without rests and with two keys every even change of speed is as smooth: the speed stays the same.
///
/// The curve has four spans in the shortest time between two keys, and as many more as it takes for every
/// touch to lie on a knot, up to 2048 control values.
///
/// Method: a convex quadratic program in the control values, whose unknowns are their running sums, so that
/// every key is a condition on four or five neighbours (BandProgram). Cost: tens of iterations, each linear
/// in the number of control values. Accuracy: every key within 1e-11 of the length.
///
/// Throws SolverError, with the key, where no curve of so many control values meets the frames, or where a
/// touch cannot lie on a knot.
std::vector<double> smoothest_pace(const PaceSpec& spec);

}  // namespace inbetween
