// A speed curve that keeps the limits of the rig, as near to the drawn one as can be.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/fit/fewest_frames.hpp"
#include "host_tools/plan/plan.hpp"

namespace inbetween {

/// What the new curve is to be near to.
enum class FitStart : std::uint8_t {
  drawn,      ///< the curve that is played: the drawn one, with what its locked keys made of it
  curvature,  ///< one that makes the acceleration across the path even: curvature_start()
};

/// A track with another speed curve.
struct TrackFit {
  std::size_t track = 0;
  std::vector<double> speed;  ///< f + 1 control values, for with_speed()
  int refinements = 0;        ///< how often f was doubled against the curve that is played
  /// new phi - played phi, in control values; a and the mean are those of the new curve. Also with
  /// FitStart::curvature it is the played curve that counts.
  double change = 0;             ///< root mean square over a
  double change_share = 0;       ///< of the mean of phi
  double largest_change = 0;     ///< of the magnitude, with the sign of the change
  double largest_change_at = 0;  ///< a
  double largest_change_frame = 0;
};

struct SpeedFit {
  std::vector<TrackFit> tracks;  ///< only those that change; none where nothing was found
  bool found = false;            ///< the move with these curves passes check()
  std::string reason;            ///< where none was found, what is in the way and what to do
  FewestFrames least;            ///< proven for any speed curve, found or not
};

/// New speed curves for the tracks that break a limit, the other tracks untouched; N and the path stay. Of
/// the curves with the same Phi(f), the same Phi at locked keys and breaks and the same rests, one with the
/// least integral of the squared change of phi over a. Where there is none with as many control values, the
/// played curve is refined, f -> 2 f, at most 4 times and up to 600 control values.
///
/// The new curve in the file means the new curve in the move: its locked keys are met as they are, so that
/// reading it again changes it by no more than rounding. That is why next to a hold one more control value on
/// either side may go to 0, and why a hold that has no frame cannot be kept: its frame follows from the drawn
/// curve. It is refused with the frame to write.
///
/// Method: SpeedDescent at sampled moments with a margin below every limit, judged by check(); then the
/// margins are made as small as what check() is above the samples. It is a local minimum and not proven to be
/// the least; that no curve is found does not prove that there is none, `least` does. Not found without a
/// search: what slowing does not cure (CheckRefusal::slower_helps), a track with timing = "frames", fewer
/// frames than `least`.
///
/// `report` is that of the plan. `progress` is told the share of the work, roughly. Cost: about a tenth of a
/// second for a track of 10 control values, up to minutes for hundreds of them.
SpeedFit fit_speed(const Plan& plan, const CheckReport& report, FitStart start,
                   const std::function<void(double share)>& progress);

}  // namespace inbetween
