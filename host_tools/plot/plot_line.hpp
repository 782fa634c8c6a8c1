// Lines with no more points than a page can show.
#pragma once

#include <span>
#include <vector>

#include "host_tools/plot/plot_canvas.hpp"
#include "host_tools/plot/plot_scale.hpp"

namespace inbetween {

/// values[i] over i, for any number of values: keeps the first, lowest, highest and last value of each pixel
/// column, so that no peak is lost, and then simplified() to a tenth of a pixel. `x` scales the index.
/// O(values); at most 4 points a pixel column.
[[nodiscard]] std::vector<Point> series_line(std::span<const double> values, const Scale& x, const Scale& y);

/// A polyline that stays within `tolerance` pixels of `points`, through some of them and both ends. Turning
/// points are kept. One pass: from the last kept point, the wedge of directions that pass every skipped point
/// within the tolerance is narrowed until it is empty (the sector method of Williams, 1978). O(points).
[[nodiscard]] std::vector<Point> simplified(std::span<const Point> points, double tolerance);

/// simplified(), coarser and coarser until no more than `max_points` (>= 2) points are left.
[[nodiscard]] std::vector<Point> simplified_to(std::span<const Point> points, std::size_t max_points);

/// Length of a polyline in pixels.
[[nodiscard]] double length_of(std::span<const Point> points);

}  // namespace inbetween
