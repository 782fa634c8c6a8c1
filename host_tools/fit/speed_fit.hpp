// Finds a speed curve that keeps the limits of the rig and is as near to the drawn one as possible.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/fit/fewest_frames.hpp"
#include "host_tools/plan/plan.hpp"

namespace inbetween {

/// The curve that the new one shall be near to.
enum class FitStart : std::uint8_t {
  either,     ///< the drawn one; where none is found from there, from a curve that follows the curvature on
  drawn,      ///< the curve that is played: the drawn one, adjusted to its locked keys
  curvature,  ///< one that makes the acceleration across the path even: curvature_start()
};

/// A curve of fewer control values with which the move fits too (fewer_values.hpp).
struct FewerValues {
  std::vector<double> speed;
  double further_share =
      0;  ///< so much further from the played curve than the fitted one, of the mean of phi
};

/// A track with another speed curve.
struct TrackFit {
  std::size_t track = 0;
  std::vector<double> speed;         ///< f + 1 control values, for with_speed()
  int refinements = 0;               ///< how often f was doubled against the curve that is played
  FitStart start = FitStart::drawn;  ///< where the search began that found it: drawn or curvature
  /// The change is new phi - played phi, in control values, with FitStart::curvature too; a and the mean are
  /// those of the new curve.
  double change = 0;             ///< root mean square over a
  double change_share = 0;       ///< of the mean of phi
  double largest_change = 0;     ///< of the magnitude, with the sign of the change
  double largest_change_at = 0;  ///< a
  double largest_change_frame = 0;
  std::optional<FewerValues> fewer = {};  ///< of a curve that is too long to be edited, where one was found
};

/// How often the played curve is given twice as many control values at most:
/// SpeedFit.WhereAFewValuesAreTooStiffTheCurveIsRefined needs one doubling. max_refined_values ends it
/// earlier for a curve of 40 values or more.
inline constexpr int max_refinements = 4;
/// Refinement ends with so many control values: more are beyond what a person draws. A curve that has as many
/// because of its locks is refined as well.
inline constexpr std::size_t max_refined_values = 600;

struct SpeedFit {
  std::vector<TrackFit> tracks;  ///< only those that change; none where nothing was found
  bool found = false;            ///< the move with these curves passes check()
  std::string reason;            ///< where none was found, what is in the way and what to do
  bool was_ended = false;        ///< FitOptions::is_over ended it: there may be one, or a nearer one
  FewestFrames fewest;           ///< proven for any speed curve, found or not
};

struct FitOptions {
  FitStart start = FitStart::either;
  int refinements = max_refinements;
  std::function<void(double share)> progress = {};  ///< gets the share of the work that is done, roughly
  /// Asked before every step of a descent, which for 10 000 control values takes about a second. Once it is
  /// true the search ends with what it has.
  std::function<bool()> is_over = {};

  [[nodiscard]] bool ends() const { return is_over && is_over(); }
};

/// Finds new speed curves for the tracks that break a limit. The other tracks, N and the path stay. A new
/// curve has the same Phi(f), the same Phi at locked keys and breaks, and the same rests; it has the smallest
/// integral of the squared change of phi over a. If no curve fits with as many control values, the played
/// curve is refined, f -> 2 f, at most `refinements` times and up to 600 control values. If none is found
/// near the drawn curve with as many values, FitStart::either looks for one that makes the acceleration
/// across the path even, and goes on from there towards the drawn one; of 64 values or fewer the nearest of
/// all that are found is taken, of more the first. If none of these fits, the keys that ease without a frame
/// of their own are met on other frames (with_eases_shared_out).
///
/// The move plays the new curve exactly as it stands in the file: the curve meets its locked keys already, so
/// that reading it changes it by no more than rounding. Therefore one more control value may go to 0 on
/// either side of a hold. A hold without a frame is refused, with the frame to write, because its frame would
/// follow from the new curve.
///
/// Method: SpeedDescent at sampled moments with a margin below every limit; check() judges the result. Then
/// the margins shrink to the excess of check() over the samples. The result is a local minimum; a smaller
/// change may exist. If no curve is found, one may still exist; only `fewest` proves that none does. The
/// search does not begin if slowing cures nothing (CheckRefusal::slower_helps), if a track has timing =
/// "frames", or if the move has fewer frames than `fewest`. It throws InputError where the played curve of a
/// track that has to change has more control values than a file holds.
///
/// `report` is that of the plan. Cost: linear in control values, keys and axes.
SpeedFit fit_speed(const Plan& plan, const CheckReport& report, const FitOptions& options);

}  // namespace inbetween
