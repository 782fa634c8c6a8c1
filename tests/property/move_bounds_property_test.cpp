#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "tests/support/bounded_cells.hpp"
#include "tests/support/oracle_limits.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random_move.hpp"
#include "tests/support/solved_move.hpp"
#include "tests/support/trajectory_noise.hpp"

/// The proven bounds of every axis against a dense search of the exact motion in long double.

namespace inbetween {
namespace move_bounds_property_test {

constexpr int many_moves = 2000;
/// Refined at the peaks; 1571 samples find nothing more (OracleLimits.RefinementFindsNothingMore).
constexpr int samples = 300;
constexpr double fps = 24;

/// The whole of a move in every other case, otherwise any part of it. Not one that begins or ends on a key as
/// closely as nobody can tell on which side: MoveBounds.AKeyOnTheFirstOrLastFrameOfAPartHasOneSide
/// holds those.
WholeFrames any_part(const RandomMove& move, const oracle::IdealMotion& ideal) {
  const auto any_int = [](int from, int below) {
    return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(from, below));
  };
  if (move.frames < 2 || any_int(0, 2) == 0) return {0, move.frames};
  const int first = any_int(0, move.frames);
  const WholeFrames part{first, any_int(first + 1, move.frames + 1)};
  for (int key = 1; key < ideal.path().segments(); ++key) {
    const long double met = ideal.key_frame(key);
    if (std::fabs(met - part.first) < 1e-3L || std::fabs(met - part.last) < 1e-3L) return {0, move.frames};
  }
  return part;
}

/// Whether all keys of several axes lie on one line, so that nothing turns anywhere. There the oracle takes
/// products of axes from each other that are equal but for their rounding, and where the path nearly stands
/// still it divides what is left by next to nothing: its acceleration across the line can be anything.
bool is_on_a_line(const RandomMove& move) {
  const std::vector<std::vector<long double>>& at = move.keys.at;
  if (at[0].size() < 2) return false;
  const auto chord = [&](std::size_t key, std::size_t d) { return at[key][d] - at[0][d]; };
  for (std::size_t i = 1; i < at.size(); ++i) {
    for (std::size_t d = 0; d < at[0].size(); ++d) {
      for (std::size_t e = 0; e < d; ++e) {
        const long double across = chord(1, d) * chord(i, e);
        const long double along = chord(1, e) * chord(i, d);
        if (std::fabs(across - along) > 1e-18L * (std::fabs(across) + std::fabs(along))) return false;
      }
    }
  }
  return true;
}

/// true <= bound <= max_ratio * true, apart from what is rounding of the quickest axis; on a line of several
/// axes the upper half of it.
/// `share`: so near is what plays to what is asked. `noise`: what the rounding of positions adds to
/// it; asked only where that decides.
void expect_tight(const char* what, double bound, const oracle::Extreme& found, long double quickest,
                  long double max_ratio, bool on_a_line, long double share,
                  const std::function<double()>& noise) {
  RC_LOG() << what << ": bound " << bound << ", found " << static_cast<double>(found.value) << " at frame "
           << static_cast<double>(found.place) << ", of all axes " << static_cast<double>(quickest) << '\n';
  const bool is_resolved = max_ratio < 2;
  if (!on_a_line && is_resolved) {
    const long double least = found.value - ((bound == 0 ? 1e-9L : 1e-12L) + share) * quickest;
    RC_ASSERT(bound >= least || bound >= least - noise());
  }
  // Sharper than its shortest piece a trajectory does not turn: it says that there is no bound.
  if (!is_resolved && std::isinf(bound)) return;
  const long double most = max_ratio * found.value + 1e-8L * quickest;
  RC_ASSERT(bound <= most || bound <= most + noise());
}

/// How far the axis goes for each unit of the path's length, at most: on any frame if the length counts it,
/// otherwise on the first or the last. Where the move rests there, an axis that does not count goes anywhere.
long double steepest_at_ends(const oracle::IdealMotion& ideal, const WholeFrames& part, std::size_t axis) {
  const auto weight = [&](std::size_t d) { return ideal.path().weight(static_cast<int>(d)); };
  if (weight(axis) > 0) return 1 / weight(axis);
  long double steepest = 0;
  for (const auto& [frame, side] :
       {std::pair{part.first, oracle::Side::after}, std::pair{part.last, oracle::Side::before}}) {
    const std::vector<oracle::AxisState> states = ideal.at(frame, side);
    long double speed = 0;
    for (std::size_t d = 0; d < states.size(); ++d) speed = std::hypot(speed, weight(d) * states[d].velocity);
    const long double infinity = std::numeric_limits<long double>::infinity();
    steepest = std::max(steepest, speed > 0 ? std::fabs(states[axis].velocity) / speed : infinity);
  }
  return steepest;
}

TEST(MoveBoundsProperty, NoPeakIsAboveItsBoundAndNoBoundIsOnePercentAboveItsPeak) {
  long double worst = 0;
  int unresolved = 0;
  int compared = 0;
  int parts = 0;
  check_property(many_moves, [&] {
    const RandomMove move = *regular_move();
    show(move);
    const SolvedTrack solution = solve(move);
    if (solution.track().arc_length().total() == 0) return;
    const oracle::IdealMotion ideal(move.keys, oracle::Profile(move.speed), move.frames, fps);
    const WholeFrames part = any_part(move, ideal);
    RC_LOG() << "frames " << part.first << ".." << part.last << '\n';
    if (part.last - part.first < move.frames) ++parts;
    const oracle::Extremes extremes = ideal.extremes_between(part.first, part.last, samples);
    const BoundedMove bounded = bounds_of_track(solution.track(), part);
    const std::vector<AxisPeaks>& peaks = bounded.peaks();
    std::optional<FittedTrajectory> fitted;
    // In a second the speed curve has `rate` spans; what is 0 is computed to the rounding of what it could
    // be.
    const long double rate =
        static_cast<long double>(std::max<std::size_t>(move.speed.size(), 2) - 1) * fps / move.frames;
    const auto quickest = [&](oracle::Extreme oracle::AxisExtremes::*quantity, long double power) {
      long double largest = 0;
      for (const oracle::AxisExtremes& axis : extremes.axes) {
        largest = std::max({largest, (axis.*quantity).value, axis.velocity.value * power});
      }
      return largest;
    };
    // A turn in less than a ten-millionth of the move is felt in the rounding of positions and times: what
    // plays may turn otherwise there.
    const long double peak_seconds =
        quickest(&oracle::AxisExtremes::acceleration, 0) / quickest(&oracle::AxisExtremes::jerk, 0);
    const bool resolved = !(peak_seconds < 1e-7L * move.frames / fps);
    ++compared;
    if (!resolved) ++unresolved;
    const long double max_ratio = resolved ? 1.01L : 1e6L;
    const bool line = is_on_a_line(move);
    const long double length = ideal.path().total_length();
    for (std::size_t d = 0; d < peaks.size(); ++d) {
      const oracle::AxisExtremes& axis = extremes.axes[d];
      RC_LOG() << "axis " << d << '\n';
      const long double scale = std::max(std::fabs(axis.lowest.value), std::fabs(axis.highest.value));
      // Between keys the place on a frame is known to the fitted inverse of arc length, 1e-6 of the length.
      const bool is_whole = part.last - part.first == move.frames;
      const long double place = 1e-6L * length;
      // What plays is within 2^-30 of the distance of what is asked.
      const long double fit = 1.5L / (1 << 30) * (axis.highest.value - axis.lowest.value + length);
      const long double rounding =
          1e-13L * scale + fit + (is_whole ? 0 : place * steepest_at_ends(ideal, part, d));
      RC_ASSERT(std::fabs(peaks[d].lowest.value - axis.lowest.value) <= rounding);
      RC_ASSERT(std::fabs(peaks[d].highest.value - axis.highest.value) <= rounding);
      // The rounding of a position far from 0 is felt in the derivatives of what plays.
      const auto noise_of = [&](std::size_t derivative) -> std::function<double()> {
        return [&, derivative] {
          if (!fitted) fitted.emplace(solution.track());
          return noise_at_peaks(*fitted, d, peaks[d])[derivative];
        };
      };
      const long double v = axis.velocity.value;
      expect_tight("velocity", peaks[d].velocity.value, axis.velocity,
                   quickest(&oracle::AxisExtremes::velocity, 1), max_ratio, false, 1e-6L, noise_of(0));
      expect_tight("acceleration", peaks[d].acceleration.value, axis.acceleration,
                   quickest(&oracle::AxisExtremes::acceleration, rate), max_ratio, line, 1e-4L, noise_of(1));
      expect_tight("jerk", peaks[d].jerk.value, axis.jerk, quickest(&oracle::AxisExtremes::jerk, rate * rate),
                   max_ratio, line, 3e-3L, noise_of(2));
      const long double ratio = v > 0 ? peaks[d].velocity.value / v : 0;
      if (ratio > worst && noise_of(0)() < 1e-6L * v) worst = ratio;
    }
  });
  std::cout << "velocity at most " << static_cast<double>(worst) << " of the truth; in " << unresolved
            << " moves a peak is narrower than time is known; " << parts << " parts of moves\n";
  EXPECT_TRUE(!counts_mean_something() || parts >= compared / 5);
  EXPECT_LE(unresolved, compared / 8 + 3);
}

}  // namespace move_bounds_property_test
}  // namespace inbetween
