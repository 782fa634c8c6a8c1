// The speed curve of a track in its plot.
#pragma once

#include "host_tools/plot/plot.hpp"
#include "host_tools/plot/plot_canvas.hpp"

namespace inbetween {

/// phi over a with its control values (the left numbers) and, where it moves, the speed along the path (the
/// right numbers). Without a speed curve: the speed along the path alone, over frames.
void draw_speed_panel(Canvas& canvas, const Box& panel, const PlotMove& move, const PlotTrack& track,
                      Color color);

}  // namespace inbetween
