#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>
#include <vector>

#include "host_tools/plan/fitted_trajectory.hpp"
#include "inbetween/limits/played_motion.hpp"
#include "inbetween/limits/stop_bounds.hpp"
#include "tests/support/bounded_cells.hpp"
#include "tests/support/oracle_stop.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random_move.hpp"
#include "tests/support/solved_move.hpp"

/// Stops from anywhere, in any permitted state, against the limits of every axis by the exact derivatives.

namespace inbetween {
namespace stop_bounds_property_test {

constexpr double fps = 24;
constexpr int steps_of_a_stop = 1500;

FrameTime frame_time(double u) {
  const double frame = std::floor(u * fps);
  return {static_cast<std::int32_t>(frame), std::min(u * fps - frame, 1 - 1e-16)};
}

oracle::PlayheadRule rule_of(const StopBounds& bounds, double cell_seconds, bool forward) {
  const auto at = [&bounds](double u) {
    const StopBound bound = bounds.at(frame_time(u));
    return oracle::PlayheadBound{bound.rate_change, bound.rate_jerk, bound.release_jerk};
  };
  return {at, cell_seconds, bounds.rate(), forward};
}

int any_int(int from, int below) {
  return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(from, below));
}
double any_share() {
  return any_int(0, 1'000'001) * 1e-6;
}

/// A solved move, or any part of it, with the rolls that it needs, of any length.
struct PlayedMove {
  TrackInput input;
  SolvedTrack solution;
  WholeFrames part;
  std::vector<RollAxis> before, after;
  std::optional<Move> move;
  std::optional<FittedTrajectory> fitted;
  std::optional<Trajectory> trajectory;
  std::optional<PlayedMotion> motion;
  std::vector<AxisPeaks> peaks;

  explicit PlayedMove(const RandomMove& random)
      : input(random), solution(input.spec, Solver::closed_form), part{0, random.frames} {
    if (random.frames > 1 && any_int(0, 2) == 0) {
      part.first = any_int(0, random.frames);
      part.last = any_int(part.first + 1, random.frames + 1);
    }
    RC_LOG() << "frames " << part.first << ".." << part.last << "\n";
    peaks = bounds_of_track(track(), part).peaks();
    fitted.emplace(track());
    trajectory = **fitted;
    if (!roll(RollEnd::before, before) || !roll(RollEnd::after, after)) return;
    move = *Move::make({&solution.track(), 1}, {before, after}, part);
    motion = PlayedMotion::make(*move, {&*trajectory, 1}).value();
  }
  const Track& track() const { return solution.track(); }

 private:
  bool roll(RollEnd end, std::vector<RollAxis>& out) {
    std::vector<AxisMotion> joints(peaks.size());
    if (!joints_of_part({&solution.track(), 1}, {&*trajectory, 1}, part, end, joints)) return true;
    const RollSpan span{end, end == RollEnd::before ? part.first : part.last, any_int(4, 60), {24, 1}};
    for (std::size_t d = 0; d < peaks.size(); ++d) {
      const auto axis = RollAxis::make(span, joints[d]);
      if (!axis) return false;
      out.push_back(*axis);
      for (auto quantity : {&AxisPeaks::velocity, &AxisPeaks::acceleration, &AxisPeaks::jerk}) {
        (peaks[d].*quantity).value = std::max((peaks[d].*quantity).value, (axis->peaks().*quantity).value);
      }
    }
    return true;
  }
};

/// Stop limits a little above the peaks, with and without jerk; none where a peak has no bound.
std::vector<AxisLimits> limits_near(const std::vector<AxisPeaks>& peaks, double rate) {
  std::vector<AxisLimits> limits;
  const bool with_jerk = any_int(0, 3) > 0;
  const auto above = [](double peak) { return peak > 0 ? peak * (1.05 + 0.95 * any_share()) : 1.0; };
  for (const AxisPeaks& axis : peaks) {
    AxisLimitsSpec spec{.min = -1e119, .max = 1e119};
    spec.max_velocity = above(axis.velocity.value);
    spec.max_acceleration =
        above(std::max(axis.acceleration.value * rate * rate, 0.1 * axis.velocity.value * rate));
    spec.stop_acceleration = spec.max_acceleration;
    if (with_jerk) {
      spec.max_jerk =
          above(std::max(axis.jerk.value * rate * rate * rate, 0.1 * spec.max_acceleration * rate));
      spec.stop_jerk = spec.max_jerk;
    }
    const auto made = AxisLimits::make(spec);
    if (!made) return {};
    limits.push_back(*made);
  }
  return limits;
}

struct Counts {
  int moves = 0, parts = 0, refused = 0, unbounded = 0, stops = 0;
  long steps = 0;
  double nearest_acceleration = 0, nearest_jerk = 0, nearest_seconds = 0, nearest_frames = 0;
};

/// What the axes do under the playhead, against their limits.
class AxesUnderPlayhead {
 public:
  AxesUnderPlayhead(const PlayedMotion& move, const std::vector<AxisLimits>& limits, Counts& counts)
      : move_(move), limits_(limits), counts_(counts), motion_(limits.size()) {}

