// A recorded motion, drawn by a hand or baked by another program, as keys and a speed curve: Baecker's
// P-curve (1969), whose path says where and whose pace says how fast.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace inbetween {

/// Nearly three minutes of a hand at 120 samples a second. Every step of the search for keys costs as many.
/// The fuzz target edit_request holds what the reader lets pass to it.
inline constexpr std::size_t max_motion_samples = 20'000;

/// Positions of the axes of one track, with noise.
struct SampledMotion {
  std::vector<double> times;      ///< s, from 0, rising; 8 at least
  std::vector<double> positions;  ///< time after time, in axis units
  /// One per axis, above 0: how far the path may be from where the axis was. Infinity: the axis does not
  /// count.
  std::vector<double> tolerances;
  std::vector<double> weights;  ///< of the track, one per axis
  double frames_per_second = 24;
  /// Positions of a program and not of a hand: without noise, so that what the tolerance leaves is all that
  /// may be missed.
  bool is_exact = false;
  /// Of exact positions: in keys and control values. With more there is no fit.
  std::size_t max_numbers = std::numeric_limits<std::size_t>::max();
};

/// A track with a smooth path. Distances are counted in tolerances: the root of the sum of squares over the
/// axes, each divided by its tolerance.
struct MotionFit {
  std::vector<std::vector<double>> keys;
  std::vector<double> speed;  ///< control values; the largest is 10
  std::int32_t frames = 1;    ///< the first whole number that is no shorter than the recording
  double noise = 0;           ///< root mean square of what was taken for noise, per axis that counts
  double deviation = 0;       ///< of the recorded positions from the path, the largest mean of three
  /// Root mean square, of the recorded distances along the path from those of the curve, as a share of its
  /// length.
  double lag = 0;
};

/// The motion without its noise: every axis over time is the integral of a uniform B-spline, by least
/// squares, with as many control values as the Bayesian information criterion grants (Schwarz 1978); it shows
/// how the path winds. The keys: KeyFit from a few of its points on, one key more at a time as long as the
/// same criterion gains by it. The speed curve: the least squares of the distance at which each sample lies
/// along that path, over control values that are not negative; how many, and whether it begins and ends at
/// rest, the criterion says. The path of a single axis goes through its turning points instead.
///
/// Of exact positions the first path, with a key more each time, and the first curve, with some control
/// values more each time, that keep the tolerance: keys, and then values, as few as are found.
///
/// Throws std::invalid_argument, one line, where there are too few samples or too many, a number is not
/// finite, times do not rise, nothing moves, or no path with `max_drawn_keys` keys keeps the tolerance.
/// Cost: some tens of milliseconds for a few seconds of hand; seconds for a scrawl that needs all keys.
MotionFit fit_motion(const SampledMotion& sampled);

/// More keys nobody edits by hand. A scrawl that needs all of them takes seconds.
inline constexpr std::size_t max_drawn_keys = 100;

}  // namespace inbetween
