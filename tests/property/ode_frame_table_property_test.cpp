#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "tests/support/oracle_table.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random_move.hpp"
#include "tests/support/solved_move.hpp"

/// The Runge-Kutta solver against the oracle and against the closed form, on random moves.

namespace inbetween {
namespace ode_frame_table_property_test {

constexpr int many_moves = 600;

/// The solved move, or nothing where the solver refuses it or there is nothing to solve.
std::optional<SolvedTrack> integrated(const TrackInput& input, const OdeOptions& options) {
  try {
    SolvedTrack solved(input.spec, Solver::runge_kutta, options);
    if (solved.track().arc_length().total() == 0) return std::nullopt;
    return solved;
  } catch (const SolverError& error) {
    const ErrorCode code = error.error().code;
    RC_LOG() << error.what() << '\n';
    RC_ASSERT(code == ErrorCode::accuracy || code == ErrorCode::singular ||
              code == ErrorCode::not_converged || code == ErrorCode::not_bracketed);
    return std::nullopt;
  }
}

/// What the oracle finds in a table: its worst relative step, and how far it strays.
struct Judgement {
  long double worst_long_step = 0;  ///< |travelled / wanted - 1| over steps longer than 1e-6 of the length
  long double short_steps = 0;      ///< the sum of |travelled - wanted| over the others, of the length
  long double worst_distance = 0;   ///< of the length
};

Judgement judge(const oracle::Path& path, const oracle::Profile& profile, const SolvedTrack& solved) {
  const auto places = oracle_places(solved.track(), solved.table());
  const int frames = solved.table().frames();
  const long double per_frame = static_cast<long double>(profile.spans()) / static_cast<long double>(frames);
  const long double k = path.total_length() / profile.integral(static_cast<long double>(profile.spans()));
  Judgement result;
  long double off = 0;
  for (int frame = 0; frame < frames; ++frame) {
    const auto place = [&](int at) {
      const auto& [segment, t] = places[static_cast<std::size_t>(at)];
      return oracle::Place{segment, static_cast<long double>(t)};
    };
    const auto from = static_cast<long double>(frame) * per_frame;
    const auto to =
        std::min(static_cast<long double>(frame + 1) * per_frame, static_cast<long double>(profile.spans()));
    const long double wanted = k * profile.integral(from, to) / path.total_length();
    const long double error = path.travelled(place(frame), place(frame + 1)) / path.total_length() - wanted;
    if (wanted > 1e-6L) {
      result.worst_long_step = std::max(result.worst_long_step, std::fabs(error) / wanted);
    } else {
      result.short_steps += std::fabs(error);
    }
    off += error;
    result.worst_distance = std::max(result.worst_distance, std::fabs(off));
  }
  return result;
}

TEST(RungeKuttaProperty, IsAsGoodAsItSaysOrRefuses) {
  int solved_moves = 0;
  check_property(many_moves, [&](const RandomMove& move) {
    TrackInput input(move);
    input.spec.arc_length.delta = 1e-9;
    const auto solved = integrated(input, {});
    if (!solved) return;
    ++solved_moves;
    const oracle::Path path(move.keys);
    const oracle::Profile profile(move.speed);
    const Judgement judgement = judge(path, profile, *solved);
    const Provenance& provenance = solved->table().provenance();
    const auto said = static_cast<long double>(provenance.speed_error);
    RC_LOG() << "says " << said << ", is " << judgement.worst_long_step << '\n';
    RC_ASSERT(said <= 0.02L);
    // It measures with the arc length at delta 1e-9, the oracle with its own.
    RC_ASSERT(std::fabs(judgement.worst_long_step - said) <= 1e-8L);
    RC_ASSERT(solved->integrated()->substeps == 10);
    RC_ASSERT(solved->integrated()->integrations >= 4);
    RC_ASSERT(solved->integrated()->integrations <= 100);
  });
  if (!counts_mean_something()) return;
  EXPECT_GT(solved_moves, many_moves / 10) << "a solver that refuses most moves is not tested here";
}

TEST(RungeKuttaProperty, AgreesWithTheClosedFormWithinItsOwnError) {
  check_property(many_moves, [](const RandomMove& move) {
    TrackInput input(move);
    input.spec.arc_length.delta = 1e-9;
    const auto solved = integrated(input, {});
    if (!solved) return;
    const SolvedTrack closed_form(input.spec, Solver::closed_form);
    const oracle::Path path(move.keys);
    const oracle::Profile profile(move.speed);
    const auto said = static_cast<long double>(solved->table().provenance().speed_error);
    const Judgement judgement = judge(path, profile, *solved);
    // Every step is off by at most the worst share of itself. The table begins and ends where the closed
    // form does, so that what was lost before a frame is regained after it: at most half of the length
    // counts, plus the steps too short for a share, plus what the closed form itself is off.
    const long double allowed = said / 2 + judgement.short_steps + 2e-9L;
    RC_ASSERT(judgement.short_steps <= 1e-6L * static_cast<long double>(move.frames));
    RC_LOG() << "says " << said << ", strays " << judgement.worst_distance << '\n';
    RC_ASSERT(judgement.worst_distance <= allowed);
    const auto places = oracle_places(solved->track(), solved->table());
    const auto expected = oracle_places(closed_form.track(), closed_form.table());
    for (std::size_t frame = 0; frame < places.size(); ++frame) {
      const oracle::Place here{places[frame].first, static_cast<long double>(places[frame].second)};
      const oracle::Place there{expected[frame].first, static_cast<long double>(expected[frame].second)};
      RC_ASSERT(std::fabs(path.travelled(there, here)) <= allowed * path.total_length());
    }
    // A frame that the solver resolves is travelled at its K. Among a hundred there is one.
    const double ratio = solved->table().provenance().constant / closed_form.track().constant();
    RC_LOG() << "K is off by " << ratio - 1 << '\n';
    if (move.frames >= 100) RC_ASSERT(std::fabs(static_cast<long double>(ratio) - 1) <= said + 1e-6L);
  });
}

TEST(RungeKuttaProperty, ItsTablesKeepEveryInvariant) {
  check_property(many_moves, [](const RandomMove& move) {
    const TrackInput input(move);
    const auto solved = integrated(input, {});
    if (!solved) return;
    const Status status = check_invariants(solved->track(), solved->table());
    if (!status) RC_FAIL(status.error().what);
  });
}

TEST(RungeKuttaProperty, MoreStepsAFrameShrinkTheErrorOnTheWhole) {
  int better = 0;
  int compared = 0;
  check_property(many_moves / 4, [&] {
    const RandomMove move = *regular_move();
    const TrackInput input(move);
    const auto coarse = integrated(input, {.substeps = 5});
    const auto fine = integrated(input, {.substeps = 50});
    if (!coarse || !fine) return;
    const double before = coarse->table().provenance().speed_error;
    const double after = fine->table().provenance().speed_error;
    RC_LOG() << before << " with 5 steps, " << after << " with 50\n";
    ++compared;
    if (after <= before / 3 || after <= 1e-6) ++better;
  });
  if (!counts_mean_something()) return;
  // Not on every move: a step across a key, where |P'| jumps, may happen to fall well with a coarse step.
  EXPECT_GT(compared, many_moves / 40);
  EXPECT_GT(2 * better, compared);
}

}  // namespace ode_frame_table_property_test
}  // namespace inbetween
