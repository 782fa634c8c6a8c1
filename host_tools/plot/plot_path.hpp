// The path of a track with a tick across it at every frame, as in Bartels and Hardtke 1989, Figures 4 to 6.
#pragma once

#include <cstddef>

#include "host_tools/plot/plot.hpp"
#include "host_tools/plot/plot_canvas.hpp"

namespace inbetween {

/// The axes of the track (indexes into PlotTrack::axes) that a plane shows.
struct PlotPlane {
  std::size_t across = 0;
  std::size_t up = 1;
};

/// The height at which a panel `width` wide shows the plane best; between 270 and 470 pixels.
[[nodiscard]] double path_panel_height(const PlotMove& move, const PlotTrack& track, PlotPlane plane,
                                       double width);

void draw_path_panel(Canvas& canvas, const Box& panel, const PlotMove& move, const PlotTrack& track,
                     PlotPlane plane, Color color);

constexpr double ruler_height = 210;

/// The path of a track of one axis: a ruler, with the ticks above it where the axis moves forward and below
/// it where it moves back.
void draw_ruler(Canvas& canvas, const Box& panel, const PlotMove& move, const PlotTrack& track, Color color);

}  // namespace inbetween
