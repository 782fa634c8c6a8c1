#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/check/check_frames.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "tests/support/bounded_cells.hpp"
#include "tests/support/oracle_rest.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random_move.hpp"
#include "tests/support/solved_move.hpp"

/// The certificate of moves whose path stands still or turns back, against a dense search in long double: not
/// 1 % above the truth, never below it, and nothing is refused that is 1 % below its limits.

namespace inbetween {
namespace turning_move_property_test {

constexpr int many_moves = 60;
constexpr double closeness = 1.01;
/// By which a search may miss a peak, or the rounding of the product may move it.
constexpr double search_rounding = 1e-6;

RigFile rig_with(const std::vector<std::string>& axes) {
  RigFile rig{.path = "rig.toml", .name = "rig", .rate_hz = 250, .buses = {}, .axes = {}};
  for (const std::string& name : axes) {
    RigAxis axis;
    axis.name = name;
    axis.min = -1e6;
    axis.max = 1e6;
    axis.max_velocity = axis.max_acceleration = 1e12;
    rig.axes.push_back(axis);
  }
  return rig;
}

std::optional<Plan> planned(const MoveFile& move, const RigFile& rig) {
  try {
    return Plan(move, rig, {});
  } catch (const InputError&) {  // a hold for which the speed curve has no room
    return std::nullopt;
  }
}

struct Allowed {
  double most = closeness;  ///< times what is found
  double noise = 0;
  bool may_be_unbounded = false;
  double share = 0;  ///< so near is what plays to what is asked
  bool is_resolved =
      true;  ///< no turn takes less than a ten-millionth of the move, where what plays may differ
};

/// Of the velocity, the acceleration and the jerk.
constexpr std::array near_enough{1e-6, 1e-4, 3e-3};

/// The most that a bound was above what was found, of all that are no noise.
double worst_ratio = 0;

void expect_tight(const char* what, double bound, const oracle::Found& found, const Allowed& allowed) {
  RC_LOG() << what << ": bound " << bound << ", found " << static_cast<double>(found.value) << " to "
           << static_cast<double>(found.most) << " at frame " << static_cast<double>(found.frame) << '\n';
  if (!allowed.is_resolved) return;
  RC_ASSERT(bound >=
            static_cast<double>(found.value) * (1 - search_rounding - allowed.share) - allowed.noise);
  if (allowed.may_be_unbounded && std::isinf(bound)) return;
  RC_ASSERT(bound <= static_cast<double>(found.most) * allowed.most * (1 + search_rounding) + allowed.noise);
  if (static_cast<double>(found.most) > 1e3 * allowed.noise && allowed.most == closeness) {
    worst_ratio = std::max(worst_ratio, (bound - allowed.noise) / static_cast<double>(found.most));
  }
}

TEST(TurningMoveProperty, IsRefusedForWhatItDoesAndForNothingElse) {
  int compared = 0;
  int unbounded = 0;
  int rested = 0;
  int unresolved = 0;
  check_property(many_moves, [&] {
    const RandomMove random = *turning_move();
    RC_LOG() << as_toml(random);
    const std::optional<MoveFile> move = [&]() -> std::optional<MoveFile> {
      try {
        return parse_move(as_toml(random), "move.toml");
      } catch (const InputError&) {
        return std::nullopt;
      }
    }();
    if (!move) return;
    RigFile rig = rig_with(move->tracks[0].axes);
    const std::optional<Plan> plan = planned(*move, rig);
    if (!plan || plan->tracks()[0].track().arc_length().total() == 0) return;
    const std::optional<std::vector<oracle::MetKey>> met = met_keys(random, plan->tracks()[0]);
    RC_ASSERT(met.has_value());
    oracle::RestingMotion motion(random.keys, plan->tracks()[0].control_values(), random.frames, 24, *met);
    const std::vector<oracle::RestPeaks> truth = motion.peaks();
    const Track& track = plan->tracks()[0].track();
    const BoundedMove bounded = bounds_of_track(track);
    const std::vector<AxisPeaks>& peaks = bounded.peaks();
    ++compared;
    long double quickest = 0;
    long double hardest = 0;
    long double roughest = 0;
    for (const oracle::RestPeaks& axis : truth) {
      quickest = std::max(quickest, axis.velocity.value);
      hardest = std::max(hardest, axis.acceleration.value);
      roughest = std::max(roughest, axis.jerk.most);
    }
    const bool resolved = !(hardest < 1e-7L * random.frames / 24 * roughest);
    if (!resolved) ++unresolved;
    const double noise = 1e-9 * static_cast<double>(quickest);
    const double rate = track.curve_rate();
    for (std::size_t d = 0; d < truth.size(); ++d) {
      RC_LOG() << "axis " << d << '\n';
      const bool passes = motion.passes_standstill();
      expect_tight("velocity", peaks[d].velocity.value, truth[d].velocity,
                   {closeness, noise, false, near_enough[0], resolved});
      expect_tight("acceleration", peaks[d].acceleration.value, truth[d].acceleration,
                   {closeness, noise * rate, passes, near_enough[1], resolved});
      expect_tight("jerk", peaks[d].jerk.value, truth[d].jerk,
                   {closeness, noise * rate * rate, passes, near_enough[2], resolved});
      rig.axes[d].max_velocity = std::max(closeness * static_cast<double>(truth[d].velocity.value), 1e-3);
      rig.axes[d].max_acceleration =
          std::max(closeness * static_cast<double>(truth[d].acceleration.value), 1e-3);
    }
    const bool steps =
        std::ranges::any_of(random.times, [](const RandomKeyTime& time) { return time.break_frame >= 0; });
    if (motion.passes_standstill()) ++unbounded;
    if (motion.passes_standstill() || steps || !resolved) return;
    if (random.speed[1] > 0 || random.speed[random.speed.size() - 2] > 0) return;  // its rolls need more
    ++rested;
    const Plan limited(*move, rig, {});
    const CheckReport report = check(limited);
    for (const CheckRefusal& refusal : report.refusals) RC_LOG() << refusal.message() << '\n';
    RC_ASSERT(report.fits());
    const SmallestFrames smallest = smallest_frames(limited, report, {});
    RC_ASSERT(smallest.frames.has_value());
  });
  std::cout << compared << " compared, " << unbounded << " pass a standstill at a speed, " << rested
            << " fit just below their limits, in " << unresolved
            << " a peak is narrower than time is known; a bound is at most " << worst_ratio
            << " of what was found\n";
  if (!counts_mean_something()) return;
  EXPECT_GT(compared, many_moves / 2);
  EXPECT_GT(rested, many_moves / 5);
}

// --- rests between keys

/// Keys on a line, to and fro: a spline through them turns back inside its segments. `corners = "ease"`
/// brings the speed to 0 there.
struct LineMove {
  oracle::Keys keys;
  std::string toml;
  int frames = 0;
};

int any_int(int from, int below) {
  return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(from, below));
}

LineMove line_move() {
  const auto axes = static_cast<std::size_t>(any_int(1, 4));
  const auto count = static_cast<std::size_t>(any_int(3, 6));
  LineMove move;
  move.frames = any_int(96, 400);
  std::vector<long double> direction;
  for (std::size_t d = 0; d < axes; ++d) {
    direction.push_back(any_int(1, 64) / 16.0L);
    move.keys.weights.push_back(any_int(1, 9) / 4.0L);
  }
  std::string at_keys;
  int place = 0;
  for (std::size_t k = 0; k < count; ++k) {
    int step = any_int(-40, 41);
    if (k > 0 && step == 0) step = 7;
    place += k == 0 ? 0 : step;
    std::vector<long double> at;
    std::string numbers;
    for (std::size_t d = 0; d < axes; ++d) {
      at.push_back(place * direction[d]);
      numbers += (d > 0 ? ", " : "") + std::to_string(static_cast<double>(at.back()));
    }
    move.keys.at.push_back(at);
    at_keys += "  { at = [" + numbers + "] },\n";
  }
  std::string names;
  std::string weights;
  for (std::size_t d = 0; d < axes; ++d) {
    names += (d > 0 ? ", \"x" : "\"x") + std::to_string(d) + "\"";
    weights += (d > 0 ? ", " : "") + std::to_string(static_cast<double>(move.keys.weights[d]));
  }
  move.toml = "name = \"to and fro\"\nfps = 24\nframes = " + std::to_string(move.frames) +
              "\n[[track]]\naxes = [" + names + "]\nkeys = [\n" + at_keys +
              "]\ncorners = \"ease\"\nweights = [" + weights +
              "]\nspeed = [0, 0, 6, 9, 7, 5, 8, 9, 6, 7, 6, 0, 0]\n";
  return move;
}

/// The knot on which the curve rests where it has come so far.
std::optional<int> rest_at(const std::vector<double>& values, long double share) {
  const oracle::Profile profile(values);
  const auto f = static_cast<int>(values.size()) - 1;
  for (int knot = 1; knot < f; ++knot) {
    const auto v = static_cast<std::size_t>(knot);
    if (values[v - 1] != 0 || values[v] != 0 || values[v + 1] != 0) continue;
    if (std::fabs(profile.integral(knot) / profile.integral(f) - share) < 1e-9L) return knot;
  }
  return std::nullopt;
}

TEST(TurningMoveProperty, ARestInsideASegmentIsBoundedByItsMotionOverTime) {
  int compared = 0;
  int inside = 0;
  worst_ratio = 0;
  check_property(many_moves, [&] {
    const LineMove line = line_move();
    RC_LOG() << line.toml;
    const MoveFile move = parse_move(line.toml, "move.toml");
    const std::optional<Plan> plan = planned(move, rig_with(move.tracks[0].axes));
    if (!plan) return;
    const std::vector<double>& values = plan->tracks()[0].control_values();
    oracle::RestingMotion motion(line.keys, values, line.frames, 24, {});
    const oracle::Path path(line.keys);
    std::vector<oracle::MetKey> met;
    const auto meet = [&](oracle::MetKey place) {
      const long double distance = path.travelled({0, 0}, {place.key, place.t});
      const std::optional<int> knot = rest_at(values, distance / path.total_length());
      if (!knot) return false;
      place.alpha = *knot;
      met.push_back(place);
      return true;
    };
    std::vector<oracle::MetKey> places = motion.standstills();
    RC_ASSERT(std::ranges::all_of(places, meet));
    if (places.empty()) return;
    inside += static_cast<int>(places.size());
    motion.meet(met);
    const std::vector<oracle::RestPeaks> truth = motion.peaks();
    RC_ASSERT(!motion.passes_standstill());
    const BoundedMove bounded = bounds_of_track(plan->tracks()[0].track());
    const std::vector<AxisPeaks>& peaks = bounded.peaks();
    ++compared;
    const double rate = plan->tracks()[0].track().curve_rate();
    for (std::size_t d = 0; d < truth.size(); ++d) {
      RC_LOG() << "axis " << d << '\n';
      const double noise = 1e-9 * static_cast<double>(truth[d].velocity.value);
      expect_tight("velocity", peaks[d].velocity.value, truth[d].velocity,
                   {closeness, noise, false, near_enough[0]});
      expect_tight("acceleration", peaks[d].acceleration.value, truth[d].acceleration,
                   {closeness, noise * rate, false, near_enough[1]});
      expect_tight("jerk", peaks[d].jerk.value, truth[d].jerk,
                   {closeness, noise * rate * rate, false, near_enough[2]});
    }
  });
  std::cout << compared << " compared, with " << inside << " rests inside a segment; a bound is at most "
            << worst_ratio << " of what was found\n";
  if (!counts_mean_something()) return;
  EXPECT_GT(compared, many_moves / 6);
}

}  // namespace turning_move_property_test
}  // namespace inbetween
