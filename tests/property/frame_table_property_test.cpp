#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <vector>

#include "tests/support/oracle_table.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random_move.hpp"
#include "tests/support/solved_move.hpp"

/// The frame table against the oracle, on random moves of every kind of path.

namespace inbetween {
namespace frame_table_property_test {

constexpr int many_moves = 10'000;

void expect_speed_as_drawn(const RandomMove& move, const std::vector<double>& deltas, Acceptance acceptance) {
  const oracle::Path path(move.keys);
  const oracle::Profile profile(move.speed);
  for (const double delta : deltas) {
    TrackInput input(move);
    input.spec.arc_length = {.delta = delta, .acceptance = acceptance};
    const SolvedTrack solved(input.spec, Solver::closed_form);
    const auto places = oracle_places(solved.track(), solved.table());
    const oracle::SpeedError error =
        oracle::worst_speed_error(path, profile, move.frames, places, static_cast<long double>(delta));
    RC_LOG() << "delta " << delta << ": worst " << error.worst << " at frame " << error.frame
             << ", travelled " << error.travelled << ", wanted " << error.wanted << ", allowed "
             << error.allowed << "\n";
    RC_ASSERT(error.worst <= 1.0L);
    RC_ASSERT(error.worst_distance <= static_cast<long double>(delta));
    const Status invariants = check_invariants(solved.track(), solved.table());
    if (!invariants) RC_FAIL(invariants.error().what);
  }
}

TEST(FrameTableProperty, SpeedIsAsDrawnWithinDeltaOnEveryKindOfPath) {
  check_property(many_moves, [](const RandomMove& move) {
    expect_speed_as_drawn(move, {1e-4, 1e-6, 1e-9}, Acceptance::estimated);
  });
}

TEST(FrameTableProperty, SpeedIsAsDrawnWithACertifiedInverse) {
  check_property(many_moves / 20, [](const RandomMove& move) {
    expect_speed_as_drawn(move, {1e-4, 1e-6, 1e-9}, Acceptance::certified);
  });
}

TEST(FrameTableProperty, FirstAndLastFrameAreTheKeysToTheLastBit) {
  check_property(many_moves, [](const RandomMove& move) {
    const SolvedTrack solved = solve(move);
    const Path& path = solved.track().path();
    const auto axes = static_cast<std::size_t>(path.axis_count());
    std::vector<double> first(axes);
    std::vector<double> last(axes);
    solved.track().positions({0, 0}, first);
    solved.track().positions({move.frames, 0}, last);
    const std::size_t last_key = move.keys.closed ? 0 : move.keys.at.size() - 1;
    for (std::size_t d = 0; d < axes; ++d) {
      RC_ASSERT(static_cast<long double>(first[d]) == move.keys.at[0][d]);
      RC_ASSERT(static_cast<long double>(last[d]) == move.keys.at[last_key][d]);
      RC_ASSERT(path.position(solved.table().point(0), static_cast<std::int32_t>(d)) == first[d]);
      RC_ASSERT(path.position(solved.table().point(move.frames), static_cast<std::int32_t>(d)) == last[d]);
    }
  });
}

TEST(FrameTableProperty, ARowIsWhatTheTickEvaluatesAtThatFrame) {
  check_property(1000, [](const RandomMove& move) {
    const SolvedTrack solved = solve(move);
    for (std::int32_t frame = 0; frame <= move.frames; ++frame) {
      const PathPoint row = solved.table().point(frame);
      const PathPoint tick = solved.track().locate({frame, 0});
      const double apart = (row.segment - tick.segment) + (row.t - tick.t);
      RC_ASSERT(apart >= 0.0);
      RC_ASSERT(apart <= 4e-15);
    }
  });
}

}  // namespace frame_table_property_test
}  // namespace inbetween
