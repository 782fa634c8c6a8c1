#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <limits>
#include <vector>

#include "host_tools/plan/fitted_trajectory.hpp"
#include "inbetween/trajectory/bounds.hpp"
#include "tests/support/bounded_cells.hpp"
#include "tests/support/count_trajectory.hpp"
#include "tests/support/exact_piece.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random_move.hpp"
#include "tests/support/solved_move.hpp"
#include "tests/support/trajectory_noise.hpp"

/// What plays against what is asked, and its certificate against a dense search and the one of the track.

namespace inbetween {
namespace trajectory_property_test {

constexpr int many_moves = 1000;

/// Whether no peak is so narrow, beside a near-cusp, that it is passed in a few of the last digits of
/// positions and times: a ten-millionth of the move.
bool is_resolved(const Track& track, const std::vector<AxisPeaks>& peaks) {
  double acceleration = 0;
  double jerk = 0;
  for (const AxisPeaks& axis : peaks) {
    acceleration = std::max(acceleration, axis.acceleration.value);
    jerk = std::max(jerk, axis.jerk.value);
  }
  return acceleration >= 1e-7 * track.frames() / 24.0 * jerk;
}

TEST(TrajectoryProperty, WhatPlaysIsWithinTheTolerancesOfWhatIsAsked) {
  std::size_t most = 0;
  check_property(many_moves, [&] {
    const RandomMove move = *regular_move();
    show(move);
    const SolvedTrack solved = solve(move);
    const Track& track = solved.track();
    if (track.arc_length().total() == 0) return;
    if (!is_resolved(track, bounds_of_track(track).peaks())) return;
    const FittedTrajectory fitted(track);
    most = std::max(most, fitted->pieces().size());
    const std::vector<AxisPeaks> peaks = bounds_of_track(track).peaks();
    const std::size_t axes = fitted->axis_count();
    std::vector<AxisMotion> asked(axes), played(axes);
    std::vector<double> positions(axes);
    for (int k = 0; k < 400; ++k) {
      const double frames = (k + 0.31830988) / 400 * track.frames();
      const FrameTime time{static_cast<std::int32_t>(frames), frames - std::floor(frames)};
      const SampledSpeed speed = fitted.sampler().sample(time, asked);
      fitted->motion(time, played);
      fitted->positions(time, positions);
      for (std::size_t d = 0; d < axes; ++d) {
        RC_LOG() << "axis " << d << " at frame " << frames << ": " << played[d].position << " for "
                 << asked[d].position << ", " << played[d].velocity << " for " << asked[d].velocity << "/s\n";
        const double travel = peaks[d].highest.value - peaks[d].lowest.value;
        const double v_noise = noise_at(fitted, d, frames)[0];
        const double p_noise =
            8 * std::numeric_limits<double>::epsilon() *
            (std::fabs(asked[d].position) +
             fitted.sampler().length() * std::fabs(asked[d].velocity) / (speed.speed + 1e-300));
        RC_ASSERT(positions[d] == played[d].position);
        RC_ASSERT(std::fabs(played[d].position - asked[d].position) <=
                  1.5 * travel / (1 << 30) + 2 * p_noise);
        const double weight = fitted.sampler().weight(d);
        // A distance of less than a millionth in a frame is as good as a rest.
        const double least = 1e-6 * travel * track.frame_rate().frames_per_second();
        const double share = weight > 0 ? std::max(speed.speed / weight, least) : peaks[d].velocity.value;
        RC_ASSERT(std::fabs(played[d].velocity - asked[d].velocity) <= 1.05e-6 * share + v_noise);
        const MotionTriple noise = noise_at(fitted, d, frames);
        if (std::isinf(peaks[d].acceleration.value)) continue;
        RC_ASSERT(std::fabs(played[d].acceleration - asked[d].acceleration) <=
                  1e-4 * peaks[d].acceleration.value + noise[1]);
        RC_ASSERT(std::fabs(played[d].jerk - asked[d].jerk) <= 3e-3 * peaks[d].jerk.value + noise[2]);
      }
    }
  });
  std::cout << "at most " << most << " pieces\n";
}

TEST(TrajectoryProperty, EveryJointTheFirstAndTheLastPositionAreThoseOfTheTrack) {
  check_property(many_moves, [&] {
    const RandomMove move = *random_move();
    show(move);
    const SolvedTrack solved = solve(move);
    const Track& track = solved.track();
    if (track.arc_length().total() == 0) return;
    const FittedTrajectory fitted(track);
    const std::size_t axes = fitted->axis_count();
    std::vector<double> first(axes), last(axes), at(axes);
    fitted->positions({0, 0}, first);
    fitted->positions({track.frames(), 0}, last);
    for (std::size_t d = 0; d < axes; ++d) {
      RC_ASSERT(first[d] == track.path().segment(0)[d].c0);
      RC_ASSERT(last[d] == track.path().segment(track.path().segment_count())[d].c0);
    }
    for (const TrajectoryPiece& piece : fitted->pieces()) {
      fitted->positions(piece.begin, at);
      for (std::size_t d = 0; d < axes; ++d) RC_ASSERT(at[d] == fitted->values()[piece.begin_row + d]);
    }
  });
}

TEST(TrajectoryProperty, ItsCountsInFloatAreWithinATwentiethOfACount) {
  double worst = 0;
  check_property(many_moves, [&] {
    const RandomMove move = *regular_move();
    show(move);
    const SolvedTrack solved = solve(move);
    const Track& track = solved.track();
    if (track.arc_length().total() == 0 || track.frames() < 12) return;
    const FittedTrajectory fitted(track);
    const std::size_t axes = fitted->axis_count();
    std::vector<AxisPeaks> peaks(axes);
    bound_trajectory(*fitted, peaks);
    double reach = 0;
    double speed = 0;
    for (const AxisPeaks& axis : peaks) {
      reach = std::max({reach, std::fabs(axis.lowest.value), std::fabs(axis.highest.value)});
      speed = std::max(speed, axis.velocity.value / track.frame_rate().frames_per_second());
    }
    // Twenty bits of counts, as far as so many in a frame are not told apart by a float's fraction of it.
    const double scale = std::min(1048576 / reach, 262144 / speed);
    CountsOfTrajectory counts(*fitted, std::vector<double>(axes, scale));
    std::vector<double> positions(axes);
    for (int k = 0; k < 200; ++k) {
      const double frames = (k + 0.31830988) / 200 * track.frames();
      const FloatFrameTime time{static_cast<std::int32_t>(frames),
                                static_cast<float>(frames - std::floor(frames))};
      fitted->positions({time.frame, time.fraction}, positions);
      for (std::size_t d = 0; d < axes; ++d) {
        const CountTrajectory::Position found = counts->position(time, d);
        const double miss = std::fabs(found.base - positions[d] * scale + static_cast<double>(found.offset));
        worst = std::max(worst, miss);
        RC_LOG() << "axis " << d << " at frame " << frames << " misses by " << miss << " counts\n";
        RC_ASSERT(miss <= 0.05);
      }
    }
  });
  std::cout << "a float misses by at most " << worst << " counts\n";
}

/// Calls `work` with the trajectory of a move that has length and no peak too narrow, and with its bounds. As
/// many as `cases` are drawn: few, because a dense search in extended precision takes its time.
template <class Work>
void check_bounded(int cases, const Work& work) {
  check_property(cases, [&] {
    const RandomMove move = *regular_move();
    show(move);
    const SolvedTrack solved = solve(move);
    if (solved.track().arc_length().total() == 0) return;
    if (!is_resolved(solved.track(), bounds_of_track(solved.track()).peaks())) return;
    const FittedTrajectory fitted(solved.track());
    std::vector<AxisPeaks> peaks(fitted->axis_count());
    bound_trajectory(*fitted, peaks);
    work(fitted, peaks);
  });
}

TEST(TrajectoryProperty, NoMomentOfAPieceIsAboveItsBoundAndNoBoundIsFarAboveItsPeak) {
  double worst = 0;
  check_bounded(many_moves / 5, [&](const auto& fitted, const auto& peaks) {
    for (std::size_t d = 0; d < peaks.size(); ++d) {
      std::array<long double, 4> found{};
      for (const TrajectoryPiece& piece : fitted->pieces()) {
        for (int k = 0; k <= 32; ++k) {
          const std::array<long double, 4> here = exact_piece(*fitted, piece, d, k / 32.0L);
          for (std::size_t q = 1; q < found.size(); ++q) found[q] = std::max(found[q], std::fabs(here[q]));
        }
      }
      const MotionTriple bounds{peaks[d].velocity.value, peaks[d].acceleration.value, peaks[d].jerk.value};
      const MotionTriple noise = noise_at_peaks(fitted, d, peaks[d]);
      for (std::size_t q = 0; q < bounds.size(); ++q) {
        RC_LOG() << "axis " << d << " derivative " << q + 1 << ": bound " << bounds[q] << ", found "
                 << static_cast<double>(found[q + 1]) << ", noise " << noise[q] << '\n';
        RC_ASSERT(bounds[q] >= found[q + 1] * (1 - 1e-9L) - noise[q]);
        // A peak that is no more than its rounding may be told as none that has a bound.
        if (std::isinf(bounds[q]) && noise[q] >= found[q + 1]) continue;
        RC_ASSERT(bounds[q] <= found[q + 1] * 1.005L + noise[q]);
        if (found[q + 1] > 0 && noise[q] < 1e-6 * bounds[q])
          worst = std::max(worst, static_cast<double>(bounds[q] / found[q + 1]));
      }
    }
  });
  std::cout << "a bound is at most " << worst << " of what is reached\n";
}

/// What a dense search of the pieces finds of an axis in every cell.
std::vector<MotionTriple> found_in_cells(const FittedTrajectory& fitted, std::size_t axis,
                                         const CellLine& line) {
  std::vector<MotionTriple> found(line.cells);
  const double cell_frames =
      static_cast<double>(line.last_frame - line.first_frame) / static_cast<double>(line.cells);
  for (const TrajectoryPiece& piece : fitted->pieces()) {
    const int points = 32 + static_cast<int>(8 / (piece.inverse_frames * cell_frames));
    for (int k = 0; k <= points; ++k) {  // the ends a little inside: a cell may begin there
      const double frame = piece.begin.frame + piece.begin.fraction +
                           (k + 1e-9 * (points / 2.0 - k)) / points / piece.inverse_frames;
      const auto cell = static_cast<std::size_t>(
          std::clamp((frame - line.first_frame) / cell_frames, 0.0, static_cast<double>(line.cells - 1)));
      const std::array<long double, 4> here =
          exact_piece(*fitted, piece, axis, static_cast<long double>(k) / points);
      for (std::size_t q = 0; q < 3; ++q)
        found[cell][q] = std::max(found[cell][q], static_cast<double>(std::fabs(here[q + 1])));
    }
  }
  return found;
}

TEST(TrajectoryProperty, NoMomentOfACellIsAboveItsSupremumAndNoSupremumIsFarAboveItsNeighbours) {
  check_bounded(many_moves / 10, [](const auto& fitted, const auto& peaks) {
    const std::size_t axes = fitted->axis_count();
    const CellLine line{-3, fitted->end().frame, static_cast<std::size_t>(*rc::gen::inRange(1, 300))};
    std::vector<MotionTriple> room(axes);
    for (std::size_t d = 0; d < axes; ++d)
      room[d] = {0.005 * peaks[d].velocity.value, 0.005 * peaks[d].acceleration.value,
                 0.005 * peaks[d].jerk.value};
    const std::size_t stride = axes + 1;
    std::vector<MotionTriple> suprema(line.cells * stride);
    bound_cells(*fitted, fitted->begin(), fitted->end(), line, room, suprema, stride);
    for (std::size_t d = 0; d < axes; ++d) {
      const std::vector<MotionTriple> found = found_in_cells(fitted, d, line);
      const MotionTriple noise = noise_at_peaks(fitted, d, peaks[d]);
      for (std::size_t cell = 0; cell < line.cells; ++cell) {
        for (std::size_t q = 0; q < 3; ++q) {
          if (std::isinf(room[d][q])) continue;
          double around = found[cell][q];
          if (cell > 0) around = std::max(around, found[cell - 1][q]);
          if (cell + 1 < line.cells) around = std::max(around, found[cell + 1][q]);
          const double supremum = suprema[cell * stride + d][q];
          RC_LOG() << "axis " << d << " derivative " << q + 1 << " cell " << cell << " of " << line.cells
                   << ": " << supremum << ", found " << found[cell][q] << ", around " << around << '\n';
          RC_ASSERT(supremum >= found[cell][q] * (1 - 1e-9) - noise[q]);
          RC_ASSERT(supremum <= around * 1.03 + 1.05 * room[d][q] + noise[q]);
        }
      }
    }
  });
}

}  // namespace trajectory_property_test
}  // namespace inbetween
