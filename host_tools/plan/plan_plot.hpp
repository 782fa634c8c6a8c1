// A plan as the data of a picture.
#pragma once

#include "host_tools/plan/plan.hpp"
#include "host_tools/plot/plot.hpp"

namespace inbetween {

/// The data that draw_plot shows. Leaves out axes in no track.
PlotMove plot_of(const Plan& plan);

}  // namespace inbetween
