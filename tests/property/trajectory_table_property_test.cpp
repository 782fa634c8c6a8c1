/// Tables of `inbetween plan --trajectory`: they say what plays, their stops keep the limits, and a C
/// compiler makes a player of them.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "host_tools/check/planned_stops.hpp"
#include "host_tools/table/trajectory_table.hpp"
#include "host_tools/text/output_file.hpp"
#include "tests/support/fitting_move.hpp"
#include "tests/support/places.hpp"
#include "tests/support/property.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace trajectory_table_property_test {

int any_int(int from, int below) {
  return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(from, below));
}
double any_share() {
  return any_int(0, 1'000'001) / 1e6;
}

/// As docs/formats.md says it, powers and all.
std::vector<double> positions_of(const TrajectoryTable& table, const FrameTime& time) {
  std::vector<double> positions(table.position_count);
  for (const TableGroup& group : table.groups) {
    const std::size_t count = group.positions.size();
    if (!(time < FrameTime{table.last_frame, 0})) {
      for (std::size_t i = 0; i < count; ++i) positions[group.positions[i]] = group.end[i];
      continue;
    }
    std::size_t p = 0;
    while (p + 1 < group.pieces.size() && group.pieces[p + 1].begin <= time) ++p;
    const TablePiece& piece = group.pieces[p];
    const double u = frames_between(piece.begin, time) * piece.per_frame;
    for (std::size_t i = 0; i < count; ++i) {
      const auto size = static_cast<std::size_t>(piece.degree) + 1;
      double sum = 0;
      for (std::size_t power = size; power-- > 0;)
        sum = sum * u + group.coefficients[piece.first + i * size + power];
      positions[group.positions[i]] = sum;
    }
  }
  return positions;
}

double count_of(const TableMotor& motor, double position) {
  return (position + motor.offset) * motor.scale + motor.zero;
}

/// One count may differ where the position is halfway between two.
bool is_count(double count, double exact) {
  return count == std::floor(exact + 0.5) || std::fabs(std::fabs(count - exact) - 0.5) < 1e-6;
}

std::vector<double> played(const Plan& plan, const FrameTime& time) {
  std::vector<double> positions(plan.played().axis_count());
  plan.motion().positions(time, positions);
  return positions;
}

TEST(TrajectoryTableProperty, SaysWhatPlaysOnEveryTick) {
  int moves = 0;
  int parts = 0;
  check_property(200, [&] {
    const std::optional<FittingMove> fitting = fitting_move(400, true);
    if (!fitting) return;
    const Plan& plan = fitting->plan;
    const TrajectoryTable table = trajectory_table(plan, fitting->report);
    ++moves;
    if (!plan.is_whole()) ++parts;
    const Move& move = plan.played();
    const std::int64_t last = move.last_tick_at(table.rate_hz);
    std::vector<double> least(table.position_count, INFINITY);
    std::vector<double> most(table.position_count, -INFINITY);
    for (std::int64_t tick = 0; tick <= last; ++tick) {
      const std::vector<double> exact = played(plan, move.time_of_tick(tick, table.rate_hz));
      for (std::size_t i = 0; i < exact.size(); ++i) {
        least[i] = std::min(least[i], exact[i]);
        most[i] = std::max(most[i], exact[i]);
      }
    }
    for (std::int64_t tick = 0; tick <= last; ++tick) {
      const FrameTime time = move.time_of_tick(tick, table.rate_hz);
      const std::vector<double> exact = played(plan, time);
      const std::vector<double> told = positions_of(table, time);
      for (std::size_t i = 0; i < exact.size(); ++i) {
        const double rounding = 1e-11 * (most[i] - least[i]) + 4e-16 * std::fabs(exact[i]);
        if (std::fabs(told[i] - exact[i]) > rounding) {
          RC_LOG() << "position " << i << " on tick " << tick << ": " << told[i] << " for " << exact[i]
                   << "\n";
          RC_FAIL("the table says something else");
        }
        if (time.fraction == 0 && (time.frame == move.first_frame() || time.frame == move.last_frame()))
          RC_ASSERT(told[i] == exact[i]);
      }
      for (const TableMotor& motor : table.motors)
        RC_ASSERT(is_count(std::floor(count_of(motor, told[motor.position]) + 0.5),
                           count_of(motor, exact[motor.position])));
    }
  });
  if (!counts_mean_something()) return;
  EXPECT_GT(moves, 60);
  EXPECT_GT(parts, 20);
}