  void operator()(const oracle::PlayheadStep& step) {
    RC_ASSERT(std::fabs(step.change) <= step.max_change * (1 + 1e-9));
    if (!(std::fabs(step.jerk) <= step.max_jerk * (1 + 2e-6))) {
      RC_LOG() << "jerk " << step.jerk << " above " << step.max_jerk << " at u " << step.u << "\n";
      RC_FAIL("a jerk above R2");
    }
    ++counts_.steps;
    move_.motion(frame_time(step.u), motion_);
    const double r = step.rate;
    for (std::size_t d = 0; d < limits_.size(); ++d) {
      const AxisMotion& p = motion_[d];
      const double acceleration = std::fabs(p.acceleration * r * r + p.velocity * step.change);
      keep(d, "acceleration", acceleration, limits_[d].stop_acceleration(), counts_.nearest_acceleration,
           step);
      if (!limits_[d].stop_jerk()) continue;
      const double jerk =
          std::fabs(p.jerk * r * r * r + 3 * p.acceleration * r * step.change + p.velocity * step.jerk);
      keep(d, "jerk", jerk, *limits_[d].stop_jerk(), counts_.nearest_jerk, step);
    }
  }

 private:
  static void keep(std::size_t d, const char* what, double value, double limit, double& nearest,
                   const oracle::PlayheadStep& step) {
    nearest = std::max(nearest, value / limit);
    if (value <= limit * (1 + 3e-6)) return;
    RC_LOG() << what << " of axis " << d << ": " << value << " above " << limit << " at u " << step.u
             << ", r " << step.rate << ", a " << step.change << ", j " << step.jerk << "\n";
    RC_FAIL("a stop limit is broken");
  }

