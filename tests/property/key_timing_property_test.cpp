#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>
#include <vector>

#include "host_tools/plan/solved_track.hpp"
#include "inbetween/timing/key_timing.hpp"
#include "tests/support/oracle_least_squares.hpp"
#include "tests/support/oracle_table.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random_move.hpp"
#include "tests/support/solved_move.hpp"

/// Keys locked to frames on random moves: met, and by the least change of the drawn curve.

namespace inbetween {
namespace key_timing_property_test {

constexpr int many_moves = 150;
/// The dense oracle takes its time: larger curves are not compared with it.
constexpr int max_spans = 80;

using Values = std::vector<long double>;

long double widened(double value) {
  return static_cast<long double>(value);
}

int number(int from, int below) {
  return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(from, below));
}

/// A move with keys that want to be met somewhat earlier or later than the drawn curve does.
struct LockedMove {
  RandomMove move;
  oracle::Path path;
  std::vector<KeyLock> locks;

  explicit LockedMove(RandomMove drawn) : move(std::move(drawn)), path(move.keys) {
    if (move.speed.size() == 1) move.speed.push_back(move.speed.front());
    const oracle::Profile profile(move.speed);
    std::int32_t before = 0;
    for (int key = 1; key < path.segments(); ++key) {
      if (!locks.empty() && number(0, 2) == 0) continue;
      const double percent = 1 + number(-30, 31) / 100.0;
      const auto frame = static_cast<std::int32_t>(std::lround(arrival(profile, key) * percent));
      if (frame <= before || frame >= move.frames) continue;
      locks.push_back({.key = key, .frame = frame});
      before = frame;
    }
  }

  [[nodiscard]] long double distance(std::int32_t key) const {
    return path.travelled({0, 0}, oracle_place(key));
  }
  [[nodiscard]] oracle::Place oracle_place(std::int32_t key) const {
    return key < path.segments() ? oracle::Place{key, 0} : oracle::Place{path.segments() - 1, 1};
  }

