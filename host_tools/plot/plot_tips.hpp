// The path of a tip of an articulated rig through the world: plan, elevation and perspective.
#pragma once

#include <cstddef>

#include "host_tools/plot/plot.hpp"
#include "host_tools/plot/plot_canvas.hpp"

namespace inbetween {

constexpr double tip_height = 440;

/// From above, from the side and in perspective, each with a tick across the path at every frame and the
/// links of the rig where a key is met, an arrow as the tip looks there, and a cross at the point at which it
/// is to look. Lengths have the same scale in both directions.
void draw_tip(Canvas& canvas, const Box& area, const PlotMove& move, const PlotTip& tip, Color color);
/// All tips beside each other in perspective alone, in two rows at most.
void draw_tips(Canvas& canvas, const Box& area, const PlotMove& move);
/// The height of draw_tips.
[[nodiscard]] double tips_height(std::size_t tips);

}  // namespace inbetween