  const PlayedMotion& move_;
  const std::vector<AxisLimits>& limits_;
  Counts& counts_;
  std::vector<AxisMotion> motion_;
};

/// Anywhere, forward or reverse, in any permitted state; often at its border.
oracle::PlayheadState any_state(const Move& move, const StopBounds& bounds) {
  oracle::PlayheadState state;
  state.u = (move.first_frame() + any_share() * (move.last_frame() - move.first_frame())) / fps;
  state.rate = bounds.rate() * (any_int(0, 3) == 0 ? 1 : any_share());
  const StopBound bound = bounds.at(frame_time(state.u));
  const bool braking = any_int(0, 2) == 0;
  const double room = braking ? state.rate : bounds.rate() - state.rate;
  const double most = std::min(bound.rate_change, std::sqrt(2 * room * bound.release_jerk)) * (1 - 1e-12);
  state.change = (braking ? -1 : 1) * most * (any_int(0, 3) == 0 ? any_share() : 1);
  return state;
}

void brake_to_rest(oracle::PlayheadState& state, const StopBounds& bounds, double cell_seconds, bool forward,
                   AxesUnderPlayhead& axes, Counts& counts) {
  const StopLength predicted = bounds.stop_from(frame_time(state.u), forward);
  const oracle::StoppingPlayhead playhead(rule_of(bounds, cell_seconds, forward),
                                          predicted.seconds / steps_of_a_stop);
  const double begin = state.u;
  double seconds = 0;
  while (state.rate > 0 || state.change > 0) {
    const double taken = playhead.step(state, false, std::ref(axes));
    if (taken == 0) {
      const StopBound bound = bounds.at(frame_time(state.u));
      RC_LOG() << "no way on at u " << state.u << ", r " << state.rate << ", a " << state.change << "; R1 "
               << bound.rate_change << ", R2 " << bound.rate_jerk << ", Q " << bound.release_jerk << "\n";
      RC_FAIL("not viable");
    }
    seconds += taken;
    RC_ASSERT(seconds <= 1.005 * predicted.seconds);
  }
  RC_ASSERT(state.rate == 0 && state.change == 0);
  const double frames = std::fabs(state.u - begin) * fps;
  RC_ASSERT(frames <= 1.005 * predicted.frames);
  counts.nearest_seconds = std::max(counts.nearest_seconds, seconds / predicted.seconds);
  counts.nearest_frames = std::max(counts.nearest_frames, frames / predicted.frames);
  ++counts.stops;
}

/// A stop; or a stop that is taken back half-way, once or twice, and then goes through.
void stop_once(const PlayedMove& played, const std::vector<AxisLimits>& limits, const StopBounds& bounds,
               double cell_seconds, Counts& counts) {
  const bool forward = any_int(0, 2) == 0;
  const oracle::PlayheadState begin = any_state(*played.move, bounds);
  const double seconds = bounds.stop_from(frame_time(begin.u), forward).seconds;
  const oracle::StoppingPlayhead playhead(rule_of(bounds, cell_seconds, forward), seconds / steps_of_a_stop);
  AxesUnderPlayhead axes(*played.motion, limits, counts);
  oracle::PlayheadState state = begin;
  RC_LOG() << "from u " << state.u << ", r " << state.rate << ", a " << state.change
           << (forward ? "" : ", reverse") << "\n";
  for (int turn = any_int(0, 3); turn > 0; --turn) {
    for (const bool speeding_up : {false, true}) {
      for (int i = any_int(1, steps_of_a_stop / 2);
           i > 0 && (state.rate > 0 || state.change > 0 || speeding_up); --i) {
        if (playhead.step(state, speeding_up, std::ref(axes)) == 0) RC_FAIL("not viable before the stop");
      }
    }
  }
  brake_to_rest(state, bounds, cell_seconds, forward, axes, counts);
}

TEST(StopBoundsProperty, EveryStopKeepsTheStopLimitsAndEndsWherePredicted) {
  Counts counts;
  check_property(1000, [&] {
    const RandomMove random = *regular_move();
    std::ostringstream text;
    showValue(random, text);
    RC_LOG() << text.str();
    const PlayedMove played(random);
    if (!played.move || played.track().arc_length().total() == 0) return;
    const double rate = any_int(0, 2) == 0 ? 1 : 0.25 + 1.75 * any_share();
    const std::vector<AxisLimits> limits = limits_near(played.peaks, rate);
    if (limits.empty()) {
      ++counts.unbounded;
      return;
    }
    const auto cells = static_cast<std::size_t>(any_int(1, 300));
    std::vector<StopCell> stop_cells(cells + 1);
    std::vector<AxisPeaks> stop_peaks(limits.size());
    const BoundedMove bounded =
        bounded_cells(*played.move, {&played.track(), 1}, limits, cells, rate, 1.0 / 250);
    const auto bounds = StopBounds::make({bounded.cells(), limits, rate}, stop_cells, stop_peaks);
    ++counts.moves;
    if (played.part.last - played.part.first < random.frames) ++counts.parts;
    if (!bounds) {
      RC_ASSERT(bounds.error().code == ErrorCode::no_solution);
      ++counts.refused;
      return;
    }
    for (std::size_t d = 0; d < limits.size(); ++d) {
      RC_ASSERT(stop_peaks[d].acceleration.value <= limits[d].stop_acceleration() * (1 + 1e-9));
      if (limits[d].stop_jerk()) RC_ASSERT(stop_peaks[d].jerk.value <= *limits[d].stop_jerk() * (1 + 1e-9));
    }
    const double cell_seconds =
        (played.move->last_frame() - played.move->first_frame()) / fps / static_cast<double>(cells);
    for (int i = 0; i < 4; ++i) stop_once(played, limits, *bounds, cell_seconds, counts);
  });
  std::cout << counts.moves << " moves, " << counts.parts << " of them parts, " << counts.refused
            << " refused, " << counts.unbounded << " unbounded; " << counts.stops << " stops of "
            << counts.steps << " steps; at most " << counts.nearest_acceleration << " of the acceleration, "
            << counts.nearest_jerk << " of the jerk, " << counts.nearest_seconds << " of the time, "
            << counts.nearest_frames << " of the frames\n";
  if (!counts_mean_something()) return;
  EXPECT_GE(counts.parts, counts.moves / 5);
  EXPECT_LE(counts.refused, counts.moves / 10);
  EXPECT_GE(counts.nearest_acceleration, 0.9);
  EXPECT_GE(counts.nearest_jerk, 0.9);
  EXPECT_GE(counts.nearest_seconds, 0.5);
}

}  // namespace stop_bounds_property_test
}  // namespace inbetween