/// Rate, change and jerk of time `t` seconds into a stop, and how far it went, in seconds of the move.
struct StopState {
  double rate, change, jerk, moved_s;
};
StopState state_of(const TableStop& stop, double t) {
  const double most = 1 / (stop.jerk_s + stop.steady_s);
  const double jerk = most / stop.jerk_s;
  const double seconds = stop.seconds();
  if (t <= stop.jerk_s) return {1 - jerk * t * t / 2, -jerk * t, -jerk, t - jerk * t * t * t / 6};
  if (t >= seconds - stop.jerk_s) {
    const double left = seconds - t;
    return {jerk * left * left / 2, -jerk * left, jerk, seconds / 2 - jerk * left * left * left / 6};
  }
  const double steady = t - stop.jerk_s;
  const double rate = 1 - most * stop.jerk_s / 2;
  return {rate - most * steady, -most, 0,
          stop.jerk_s - jerk * stop.jerk_s * stop.jerk_s * stop.jerk_s / 6 + rate * steady -
              most * steady * steady / 2};
}

TEST(TrajectoryTableProperty, EveryStopKeepsTheStopLimits) {
  double nearest = 0;
  check_property(300, [&] {
    const std::optional<FittingMove> fitting = fitting_move(400, true);
    if (!fitting) return;
    const Plan& plan = fitting->plan;
    const TrajectoryTable table = trajectory_table(plan, fitting->report);
    const Move& move = plan.played();
    const double frames = move.last_frame() - move.first_frame();
    const double fps = move.frame_rate().frames_per_second();
    std::vector<AxisMotion> motion(move.axis_count());
    for (int turn = 0; turn < 20; ++turn) {
      const double share = any_share() * (1 - 1e-9);
      const auto cell = static_cast<std::size_t>(share * static_cast<double>(table.stops.size()));
      const TableStop& stop = table.stops[cell];
      for (int k = 0; k <= 200; ++k) {
        const StopState at = state_of(stop, stop.seconds() * k / 200);
        RC_ASSERT(at.rate <= 1 + 1e-12);
        RC_ASSERT(at.rate >= -1e-12);
        const FrameTime time = moved_by({move.first_frame(), 0}, share * frames + at.moved_s * fps);
        plan.motion().motion(time, motion);
        for (std::size_t d = 0; d < motion.size(); ++d) {
          const AxisLimits& limits = plan.limits()[d];
          const AxisMotion& p = motion[d];
          const double acceleration = p.acceleration * at.rate * at.rate + p.velocity * at.change;
          const double jerk = p.jerk * at.rate * at.rate * at.rate +
                              3 * p.acceleration * at.rate * at.change + p.velocity * at.jerk;
          nearest = std::max(nearest, std::fabs(acceleration) / limits.stop_acceleration());
          RC_ASSERT(std::fabs(acceleration) <= limits.stop_acceleration() * (1 + 1e-6));
          if (limits.stop_jerk()) RC_ASSERT(std::fabs(jerk) <= *limits.stop_jerk() * (1 + 1e-6));
        }
      }
    }
  });
  if (!counts_mean_something()) return;
  EXPECT_GT(nearest, 0.9);
}

