// The certificate of trajectories against the one of tracks, for whatever a move and a rig may say.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "host_tools/check/played_bounds.hpp"
#include "host_tools/files/move_file.hpp"
#include "inbetween/limits/motion_bounds.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random_files.hpp"

namespace inbetween {
namespace played_bounds_property_test {

constexpr int many_files = 10'000;

/// Why the two may say different things.
struct Reasons {
  int turns_back = 0;  ///< a line that turns back at a speed: a step of the velocity, and no acceleration
  int uncounted = 0;   ///< an axis of weight 0 moves where the path stands still: tracks do not see it
  int loosened = 0;    ///< moves whose samples are rounded more than the tolerances of the fit
  int narrow = 0;      ///< a peak that lasts less than a ten-millionth of the move is rounded
  int compared = 0;
};

/// Of one track on the frames that are played, and of its rolls.
std::vector<AxisPeaks<double>> bounds_of_track(const Plan& plan, const Track<double>& track,
                                               std::size_t first) {
  const auto axes = static_cast<std::size_t>(track.path().axis_count());
  std::vector<AxisTurn<double>> turns(axes);
  std::vector<AxisPeaks<double>> peaks(axes);
  const std::vector<MotionTriple<double>> slack(axes);
  EXPECT_TRUE(bound_motion<double>(track, slack, {turns}, peaks, plan.part()).has_value());
  const MoveRolls<double>& rolls = plan.played().rolls();
  for (const std::span<const RollAxis<double>> roll : {rolls.before, rolls.after}) {
    for (std::size_t d = 0; d < axes && !roll.empty(); ++d) peaks[d].raise(roll[first + d].peaks());
  }
  return peaks;
}

bool has_uncounted_axis(const Track<double>& track) {
  const std::span<const double> weights = track.path().weights();
  return std::ranges::any_of(weights.first(static_cast<std::size_t>(track.path().axis_count())),
                             [](double weight) { return weight == 0; });
}

class Comparison {
 public:
  Comparison(const Plan& plan, const std::string& text, Reasons& reasons)
      : plan_(plan), text_(text), reasons_(reasons), played_(bound_played(plan)) {}

  void compare() {
    if (played_.loosened > 1) ++reasons_.loosened;
    std::size_t first = 0;
    for (const SolvedTrack<double>& solved : plan_.tracks()) {
      const std::vector<AxisPeaks<double>> peaks = bounds_of_track(plan_, solved.track(), first);
      is_uncounted_ = solved.track().has_profile() && has_uncounted_axis(solved.track());
      for (std::size_t d = 0; d < peaks.size(); ++d) compare(first + d, peaks[d]);
      first += peaks.size();
    }
  }

 private:
  void compare(std::size_t axis, const AxisPeaks<double>& track) {
    const AxisPeaks<double>& played = played_.axes[axis];
    const double size = std::max(std::fabs(track.lowest.value), std::fabs(track.highest.value));
    const double place = 1e-8 * (track.highest.value - track.lowest.value) + 1e-12 * size + 1e-12;
    EXPECT_NEAR(played.lowest.value, track.lowest.value, place) << text_;
    EXPECT_NEAR(played.highest.value, track.highest.value, place) << text_;
    const std::array<Peak<double>, 3> now{played.velocity, played.acceleration, played.jerk};
    const std::array<Peak<double>, 3> before{track.velocity, track.acceleration, track.jerk};
    const double seconds =
        (plan_.part().last - plan_.part().first) / plan_.played().frame_rate().frames_per_second();
    // A peak of the jerk that the acceleration is not worth mentioning beside, or of that beside the
    // velocity.
    const bool is_narrow = before[1].value < 1e-7 * seconds * before[2].value ||
                           before[0].value < 1e-7 * seconds * before[1].value;
    for (std::size_t q = 0; q < now.size(); ++q) {
      ++reasons_.compared;
      // What the rounding of the positions and of the peaks before makes of it on a piece of a frame.
      const double noise =
          1e-11 * (size + 1) *
          std::pow(plan_.played().frame_rate().frames_per_second(), static_cast<double>(q + 1));
      if (std::isinf(now[q].value) && std::isinf(before[q].value)) continue;
      if (std::isinf(before[q].value) && steps_at(axis, before[q].frame)) {
        ++reasons_.turns_back;
      } else if (std::isinf(now[q].value) && is_uncounted_) {
        ++reasons_.uncounted;
      } else if (std::fabs(now[q].value - before[q].value) <=
                     0.011 * std::max(now[q].value, before[q].value) + noise &&
                 std::isfinite(now[q].value) && std::isfinite(before[q].value)) {
        continue;
      } else if (is_narrow) {
        ++reasons_.narrow;
      } else {
        ADD_FAILURE() << "axis " << axis << ", derivative " << q + 1 << ": played " << now[q].value << " at "
                      << now[q].frame << ", track " << before[q].value << " at " << before[q].frame << '\n'
                      << text_;
      }
    }
  }
  [[nodiscard]] bool steps_at(std::size_t axis, double frame) const {
    return std::ranges::any_of(played_.steps, [&](const PlayedStep& step) {
      return step.axis == axis && step.velocity != 0 && std::fabs(step.frame - frame) < 1e-3;
    });
  }

  const Plan& plan_;
  const std::string& text_;
  Reasons& reasons_;
  PlayedBounds played_;
  bool is_uncounted_ = false;
};

/// Whether there is a plan to compare.
bool compare(int number, Reasons& reasons) {
  std::mt19937 random(static_cast<unsigned>(number));
  const RandomFiles files = random_files(random);
  const std::string text = "case " + std::to_string(number) + '\n' + files.move;
  try {
    const std::optional<RigFile> rig = rig_of(files);
    const Plan plan(parse_move(files.move, "move.toml"), rig, {.kinematics = joints_of(files, rig)});
    Comparison(plan, text, reasons).compare();
    return true;
  } catch (const InputError&) {
    return false;  // AnyFilesProperty looks at what is refused
  }
}

/// The path stands still at a knot of the speed curve that is no place of the path's own: once, what was read
/// there lay beside the path. Only the checks of a sanitized build see that.
TEST(PlayedBoundsProperty, AStandstillAtAKnotOfTheSpeedCurveIsAPlaceOfThePath) {
  Reasons reasons;
  for (const int number : {1263, 6967}) EXPECT_TRUE(compare(number, reasons));
}

TEST(PlayedBoundsProperty, TheyAreThoseOfTheTracksWithinOnePercentOrTheReasonIsKnown) {
  Reasons reasons;
  int planned = 0;
  for (int i = 0; i < cases_to_run(many_files); ++i) {
    if (compare(i, reasons)) ++planned;
  }
  std::cout << planned << " moves, " << reasons.compared << " peaks; turns back on a line "
            << reasons.turns_back << ", axes of weight 0 " << reasons.uncounted << ", narrow "
            << reasons.narrow << '\n';
  EXPECT_GE(planned, cases_to_run(many_files) / 4);
  EXPECT_LE(reasons.loosened, planned / 200 + 1);
  EXPECT_LE(reasons.turns_back + reasons.uncounted + reasons.narrow, reasons.compared / 20 + 5);
}

}  // namespace played_bounds_property_test
}  // namespace inbetween
