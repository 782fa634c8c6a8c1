#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iostream>
#include <ostream>
#include <stdexcept>
#include <vector>

#include "host_tools/plan/smoothest_pace.hpp"
#include "host_tools/plan/solved_track.hpp"
#include "inbetween/timing/track.hpp"
#include "tests/support/bounded_cells.hpp"
#include "tests/support/oracle_curves.hpp"
#include "tests/support/oracle_pace.hpp"
#include "tests/support/oracle_path.hpp"
#include "tests/support/property.hpp"
#include "tests/support/sided_derivatives.hpp"

/// Random moves with timing = "frames", on every path and with every kinetic.

namespace inbetween {
namespace key_frames_property_test {

struct TimedMove {
  Spline spline = Spline::smooth;
  Kinetic kinetic = Kinetic::curves;
  bool pace = false;
  bool closed = false;
  bool overshoot = true;
  bool rests_at_start = true;
  bool rests_at_end = true;
  std::int32_t axes = 1;
  std::vector<double> keys;
  std::vector<KeyShape> shapes;
  std::vector<std::int32_t> frames;

  [[nodiscard]] std::size_t key_count() const { return keys.size() / static_cast<std::size_t>(axes); }
  [[nodiscard]] double at(std::size_t key, std::int32_t axis) const {
    return keys[key % key_count() * static_cast<std::size_t>(axes) + static_cast<std::size_t>(axis)];
  }
  [[nodiscard]] double range(std::int32_t axis) const {
    double low = at(0, axis);
    double high = low;
    for (std::size_t k = 0; k < key_count(); ++k) {
      low = std::min(low, at(k, axis));
      high = std::max(high, at(k, axis));
    }
    return high - low;
  }
  [[nodiscard]] SolvedTrack solved() const {
    return {{.path = {.spline = spline,
                      .closed = closed,
                      .axis_count = axes,
                      .keys = keys,
                      .shapes = shapes,
                      .overshoot = overshoot},
             .control_values = {},
             .frames = frames.back(),
             .fps = {24, 1},
             .arc_length = {},
             .key_frames = frames,
             .kinetic = kinetic,
             .pace = pace,
             .rests_at_start = rests_at_start,
             .rests_at_end = rests_at_end},
            Solver::closed_form};
  }
};

void showValue(const TimedMove& move, std::ostream& out) {
  out << "spline " << static_cast<int>(move.spline) << ", kinetic " << static_cast<int>(move.kinetic)
      << (move.closed ? ", closed" : "") << ", rest " << move.rests_at_start << move.rests_at_end
      << "; frames";
  for (const std::int32_t frame : move.frames) out << " " << frame;
  out << "; keys of " << move.axes << " axes";
  for (const double key : move.keys) out << " " << key;
}

/// Keys 1 to 48 frames apart; now and then an axis, or all, keeps its value from key to key.
TimedMove random_timed_move(Spline spline) {
  TimedMove move;
  move.spline = spline;
  move.axes = *rc::gen::inRange(1, 4);
  const int count = *rc::gen::inRange(2, 9);
  move.closed = count > 2 && *rc::gen::inRange(0, 4) == 0;
  move.rests_at_start = *rc::gen::arbitrary<bool>();
  move.rests_at_end = *rc::gen::arbitrary<bool>();
  move.frames = {0};
  for (int k = 0; k < count; ++k) {
    for (std::int32_t d = 0; d < move.axes; ++d) {
      const bool keeps = k > 0 && *rc::gen::inRange(0, 5) == 0;
      const double value = *rc::gen::inRange(-1000, 1000) / 8.0;
      move.keys.push_back(keeps ? move.keys[move.keys.size() - static_cast<std::size_t>(move.axes)] : value);
    }
    const auto one = [] { return *rc::gen::inRange(-10, 11) / 10.0; };
    if (spline == Spline::tcb) move.shapes.push_back({.tension = one(), .continuity = 0, .bias = one()});
    if (k + 1 < count || move.closed) move.frames.push_back(move.frames.back() + *rc::gen::inRange(1, 49));
  }
  return move;
}

/// The farthest that an axis is from a key on its frame, as a share of what it goes between its keys.
double worst_miss(const TimedMove& move, const SolvedTrack& track) {
  double worst = 0;
  std::vector<double> position(static_cast<std::size_t>(move.axes));
  for (std::size_t k = 0; k < move.frames.size(); ++k) {
    track.track().positions({move.frames[k], 0}, position);
    for (std::int32_t d = 0; d < move.axes; ++d) {
      const double miss = std::fabs(position[static_cast<std::size_t>(d)] - move.at(k, d));
      worst = std::max(worst, miss / (move.range(d) + 1e-3));
    }
  }
  return worst;
}

void expect_keys_met(const TimedMove& move, const SolvedTrack& track) {
  RC_ASSERT(worst_miss(move, track) <= 1e-9);
}

void expect_no_steps(const TimedMove& move, const SolvedTrack& track, bool of_acceleration) {
  for (std::int32_t d = 0; d < move.axes; ++d)
    inbetween::expect_no_steps(track, d, move.range(d) + std::fabs(move.at(0, d)), of_acceleration);
}

TEST(KeyFramesProperty, SmoothCurvesMeetTheirKeysAreC2InTimeAndThoseOfAnIndependentSolver) {
  check_property(500, [] {
    const TimedMove move = random_timed_move(Spline::smooth);
    const SolvedTrack track = move.solved();
    expect_keys_met(move, track);
    expect_no_steps(move, track, true);
    for (std::int32_t d = 0; d < move.axes; ++d) {
      oracle::TimedKeys keys{.at = {},
                             .frames = {},
                             .rests_at_start = move.rests_at_start,
                             .rests_at_end = move.rests_at_end,
                             .periodic = move.closed && !move.rests_at_start && !move.rests_at_end};
      for (std::size_t k = 0; k < move.frames.size(); ++k) {
        keys.at.push_back(static_cast<long double>(move.at(k, d)));
        keys.frames.push_back(static_cast<long double>(move.frames[k]));
      }
      const std::vector<oracle::TimedPiece> curve = oracle::smooth_curve(keys);
      std::vector<AxisMotion> motion(static_cast<std::size_t>(move.axes));
      const double velocity = largest(track, d, &AxisMotion::velocity) + 1e-3;
      for (std::int32_t i = 0; i < 4 * move.frames.back(); ++i) {
        track.track().motion({i / 4, i % 4 / 4.0}, motion);
        const AxisMotion& axis = motion[static_cast<std::size_t>(d)];
        const long double frame = static_cast<long double>(i) / 4;
        RC_ASSERT(std::fabs(axis.position - static_cast<double>(oracle::curve_at(curve, frame, 0))) <=
                  1e-10 * (velocity + move.range(d)));
        RC_ASSERT(std::fabs(axis.velocity / 24 - static_cast<double>(oracle::curve_at(curve, frame, 1))) <=
                  1e-9 * velocity);
      }
    }
  });
}

/// How a move goes from key to key, as its file says it.
struct Timing {
  const char* kinetic;
  Kinetic of_core = Kinetic::curves;
  bool pace = false;
};

TEST(KeyFramesProperty, OnEveryPathAndWithEveryKineticKeysAreMetOnTheirFrames) {
  constexpr std::array timings = {Timing{"curves"}, Timing{"pace", Kinetic::linear, true},
                                  Timing{"monotone", Kinetic::monotone}, Timing{"linear", Kinetic::linear}};
  for (const Spline spline : {Spline::smooth, Spline::catmull_rom, Spline::tcb, Spline::linear}) {
    for (const Timing& timing : timings) {
      if (spline == Spline::linear && timing.of_core == Kinetic::curves) continue;  // it has none
      double worst = 0;
      check_property(500, [&] {
        TimedMove move = random_timed_move(spline);
        move.kinetic = timing.of_core;
        move.pace = timing.pace;
        worst = std::max(worst, worst_miss(move, move.solved()));
        RC_ASSERT(worst <= 1e-9);
      });
      std::cout << "spline " << static_cast<int>(spline) << ", " << timing.kinetic << ": at most " << worst
                << " of the range from a key\n";
    }
  }
}

TEST(KeyFramesProperty, CurvesOnCatmullRomAndTcbMeetTheirKeysAndTheirVelocityGoesOn) {
  check_property(500, [] {
    const TimedMove move = random_timed_move(*rc::gen::element(Spline::catmull_rom, Spline::tcb));
    const SolvedTrack track = move.solved();
    expect_keys_met(move, track);
    expect_no_steps(move, track, false);
  });
}

TEST(KeyFramesProperty, AnAxisThatKeepsItsValueDoesNotLeaveIt) {
  check_property(500, [] {
    TimedMove move = random_timed_move(*rc::gen::element(Spline::smooth, Spline::catmull_rom, Spline::tcb));
    move.overshoot = move.spline == Spline::tcb || *rc::gen::arbitrary<bool>();
    const SolvedTrack track = move.solved();
    std::vector<double> position(static_cast<std::size_t>(move.axes));
    for (std::size_t k = 0; k + 1 < move.frames.size(); ++k) {
      for (std::int32_t i = 4 * move.frames[k]; i <= 4 * move.frames[k + 1]; ++i) {
        track.track().positions({i / 4, i % 4 / 4.0}, position);
        for (std::int32_t d = 0; d < move.axes; ++d) {
          const double low = std::min(move.at(k, d), move.at(k + 1, d));
          const double high = std::max(move.at(k, d), move.at(k + 1, d));
          if (low != high && move.overshoot) continue;
          const double rounding = move.overshoot ? 1e-12 * (move.range(d) + std::fabs(low)) : 0;
          RC_ASSERT(position[static_cast<std::size_t>(d)] >= low - rounding);
          RC_ASSERT(position[static_cast<std::size_t>(d)] <= high + rounding);
        }
      }
    }
  });
}

/// Between its keys every axis stays within their values to the last bit, with a drawn speed as well.
TEST(KeyFramesProperty, APathWithoutOvershootStaysBetweenItsKeys) {
  check_property(500, [] {
    const TimedMove move = random_timed_move(*rc::gen::element(Spline::smooth, Spline::catmull_rom));
    std::vector<Cubic> cubics(move.keys.size() + static_cast<std::size_t>(move.axes));
    std::vector<double> weights(static_cast<std::size_t>(move.axes));
    const auto path = Path::make({.spline = move.spline,
                                  .closed = move.closed,
                                  .axis_count = move.axes,
                                  .keys = move.keys,
                                  .overshoot = false},
                                 {cubics, weights});
    RC_ASSERT(path.has_value());
    for (std::int32_t i = 0; i < path->segment_count(); ++i) {
      for (std::int32_t d = 0; d < move.axes; ++d) {
        const auto key = static_cast<std::size_t>(i);
        const double low = std::min(move.at(key, d), move.at(key + 1, d));
        const double high = std::max(move.at(key, d), move.at(key + 1, d));
        std::vector<PathPoint> points;
        for (int k = 0; k < 64; ++k) points.push_back({i, k / 64.0});
        for (int k = 1; k <= 64; ++k) points.push_back({i, 1 - std::ldexp(1.0, -k)});
        std::vector<double> positions(points.size() * static_cast<std::size_t>(move.axes));
        path->positions(points, positions);
        for (std::size_t k = 0; k < points.size(); ++k) {
          const double position = path->position(points[k], d);
          RC_ASSERT(position >= low);
          RC_ASSERT(position <= high);
          RC_ASSERT(positions[static_cast<std::size_t>(d) * points.size() + k] == position);
        }
      }
    }
  });
}

double velocity_step(const BoundedMove& bounded, std::size_t key, std::int32_t axis) {
  const auto found = std::ranges::find_if(bounded.steps(), [&](const MoveStep& step) {
    return step.key == static_cast<std::int32_t>(key) && step.axis == static_cast<std::size_t>(axis);
  });
  return found != bounded.steps().end() ? found->velocity : 0;
}

TEST(KeyFramesProperty, MonotoneAndLinearMeetTheirKeysAndTellTheirSteps) {
  check_property(500, [] {
    TimedMove move = random_timed_move(
        *rc::gen::element(Spline::smooth, Spline::catmull_rom, Spline::tcb, Spline::linear));
    move.kinetic = *rc::gen::element(Kinetic::linear, Kinetic::monotone);
    const SolvedTrack track = move.solved();
    expect_keys_met(move, track);
    if (move.kinetic != Kinetic::linear) return;  // only these are cubics of time
    const BoundedMove bounded = bounds_of_track(track.track());
    for (std::size_t k = 1; k + 1 < move.frames.size(); ++k) {
      const double frame = frame_of_segment(track.track(), static_cast<std::int32_t>(k));
      RC_ASSERT(frame == move.frames[k]);
      for (std::int32_t d = 0; d < move.axes; ++d) {
        const double before = (move.frames[k] - move.frames[k - 1]) / 4.0;
        const double behind = (move.frames[k + 1] - move.frames[k]) / 4.0;
        const double step =
            std::fabs(rediff(track, d, frame, behind).velocity - rediff(track, d, frame, -before).velocity);
        RC_ASSERT(std::fabs(step - velocity_step(bounded, k, d)) <= 1e-9 * (step + 100 * move.range(d)));
      }
    }
  });
}

/// The conditions under which a convex quadratic program is solved, written down from its definition and
/// checked densely: nothing is negative, every key is met, and the gradient is that of the rows wherever a
/// control value is above 0, and not below it where one is 0 (Karush, Kuhn and Tucker).
TEST(KeyFramesProperty, APaceMeetsItsKeysAndNoCurveThatDoesIsSmoother) {
  check_property(500, [] {
    TimedMove move = random_timed_move(
        *rc::gen::element(Spline::smooth, Spline::catmull_rom, Spline::tcb, Spline::linear));
    move.pace = true;
    RC_LOG() << testing::PrintToString(move.frames) << testing::PrintToString(move.keys) << move.axes
             << move.closed << move.rests_at_start << move.rests_at_end << static_cast<int>(move.spline);
    const SolvedTrack track = move.solved();
    expect_keys_met(move, track);
    if (!(track.track().arc_length().total() > 0)) return;
    const std::vector<double>& v = track.control_values();
    const std::size_t n = v.size();
    const auto f = static_cast<double>(n - 1);
    for (const double value : v) RC_ASSERT(value >= 0 && value <= 100);
    RC_ASSERT(!move.rests_at_start || (v[0] == 0 && v[1] == 0));
    RC_ASSERT(!move.rests_at_end || (v[n - 1] == 0 && v[n - 2] == 0));
    const auto bend = [&](std::size_t i) {
      return i == 0 || i + 1 == n ? 0 : v[i - 1] - 2 * v[i] + v[i + 1];
    };
    // Half the gradient of the integral of phi''^2: phi'' is linear between the bends.
    std::vector<double> gradient(n);
    double scale = 0;
    for (std::size_t i = 1; i + 1 < n; ++i) {
      const double g = (bend(i - 1) + 4 * bend(i) + bend(i + 1)) / 6;
      gradient[i - 1] += g;
      gradient[i] -= 2 * g;
      gradient[i + 1] += g;
      scale = std::max(scale, std::fabs(g));
    }
    // A curve with the same integrals that is nowhere negative is not smoother to first order: mix in that of
    // another polynomial speed through the same keys by moving area within each interval.
    for (std::size_t k = 0; k + 1 < move.frames.size(); ++k) {
      const double begin = move.frames[k] * f / move.frames.back();
      const double end = move.frames[k + 1] * f / move.frames.back();
      // Interior values of the interval, whose whole integral of 1 lies in it: area goes from one to another.
      std::vector<std::size_t> inside;
      for (std::size_t i = 2; i + 2 < n; ++i) {
        if (static_cast<double>(i) - 2 >= begin && static_cast<double>(i) + 2 <= end) inside.push_back(i);
      }
      for (const std::size_t from : inside) {
        for (const std::size_t to : inside) {
          const bool is_fixed = (move.rests_at_start && to <= 1) || (move.rests_at_end && to + 2 >= n);
          // What is nearly 0 may be 0: its own multiplier is not quite 0 then.
          if (v[from] <= 0.1 || is_fixed) continue;
          RC_ASSERT(gradient[to] - gradient[from] >= -1e-4 * scale - 1e-10);
        }
      }
    }
  });
}

/// The control values themselves, from an independent quadratic program.
TEST(KeyFramesProperty, APaceIsThatOfAnIndependentQuadraticProgram) {
  int compared = 0;
  check_property(40, [&] {
    const int count = *rc::gen::inRange(3, 6);
    std::vector<double> distances{0};
    std::vector<std::int32_t> frames{0};
    for (int k = 1; k < count; ++k) {
      distances.push_back(distances.back() + *rc::gen::inRange(1, 400) / 8.0);
      frames.push_back(frames.back() + *rc::gen::inRange(10, 31));
    }
    PaceSpec spec{.key_distances = distances,
                  .key_frames = frames,
                  .rests_at_start = *rc::gen::arbitrary<bool>(),
                  .rests_at_end = *rc::gen::arbitrary<bool>()};
    const std::vector<double> found = smoothest_pace(spec);
    RC_PRE(found.size() <= 80);  // the oracle is slow
    const auto f = static_cast<int>(found.size()) - 1;
    oracle::PaceProblem problem{.spans = f, .places = {}, .distances = {}, .is_zero = {}};
    problem.is_zero.assign(found.size(), 0);
    if (spec.rests_at_start) problem.is_zero[0] = problem.is_zero[1] = 1;
    if (spec.rests_at_end) problem.is_zero[found.size() - 1] = problem.is_zero[found.size() - 2] = 1;
    for (std::size_t k = 0; k < frames.size(); ++k) {
      problem.places.push_back(static_cast<long double>(frames[k]) * f / frames.back());
      problem.distances.push_back(distances[k]);
    }
    std::vector<long double> wanted;
    try {
      wanted = oracle::smoothest(problem);
    } catch (const std::runtime_error&) {
      RC_DISCARD("the oracle does not settle");  // rarely; how many it has judged is counted below
    }
    const auto largest = static_cast<double>(*std::max_element(wanted.begin(), wanted.end()));
    for (std::size_t i = 0; i < found.size(); ++i) {
      RC_ASSERT(std::fabs(found[i] - static_cast<double>(wanted[i]) / largest * 100) <= 1e-4);
    }
    std::vector<long double> scaled(found.begin(), found.end());
    for (long double& value : scaled) value *= static_cast<long double>(largest) / 100;
    RC_ASSERT(oracle::bending(scaled) <= oracle::bending(wanted) * (1 + 1e-8L) + 1e-10L);
    ++compared;
  });
  if (counts_mean_something()) {
    EXPECT_GE(compared, 20);
  }
}

/// Where the direction of the path goes on, so does the velocity under a pace; and of a smooth path, C2 in
/// distance, the acceleration.
TEST(KeyFramesProperty, APaceIsContinuousWhereTheDirectionOfThePathIs) {
  check_property(200, [] {
    TimedMove move;
    move.spline = *rc::gen::element(Spline::smooth, Spline::catmull_rom, Spline::tcb);
    move.pace = true;
    move.axes = 2;
    const int count = *rc::gen::inRange(3, 8);
    move.closed = *rc::gen::inRange(0, 4) == 0;
    move.frames = {0};
    // Keys round a circle, with a shake: no corner and no path back.
    for (int k = 0; k < count; ++k) {
      const double angle = (k + *rc::gen::inRange(-20, 21) / 100.0) * 6.28 / count;
      const double radius = *rc::gen::inRange(80, 121);
      move.keys.insert(move.keys.end(), {radius * std::cos(angle), radius * std::sin(angle)});
      if (move.spline == Spline::tcb) {
        move.shapes.push_back({.tension = *rc::gen::inRange(-5, 6) / 10.0, .continuity = 0, .bias = 0});
      }
      if (k + 1 < count || move.closed) move.frames.push_back(move.frames.back() + *rc::gen::inRange(12, 49));
    }
    const SolvedTrack track = move.solved();
    expect_keys_met(move, track);
    for (std::int32_t d = 0; d < move.axes; ++d) {
      const double velocity = largest(track, d, &AxisMotion::velocity);
      const double acceleration = largest(track, d, &AxisMotion::acceleration);
      for (std::size_t k = 1; k + 1 < move.frames.size(); ++k) {
        constexpr double step = 0.001;  // of a frame
        const Sided arriving = rediff(track, d, move.frames[k], -step);
        const Sided leaving = rediff(track, d, move.frames[k], step);
        RC_ASSERT(std::fabs(leaving.velocity - arriving.velocity) <= 1e-4 * velocity);
        if (move.spline != Spline::smooth) continue;
        RC_ASSERT(std::fabs(leaving.acceleration - arriving.acceleration) <= 0.02 * acceleration + 1e-3);
      }
    }
  });
}

/// ds / dframe on both sides of a key, and with it the step: for linear the secants, for monotone Fritsch and
/// Butland's harmonic mean, written down again from their paper.
TEST(KeyFramesProperty, TheStepsOfMonotoneAndLinearAreThoseOfTheOracle) {
  constexpr std::array kinds{oracle::Kind::smooth, oracle::Kind::catmull_rom, oracle::Kind::tcb,
                             oracle::Kind::linear};
  constexpr std::array splines{Spline::smooth, Spline::catmull_rom, Spline::tcb, Spline::linear};
  check_property(500, [&] {
    const auto kind = *rc::gen::inRange<std::size_t>(0, kinds.size());
    TimedMove move = random_timed_move(splines[kind]);
    move.kinetic = *rc::gen::element(Kinetic::linear, Kinetic::monotone);
    const SolvedTrack track = move.solved();
    oracle::Keys keys;
    keys.kind = kinds[kind];
    keys.closed = move.closed;
    for (std::size_t k = 0; k < move.key_count(); ++k) {
      std::vector<long double> at;
      for (std::int32_t d = 0; d < move.axes; ++d) at.push_back(move.at(k, d));
      keys.at.push_back(at);
      if (move.shapes.empty()) continue;
      const KeyShape& shape = move.shapes[k];
      keys.tension_continuity_bias.push_back({shape.tension, shape.continuity, shape.bias});
    }
    const oracle::Path path(keys);
    const auto interval = [&](std::size_t i) {
      return static_cast<long double>(move.frames[i + 1] - move.frames[i]);
    };
    const BoundedMove bounded = bounds_of_track(track.track());
    for (std::size_t k = 1; k + 1 < move.frames.size(); ++k) {
      long double before = 1 / interval(k - 1);
      long double behind = 1 / interval(k);
      if (move.kinetic == Kinetic::monotone) {
        const long double share = (interval(k - 1) + 2 * interval(k)) / (3 * (interval(k - 1) + interval(k)));
        before = behind = before * behind / (share * behind + (1 - share) * before);
      }
      const double frame = frame_of_segment(track.track(), static_cast<std::int32_t>(k));
      RC_ASSERT(frame == move.frames[k]);
      const auto segment = static_cast<int>(k);
      for (std::int32_t d = 0; d < move.axes; ++d) {
        const long double step = 24 * std::fabs(path.derivative(1, segment, 0, d) * behind -
                                                path.derivative(1, segment - 1, 1, d) * before);
        RC_ASSERT(std::fabs(static_cast<double>(step) - velocity_step(bounded, k, d)) <=
                  1e-9 * (static_cast<double>(step) + 24 * (move.range(d) + 1)));
      }
    }
  });
}

/// With a drawn speed, on paths full of corners and paths back.
TEST(KeyFramesProperty, CornersThatEaseDoNotStep) {
  int solved = 0;
  check_property(500, [&] {
    const TimedMove move =
        random_timed_move(*rc::gen::element(Spline::smooth, Spline::catmull_rom, Spline::linear));
    std::vector<double> speed = {0, 0};
    for (int i = *rc::gen::inRange(4, 12); i > 0; --i) speed.push_back(*rc::gen::inRange(10, 101) / 2.0);
    speed.insert(speed.end(), {0, 0});
    const TrackSpec spec{
        .path = {.spline = move.spline, .closed = move.closed, .axis_count = move.axes, .keys = move.keys},
        .control_values = speed,
        .frames = 240,
        .fps = {24, 1},
        .arc_length = {},
        .ease_corners = true};
    try {
      const SolvedTrack track(spec, Solver::closed_form);
      ++solved;
      double fastest = 0;
      for (std::int32_t frame = 0; frame <= 240; ++frame) {
        fastest = std::max(fastest, track.track().along({frame, 0}).speed);
      }
      const BoundedMove bounded = bounds_of_track(track.track());
      for (const MoveStep& step : bounded.steps()) RC_ASSERT(step.velocity <= 1e-6 * fastest);
    } catch (const SolverError&) {
      // Corners too near to each other for a curve of 4097 values: refused, and no move.
    }
  });
  if (counts_mean_something()) {
    EXPECT_GE(solved, 400);
  }
}

}  // namespace key_frames_property_test
}  // namespace inbetween
