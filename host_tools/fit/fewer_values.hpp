// A fitted curve of many control values as one that a person can still edit.
#pragma once

#include <cstddef>

#include "host_tools/fit/speed_fit.hpp"

namespace inbetween {

/// A curve of so many control values is edited by hand as it is, a few of them an action:
/// SpeedFit.ACurveOfFewValuesIsEditableAsItIs.
inline constexpr std::size_t max_editable_values = 12;

/// Looks for each track whose new curve has more than max_editable_values for one of fewer with which the
/// move fits too (TrackFit::fewer): of 6, 8, 10 and so on up to 48 control values the first that is hardly
/// further from the played curve, by 5 % of its mean at most, and where none is, the nearest. It is the drawn
/// curve in so many values (CurveSamples), brought within the limits by fit_speed without refinement. None is
/// sought for periodic tracks. `plan` is that of the fit. Cost: at most twelve of fit_speed a track.
void add_fewer_values(const Plan& plan, SpeedFit& fit, const FitOptions& options);

}  // namespace inbetween
