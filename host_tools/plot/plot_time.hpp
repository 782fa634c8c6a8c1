// The parts of a plot that show time: the time bar and the axes' positions.
#pragma once

#include "host_tools/plot/plot.hpp"
#include "host_tools/plot/plot_canvas.hpp"

namespace inbetween {

constexpr double time_bar_height = 122;

/// A stripe per frame, as wide as the distance travelled in it, with the keys above and frame numbers below.
/// Distance is the trapezoid sum of PlotTrack::speed; where that is zero the stripes are equally wide.
void draw_time_bar(Canvas& canvas, const Box& panel, const PlotMove& move, const PlotTrack& track,
                   Color color);

/// Every axis over time, one row each; seconds above, frames below.
[[nodiscard]] double positions_height(const PlotMove& move);
/// In the height of the panel: lower rows than usual where that is less than positions_height.
void draw_positions(Canvas& canvas, const Box& panel, const PlotMove& move);

}  // namespace inbetween
