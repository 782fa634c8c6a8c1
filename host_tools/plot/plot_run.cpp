#include "host_tools/plot/plot_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "host_tools/plot/plot_line.hpp"
#include "host_tools/plot/plot_panel.hpp"
#include "host_tools/plot/plot_scale.hpp"

namespace inbetween {
namespace {

constexpr double above_axes = 34;
constexpr double below_axes = 40;
constexpr double positions_row = 150;
constexpr double error_row = 70;
constexpr double between_rows = 10;
constexpr double between_axes = 28;
constexpr double axis_height = positions_row + between_rows + error_row;
// Beside the rows: names and numbers on the left, the largest following error on the right.
constexpr double left_side = 200;
constexpr double right_side = 150;

/// The lowest and the highest of some points in y.
Range height_of(std::span<const Point> points, Range range) {
  for (const Point& point : points) {
    range = {std::min(range.low, point.y), std::max(range.high, point.y)};
  }
  return range;
}

void draw_line(Canvas& canvas, std::span<const Point> points, const Scale& x, const Scale& y,
               const Stroke& stroke) {
  std::vector<Point> line;
  line.reserve(points.size());
  for (const Point& point : points) line.push_back({x(point.x), y(point.y)});
  if (line.size() > 1) canvas.polyline(simplified(line, 0.1), stroke);
}

void name_row(Canvas& canvas, const Box& area, const RunPlotAxis& axis, const std::string& quantity,
              const TickLabels& labels) {
  const TextStyle bold{.size = 12, .color = plot_color::ink, .bold = true};
  const TextStyle plain{.size = 11, .color = plot_color::quiet};
  const double middle = area.y + area.height / 2;
  const double left = area.x - left_side;
  canvas.text({left, middle - 8}, elided(canvas, axis.name, bold, left_side - 62), bold);
  canvas.text({left, middle + 8},
              elided(canvas, axis_title(quantity, axis.unit, labels), plain, left_side - 62), plain);
}

void draw_axis(Canvas& canvas, Box area, const Scale& x, const RunPlotAxis& axis, const RunPlotWords& words,
               Color color) {
  area.height = positions_row;
  const double start = axis.actual.empty() ? 0 : axis.actual.front().y;
  const Scale place(widened(height_of(axis.commanded, height_of(axis.actual, {start, start})), 0.08),
                    area.bottom(), area.y);
  name_row(canvas, area, axis, "position", draw_left_ticks(canvas, area, place));
  canvas.outline(area, {plot_color::frame});
  draw_line(canvas, axis.actual, x, place, {color, 2.4});
  draw_line(canvas, axis.commanded, x, place, {plot_color::ink, 1.2, true});
  area.y += positions_row + between_rows;
  area.height = error_row;
  const Range errors = height_of(axis.following_error, {0, 0});
  const Scale error(widened(errors, 0.08), area.bottom(), area.y);
  name_row(canvas, area, axis, words.error, draw_left_ticks(canvas, area, error));
  canvas.outline(area, {plot_color::frame});
  draw_line(canvas, axis.following_error, x, error, {color, 1.6});
  canvas.text({area.right() + 10, area.y + area.height / 2},
              fmt::format("peak {:.4g} {}", std::max(errors.high, -errors.low), axis.unit),
              {.size = 11, .color = plot_color::quiet});
}

}  // namespace

void draw_run_plot(const RunPlot& plot, const std::filesystem::path& file, PictureStyle style) {
  std::vector<double> ends;
  for (const RunPlotAxis& axis : plot.axes) {
    if (!axis.actual.empty()) ends.insert(ends.end(), {axis.actual.front().x, axis.actual.back().x});
  }
  const auto count = static_cast<double>(plot.axes.size());
  const double height = count * axis_height + (count - 1) * between_axes;
  Canvas canvas(file, page_width,
                std::ceil(page_margin + title_height + above_axes + height + below_axes + page_margin / 2),
                style);
  const TextStyle title{.size = 24, .color = plot_color::ink, .bold = true};
  canvas.text({page_margin, page_margin + 18}, elided(canvas, plot.name, title, content_width), title);
  canvas.text({page_margin, page_margin + 42}, plot.summary, {.size = 13, .color = plot_color::quiet});
  Box area{page_margin + left_side, page_margin + title_height + above_axes,
           content_width - left_side - right_side, height};
  draw_heading(canvas, {page_margin, area.y - 14}, plot.words.heading, plot.words.legend, content_width);
  const Scale x(widened(range_of(ends), 0), area.x, area.right());
  draw_bottom_ticks(canvas, area, x);
  for (std::size_t a = 0; a < plot.axes.size(); ++a) {
    draw_axis(canvas, area, x, plot.axes[a], plot.words, track_color(a));
    area.y += axis_height + between_axes;
  }
  canvas.write(plot.name, fmt::format("{}; {}", plot.summary, plot.words.description));
}

}  // namespace inbetween
