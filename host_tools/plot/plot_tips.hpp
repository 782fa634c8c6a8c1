// The way of a tip of an articulated rig through the world: plan, elevation and perspective.
#pragma once

#include "host_tools/plot/plot.hpp"
#include "host_tools/plot/plot_canvas.hpp"

namespace inbetween {

constexpr double tip_height = 440;

/// From above, from the side and in perspective, each with a tick across the way at every frame and the links
/// of the rig where a key is met. Lengths have the same scale in both directions.
void draw_tip(Canvas& canvas, const Box& area, const PlotMove& move, const PlotTip& tip, Color color);

}  // namespace inbetween