 private:
  /// The frame, not a whole one, on which the drawn curve reaches a key.
  [[nodiscard]] double arrival(const oracle::Profile& profile, int key) const {
    const auto f = static_cast<long double>(profile.spans());
    const long double target = distance(key) / path.total_length() * profile.integral(f);
    long double low = 0;
    long double high = f;
    for (int i = 0; i < 60; ++i) {
      const long double middle = (low + high) / 2;
      (profile.integral(middle) < target ? low : high) = middle;
    }
    return static_cast<double>(high / f) * move.frames;
  }
};

LockedMove random_locked_move() {
  RandomMove move = *regular_move();
  RC_PRE(move.keys.at.size() + (move.keys.closed ? 1 : 0) >= 3 && move.frames >= 4);
  LockedMove locked(std::move(move));
  RC_PRE(!locked.locks.empty() && locked.path.total_length() > 0);
  return locked;
}

void showLocks(const LockedMove& locked) {
  show(locked.move);
  for (const KeyLock& lock : locked.locks)
    RC_LOG() << "# key " << lock.key << " on frame " << lock.frame << '\n';
}

std::optional<SolvedTrack> solved(const LockedMove& locked) {
  const TrackInput input(locked.move);
  TrackSpec spec = input.spec;
  spec.locks = locked.locks;
  try {
    return SolvedTrack(spec, Solver::closed_form);
  } catch (const SolverError& refused) {
    RC_LOG() << refused.what() << '\n';
    RC_ASSERT(refused.error().code == ErrorCode::no_solution);
    RC_ASSERT(std::ranges::count(locked.locks, refused.error().key, &KeyLock::key) +
                  (refused.error().key == locked.path.segments() ? 1 : 0) ==
              1);
    return std::nullopt;
  }
}

/// Calls `property` with random moves and with their solution, or with nothing where a move is refused.
template <class Property>
void check_locked(const Property& property) {
  check_property(many_moves, [&] {
    const LockedMove locked = random_locked_move();
    showLocks(locked);
    property(locked, solved(locked));
  });
}

/// 0 where the drawn curve, refined as it is, stands still: at two zeros at an end and at three in a row
/// inside. 1 where values move freely, and between the two a smooth step over one drawn span.
Values mobility(const Values& drawn, int refinements) {
  const auto count = static_cast<int>(drawn.size());
  const auto zero = [&](int i) { return i >= 0 && i < count && drawn[static_cast<std::size_t>(i)] == 0; };
  std::vector<int> still;
  for (int i = 0; i < count; ++i) {
    const auto three = [&](int middle) { return zero(middle - 1) && zero(middle) && zero(middle + 1); };
    const bool at_begin = i <= 1 && zero(0) && zero(1);
    const bool at_end = i >= count - 2 && zero(count - 1) && zero(count - 2);
    if (at_begin || at_end || three(i - 1) || three(i) || three(i + 1)) still.push_back(i);
  }
  Values result(drawn.size(), 1);
  for (int i = 0; i < count; ++i) {
    for (const int each : still) {
      const long double x =
          std::min(1.0L, static_cast<long double>(std::abs(i - each)) / std::pow(2.0L, refinements));
      const long double step = x * x * x * (10 - x * (15 - 6 * x));
      result[static_cast<std::size_t>(i)] = std::min(result[static_cast<std::size_t>(i)], step);
    }
  }
  return result;
}

/// What the product had to solve, from the oracle's own lengths and integrals.
oracle::QuadraticProgram problem_of(const LockedMove& locked, int refinements) {
  oracle::QuadraticProgram problem;
  problem.drawn.assign(locked.move.speed.begin(), locked.move.speed.end());
  const oracle::Profile profile(problem.drawn);
  const long double total = profile.integral(static_cast<long double>(profile.spans()));
  for (int i = 0; i < refinements; ++i) problem.drawn = oracle::refined(problem.drawn);
  problem.mobility = mobility(problem.drawn, refinements);
  problem.ceiling.assign(problem.drawn.size(), 100);
  const auto f = static_cast<int>(problem.drawn.size()) - 1;
  const long double per_frame = static_cast<long double>(f) / static_cast<long double>(locked.move.frames);
  Values bounds{0};
  Values distances{0};
  for (const KeyLock& lock : locked.locks) {
    bounds.push_back(static_cast<long double>(lock.frame) * per_frame);
    distances.push_back(locked.distance(lock.key));
  }
  bounds.push_back(static_cast<long double>(f));
  distances.push_back(locked.path.total_length());
  problem.rows = oracle::integral_rows(f, bounds);
  const long double scale = total * std::pow(2.0L, refinements);
  for (std::size_t r = 0; r + 1 < distances.size(); ++r) {
    problem.targets.push_back((distances[r + 1] - distances[r]) / locked.path.total_length() * scale);
    if (problem.targets.back() > 0) continue;
    for (std::size_t i = 0; i < problem.ceiling.size(); ++i) {  // no distance, no speed
      if (problem.rows[r][i] > 0) problem.ceiling[i] = 0;
    }
  }
  return problem;
}

TEST(KeyTimingProperty, EveryLockedKeyIsMetOnItsFrame) {
  int met = 0;
  check_locked([&met](const LockedMove& locked, const std::optional<SolvedTrack>& track) {
    if (!track) return;
    ++met;
    const auto places = oracle_places(track->track(), track->table());
    for (const KeyLock& lock : locked.locks) {
      const auto [segment, t] = places[static_cast<std::size_t>(lock.frame)];
      const long double off = locked.path.travelled({segment, widened(t)}, locked.oracle_place(lock.key));
      RC_LOG() << "key " << lock.key << " is off by " << off / locked.path.total_length() << '\n';
      RC_ASSERT(std::fabs(off) <= 1e-9L * locked.path.total_length());
    }
  });
  std::cout << met << " solved\n";
  EXPECT_GT(met, 0);
}

TEST(KeyTimingProperty, ThePlayedControlValuesReproduceTheTable) {
  check_locked([](const LockedMove& locked, const std::optional<SolvedTrack>& track) {
    if (!track) return;
    const oracle::Profile played(track->control_values());
    const auto places = oracle_places(track->track(), track->table());
    const oracle::SpeedError error =
        oracle::worst_speed_error(locked.path, played, locked.move.frames, places, 1e-6L);
    RC_LOG() << "frame " << error.frame << " travels " << error.travelled << ", wanted " << error.wanted
             << '\n';
    RC_ASSERT(error.worst <= 1);
  });
}

TEST(KeyTimingProperty, TheAdjustedValuesStayInRangeAndKeepTheAreaAndTheRests) {
  check_locked([](const LockedMove& locked, const std::optional<SolvedTrack>& track) {
    if (!track) return;
    const std::vector<double>& values = track->control_values();
    RC_ASSERT(*std::ranges::min_element(values) >= 0);
    RC_ASSERT(*std::ranges::max_element(values) <= 100);
    const oracle::QuadraticProgram problem = problem_of(locked, track->key_timing()->refinements);
    RC_ASSERT(values.size() == problem.drawn.size());
    const auto f = static_cast<long double>(values.size() - 1);
    const long double area = oracle::Profile(values).integral(f);
    const long double drawn = oracle::Profile(problem.drawn).integral(f);
    RC_LOG() << "area " << area << ", drawn " << drawn << '\n';
    RC_ASSERT(std::fabs(area - drawn) <= 1e-12L * drawn);
    double largest = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (problem.mobility[i] == 0) RC_ASSERT(values[i] == 0.0);
      largest = std::max(largest, std::fabs(values[i] - static_cast<double>(problem.drawn[i])));
    }
    const KeyTiming& timing = *track->key_timing();
    RC_ASSERT(std::fabs(timing.largest_change - largest) <= 1e-12);
    const auto at = static_cast<std::size_t>(timing.largest_change_at);
    RC_ASSERT(std::fabs(std::fabs(values[at] - static_cast<double>(problem.drawn[at])) - largest) <= 1e-12);
  });
}