/// The numbers of every line.
std::vector<std::vector<double>> lines_of(const std::string& text) {
  std::vector<std::vector<double>> lines;
  std::istringstream all(text);
  for (std::string line; std::getline(all, line);) {
    std::istringstream numbers(line);
    lines.emplace_back(std::istream_iterator<double>(numbers), std::istream_iterator<double>());
  }
  return lines;
}

TEST(TrajectoryTableProperty, ACompilerOfCMakesAPlayerThatSendsTheCountsOfARun) {
  check_property(20, [&] {
    std::optional<FittingMove> fitting;
    while (!fitting) fitting = fitting_move(400, true);
    const Plan& plan = fitting->plan;
    const TrajectoryTable table = trajectory_table(plan, fitting->report);
    const TemporaryFolder folder;
    const std::string header = folder.path() / "any move.h";
    write_output(header, [&](std::FILE* file) { write_table_header(table, table_name_of(header), file); });
    const std::string player = folder.path() / "player";
    const ProgramRun alone = run_command({"/usr/bin/cc", "-std=c99", "-Wall", "-Wextra", "-Werror",
                                          "-pedantic", "-x", "c", "-fsyntax-only", header});
    RC_ASSERT(alone.err == "" && alone.status == 0);
    const ProgramRun made =
        run_command({"/usr/bin/cc", "-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic",
                     "-ffp-contract=off", "-include", header, "-DTABLE=any_move_table",
                     "-I" + in_checkout("."), in_checkout("tests/table/play_all.c"), "-o", player, "-lm"});
    RC_ASSERT(made.err == "" && made.status == 0);

    const Move& move = plan.played();
    const std::vector<std::vector<double>> lines = lines_of(run_command({player}).out);
    RC_ASSERT(static_cast<std::int64_t>(lines.size()) == move.last_tick_at(table.rate_hz) + 1);
    for (std::size_t tick = 0; tick < lines.size(); ++tick) {
      const std::vector<double> exact =
          played(plan, move.time_of_tick(static_cast<std::int64_t>(tick), table.rate_hz));
      RC_ASSERT(lines[tick].size() == table.motors.size() + exact.size());
      for (std::size_t m = 0; m < table.motors.size(); ++m)
        RC_ASSERT(is_count(lines[tick][m], count_of(table.motors[m], exact[table.motors[m].position])));
    }

    const auto press = static_cast<std::size_t>(any_int(0, static_cast<int>(lines.size())));
    const std::vector<std::vector<double>> stopped =
        lines_of(run_command({player, std::to_string(press)}).out);
    const FrameTime from = move.time_of_tick(static_cast<std::int64_t>(press), table.rate_hz);
    const double share =
        frames_between({move.first_frame(), 0}, from) / (move.last_frame() - move.first_frame());
    const std::size_t cell = std::min(
        static_cast<std::size_t>(share * static_cast<double>(table.stops.size())), table.stops.size() - 1);
    const TableStop& stop = table.stops[cell];
    RC_ASSERT(static_cast<double>(stopped.size()) <=
              static_cast<double>(press) + std::ceil(stop.seconds() * table.rate_hz) + 2);
    for (std::size_t tick = 0; tick < stopped.size(); ++tick) {
      FrameTime time = move.time_of_tick(static_cast<std::int64_t>(tick), table.rate_hz);
      if (tick >= press) {
        const double t = std::min(static_cast<double>(tick - press) / table.rate_hz, stop.seconds());
        time = moved_by(from, state_of(stop, t).moved_s * move.frame_rate().frames_per_second());
      }
      const std::vector<double> exact = positions_of(table, time);
      for (std::size_t i = 0; i < exact.size(); ++i) {
        const double told = stopped[tick][table.motors.size() + i];
        RC_ASSERT(std::fabs(told - exact[i]) <=
                  1e-9 * (std::fabs(exact[i]) + std::fabs(exact[i] - lines[0][table.motors.size() + i])));
      }
    }
  });
}

}  // namespace trajectory_table_property_test
}  // namespace inbetween
