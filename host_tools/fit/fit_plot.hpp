// The speed curves before and after a fit, for the picture of the limits.
#pragma once

#include "host_tools/fit/speed_fit.hpp"
#include "host_tools/plot/plot_limits.hpp"

namespace inbetween {

/// Adds a row for each track that the fit has changed: `before` is the plan as drawn, `after` the fitted one,
/// of which `plot` is.
void add_fitted_curves(const Plan& before, const Plan& after, const SpeedFit& fit, LimitsPlot& plot);

}  // namespace inbetween