TEST(KeyTimingProperty, NoOtherCurveThatMeetsTheKeysChangesLess) {
  int compared = 0;
  check_locked([&compared](const LockedMove& locked, const std::optional<SolvedTrack>& track) {
    if (!track || track->control_values().size() > max_spans) return;
    const oracle::QuadraticProgram problem = problem_of(locked, track->key_timing()->refinements);
    const std::optional<Values> least = oracle::solve(problem);
    RC_ASSERT(least.has_value());
    const long double best = oracle::change(problem, *least);
    const Values values(track->control_values().begin(), track->control_values().end());
    const long double change = oracle::change(problem, values);
    RC_LOG() << "changed by " << change << ", least " << best << '\n';
    const long double rounding = 1e-20L;
    RC_ASSERT(change <= best * (1 + 1e-6L) + rounding);
    RC_ASSERT(change >= best * (1 - 1e-6L) - rounding);
    ++compared;
  });
  std::cout << compared << " compared\n";
  EXPECT_GT(compared, 0);
}

TEST(KeyTimingProperty, TheCurveIsRefinedOnlyWhereNoCurveOfFewerValuesMeetsTheKeys) {
  int refined = 0;
  check_locked([&refined](const LockedMove& locked, const std::optional<SolvedTrack>& track) {
    const int refinements = track ? track->key_timing()->refinements : 99;
    if (refinements == 0) return;
    ++refined;
    int spans = static_cast<int>(locked.move.speed.size()) - 1;
    for (int level = 0; level < refinements && spans <= max_spans; ++level, spans *= 2) {
      RC_LOG() << "refined " << level << " times\n";
      RC_ASSERT(!oracle::solve(problem_of(locked, level)).has_value());
    }
  });
  std::cout << refined << " refined\n";
  EXPECT_GT(refined, 0);
}

}  // namespace key_timing_property_test
}  // namespace inbetween
