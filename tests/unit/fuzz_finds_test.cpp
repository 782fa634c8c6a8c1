// What the fuzz targets have found, each as the smallest move that showed it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "host_tools/solved_track.hpp"

namespace inbetween {
namespace {

template <Precise Real>
struct Move {
  Spline spline = Spline::catmull_rom;
  bool closed = false;
  std::int32_t axis_count = 1;
  std::vector<Real> keys;
  std::vector<Real> speed = {10};
  std::int32_t frames = 50;
  ArcLengthOptions<Real> options = {};
  std::vector<std::int32_t> key_frames = {};
};

template <Precise Real>
SolvedTrack<Real> solved(const Move<Real>& move, Solver solver = Solver::closed_form) {
  return SolvedTrack<Real>({.path = {.spline = move.spline,
                                     .closed = move.closed,
                                     .axis_count = move.axis_count,
                                     .keys = move.keys},
                            .control_values = move.speed,
                            .frames = move.frames,
                            .fps = {24, 1},
                            .arc_length = move.options,
                            .locks = {},
                            .key_frames = move.key_frames},
                           solver);
}

/// The error with which the core refuses a move.
template <Precise Real>
Error refusal(const Move<Real>& move, Solver solver = Solver::closed_form) {
  try {
    static_cast<void>(solved(move, solver));
  } catch (const SolverError& error) {
    return error.error();
  }
  ADD_FAILURE() << "the move is not refused";
  return {};
}

template <Precise Real>
void expect_sound(const SolvedTrack<Real>& solution) {
  const Status invariants = check_invariants(solution.track(), solution.table());
  EXPECT_TRUE(invariants) << (invariants ? "" : invariants.error().what);
  for (std::int32_t frame = 0; frame <= solution.track().frames(); ++frame) {
    EXPECT_TRUE(std::isfinite(frame_row(solution.track(), solution.table(), frame).distance)) << frame;
  }
}

TEST(FuzzFinds, DivisionEndsWhereSinglePrecisionHasNoMoreDigits) {
  // The certificate of a piece cannot be better than rounding, and a stretch of a few ulp cannot be divided:
  // that never ended. Three axes stand still, and two keys are the same.
  Move<float> move{.closed = true, .axis_count = 4, .keys = {127, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}};
  for (const Acceptance acceptance : {Acceptance::estimated, Acceptance::certified}) {
    for (const float delta : {1e-2F, 1e-4F, 1e-5F, 4e-6F}) {
      move.options = {.delta = delta, .acceptance = acceptance};
      try {
        expect_sound(solved(move));
      } catch (const SolverError& error) {
        EXPECT_EQ(error.error().code, ErrorCode::accuracy);
        EXPECT_GE(error.error().key, 0);
      }
    }
  }
}

TEST(FuzzFinds, APathOfSubnormalLengthIsRefused) {
  // Its scale by a power of two was infinite.
  const Error error = refusal<float>({.keys = {0x1p-146F, 0, 0}});
  EXPECT_EQ(error.code, ErrorCode::out_of_range);
  EXPECT_EQ(refusal<double>({.keys = {0x1p-1070, 0, 0}}).code, ErrorCode::out_of_range);
}

TEST(FuzzFinds, ASegmentTooShortToBeToldFromAPointIsPassedInNoDistance) {
  for (const float near : {0x1p-146F, 0x1p-120F, 0x1p-60F}) {
    const auto solution = solved<float>({.spline = Spline::linear, .keys = {0, near, 100}});
    expect_sound(solution);
    EXPECT_EQ(solution.track().arc_length().total(), 100);
  }
  for (const double near : {0x1p-1070, 0x1p-1000, 0x1p-300}) {
    const auto solution = solved<double>({.spline = Spline::linear, .keys = {0, near, 100}});
    expect_sound(solution);
    EXPECT_EQ(solution.track().arc_length().total(), 100);
  }
}

TEST(FuzzFinds, PiecesShorterThanTheLastBitOfTheDistanceAreNotExtrapolated) {
  // Beside a near-cusp in single precision several pieces begin at the same distance, as far as its upper
  // part can tell. The last of them was evaluated far outside itself: 97 units off in a step of 45926.
  const auto solution = solved<float>({.closed = true,
                                       .axis_count = 2,
                                       .keys = {0x1.78p+5F, 0x1.e847fep+19F, 0x1.78008ap+5F, 0, 0, 0, 0, 0},
                                       .speed = {74}});
  expect_sound(solution);
  const Track<float>& track = solution.track();
  const float travelled = track.arc_length().distance(track.path(), solution.table().point(25)).high;
  EXPECT_NEAR(travelled, track.distance({25, 0}).high, 1);
}

template <Precise Real>
void expect_sound_or_refused(const Move<Real>& move, Solver solver) {
  try {
    expect_sound(solved(move, solver));
  } catch (const SolverError& error) {
    EXPECT_STRNE(error.error().remedy, "") << error.error().what;
  }
}

TEST(FuzzFinds, RungeKuttaThatOverflowsIsAnErrorAndNotAnIndex) {
  // Where the line turns back inside a segment its speed is 0, or rounds to less: 1 / sqrt of that is no
  // number, and was converted to the index of a segment.
  for (std::int32_t frames = 1; frames <= 60; ++frames) {
    for (const float top : {7.0F, 8.0F, 8.3F}) {
      expect_sound_or_refused<float>({.keys = {0, top, top, 0}, .frames = frames}, Solver::runge_kutta);
      const auto same = static_cast<double>(top);
      expect_sound_or_refused<double>({.keys = {0, same, same, 0}, .frames = frames}, Solver::runge_kutta);
    }
  }
}

TEST(FuzzFinds, RungeKuttaStandsStillInADwellAtTheEnd) {
  // The last frame is put on the last key, which is within the tolerance of the root finder. The step from
  // the dwell before it moved by that much where the drawn speed is 0.
  Move<double> move{.keys = {-67, -68}, .speed = {56, 32, 0, 0, 0, 0}, .frames = 34};
  const auto solution = solved(move, Solver::runge_kutta);
  expect_sound(solution);
  for (std::int32_t frame = 29; frame <= 34; ++frame) {
    EXPECT_EQ(solution.table().point(frame), solution.table().point(34)) << frame;
  }
}

TEST(FuzzFinds, RungeKuttaRefusesAMoveThatHasNoSpeedCurve) {
  // It read the integral of a curve without spans.
  const Move<double> move{.keys = {0, 5, 30}, .frames = 20, .key_frames = {0, 8, 20}};
  expect_sound(solved(move));
  const Error error = refusal(move, Solver::runge_kutta);
  EXPECT_EQ(error.code, ErrorCode::out_of_range);
  EXPECT_STREQ(error.remedy, "use the closed-form solver");
}

}  // namespace
}  // namespace inbetween
