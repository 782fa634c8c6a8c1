// The report of a check, as the data of a picture.
#pragma once

#include "host_tools/check/check.hpp"
#include "host_tools/plot/plot_limits.hpp"

namespace inbetween {

/// The data that draw_limits_plot shows. Samples are dense, and closer around each peak.
LimitsPlot limits_plot_of(const Plan& plan, const CheckReport& report);

}  // namespace inbetween
