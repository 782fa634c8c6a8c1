// Rows over frames as few keys on frames, whose smooth curves over time pass all rows within a tolerance.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace inbetween {

/// Where some axes are on each frame.
struct RowsOnFrames {
  std::vector<std::vector<double>> rows;  ///< of each axis on the frames 0..N; all of one length, 2 at least
  std::vector<double> tolerances;         ///< of each axis, above 0
};

/// Keys of a track with timing = "frames", spline = "smooth" and kinetic = "curves".
struct KeysOnFrames {
  std::vector<std::int32_t> frames;     ///< rising, the first 0, the last N
  std::vector<std::vector<double>> at;  ///< of each key, the axes
  bool rests_at_start = true;
  bool rests_at_end = true;
  double worst = 0;  ///< the largest miss of a row, as a share of the tolerance of its axis
};

/// The fewest keys that are found: one more where the curves are farthest, then one less as long as the rest,
/// moved by whole frames, can do without it. An axis rests at an end where its rows do. Where all axes stay
/// for `min_hold` frames or more, a key on either side makes them rest.
///
/// Curves are cubic splines with the keys as knots, by least squares (de Boor, A Practical Guide to Splines,
/// ch. XIV), whose weights grow where they are farthest (Lawson 1961), which leads to the least largest miss.
/// With a key on every frame nothing is missed. Cost: about 10 us for each row and key of up to 64 keys, and
/// 0.2 ms for each further key.
KeysOnFrames keys_on_frames(const RowsOnFrames& rows, std::int32_t min_hold,
                            const std::function<void(double share)>& progress);

/// Whether rows rest at their first frame: they leave it ever faster, as an ease does.
bool rows_rest_at_start(std::span<const double> rows);

}  // namespace inbetween
