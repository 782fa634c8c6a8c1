#include "host_tools/plot/plot_trend.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>

#include "host_tools/plot/plot_line.hpp"
#include "host_tools/plot/plot_panel.hpp"
#include "host_tools/plot/plot_scale.hpp"

namespace inbetween {
namespace {

constexpr double above_panels = 58;
constexpr double below_panels = 44;
constexpr double panel_height = 132;
constexpr double between_panels = 24;
// Left of the panels stands the axis, and left of each panel its numbers.
constexpr double name_width = 130;
constexpr double numbers_width = 64;
/// Farther apart than this a point has a disc of its own.
constexpr double disc_spacing = 7;

void require_consistent_trend(const TrendPlot& plot) {
  for (const TrendPlotAxis& axis : plot.axes) {
    if (axis.rows.size() != plot.axes.front().rows.size()) {
      throw std::invalid_argument("every axis must have as many rows");
    }
    for (const TrendPlotRow& row : axis.rows) {
      if (row.values.size() != plot.takes.size())
        throw std::invalid_argument("a row needs a value for each take");
    }
  }
}

Range values_of_trend(const TrendPlotRow& row) {
  Range range{0, 0};
  const auto include = [&](double value) {
    range = {std::min(range.low, value), std::max(range.high, value)};
  };
  for (const std::optional<double>& value : row.values) {
    if (value) include(*value);
  }
  // Nothing but zeros stand on the lower edge.
  return range.size() == 0 ? Range{0, 1} : range;
}

void draw_trend_line(Canvas& canvas, const TrendPlotRow& row, const Scale& x, const Scale& y, Color color) {
  std::vector<Point> line;
  const bool has_discs = x.pixels_per_unit() >= disc_spacing;
  const auto end_line = [&] {
    if (line.size() > 1) canvas.polyline(simplified(line, 0.1), {color, 1.6});
    // A take between two without a value would be no line.
    if (line.size() == 1 && !has_discs) canvas.disc(line.front(), 1.6, color);
    line.clear();
  };
  for (std::size_t i = 0; i < row.values.size(); ++i) {
    if (!row.values[i]) {
      end_line();
      continue;
    }
    line.push_back({x(static_cast<double>(i)), y(*row.values[i])});
    if (has_discs) canvas.disc(line.back(), 2.6, color);
  }
  end_line();
}

/// The numbers of as many takes as there is room for, below a panel.
void draw_take_numbers(Canvas& canvas, const Box& area, const TrendPlot& plot, const Scale& x) {
  const auto step = static_cast<std::size_t>(
      round_step(std::max(1.0, static_cast<double>(plot.takes.size()) / ticks_across(area.width))));
  std::vector<double> at;
  std::vector<std::string> labels;
  for (std::size_t i = 0; i < plot.takes.size(); i += step) {
    at.push_back(x(static_cast<double>(i)));
    labels.push_back(fmt::format("{}", plot.takes[i]));
  }
  if ((plot.takes.size() - 1) % step != 0) {
    at.push_back(x(static_cast<double>(plot.takes.size() - 1)));
    labels.push_back(fmt::format("{}", plot.takes.back()));
  }
  draw_row_of_labels(canvas, at, area.bottom() + 16, labels,
                     {.size = 11, .color = plot_color::quiet, .align = Align::center});
}

void draw_trend_panel(Canvas& canvas, const Box& area, const TrendPlot& plot, const TrendPlotRow& row,
                      Color color) {
  const auto count = static_cast<double>(plot.takes.size());
  const Scale x(widened({-0.5, std::max(count, 1.0) - 0.5}, 0.01), area.x, area.right());
  const Scale y(widened(values_of_trend(row), 0.1), area.bottom(), area.y);
  const bool is_empty = std::ranges::none_of(row.values, [](const auto& value) { return value.has_value(); });
  const TickLabels labels = is_empty ? TickLabels{} : draw_left_ticks(canvas, area, y);
  canvas.outline(area, {plot_color::frame});
  const TextStyle title{.size = 11, .color = plot_color::quiet};
  canvas.text({area.x, area.y - 6},
              elided(canvas, axis_title(row.quantity, row.unit, labels), title, area.width), title);
  if (is_empty) {
    canvas.text({area.x + area.width / 2, area.y + area.height / 2}, "none",
                {.size = 11, .color = plot_color::quiet, .align = Align::center});
    return;
  }
  draw_trend_line(canvas, row, x, y, color);
  draw_take_numbers(canvas, area, plot, x);
}

}  // namespace

void draw_trend_plot(const TrendPlot& plot, const std::filesystem::path& file, PictureStyle style) {
  require_consistent_trend(plot);
  const auto rows = static_cast<double>(plot.axes.size());
  const double columns = plot.axes.empty() ? 1 : static_cast<double>(plot.axes.front().rows.size());
  const double line_height = panel_height + between_panels + below_panels / 2;
  Canvas canvas(file, page_width,
                std::ceil(page_margin + title_height + above_panels + rows * line_height + page_margin),
                style);
  const TextStyle title{.size = 24, .color = plot_color::ink, .bold = true};
  canvas.text({page_margin, page_margin + 18}, elided(canvas, plot.name, title, content_width), title);
  canvas.text({page_margin, page_margin + 42}, plot.summary, {.size = 13, .color = plot_color::quiet});
  double top = page_margin + title_height + above_panels;
  draw_heading(canvas, {page_margin, top - 34}, "Over the takes", "from the first on the left to the last",
               content_width);
  const double width = (content_width - name_width) / columns;
  for (std::size_t a = 0; a < plot.axes.size(); ++a) {
    const TrendPlotAxis& axis = plot.axes[a];
    const TextStyle bold{.size = 12, .color = plot_color::ink, .bold = true};
    canvas.text({page_margin, top + panel_height / 2}, elided(canvas, axis.name, bold, name_width - 8), bold);
    Box area{page_margin + name_width + numbers_width, top, width - numbers_width - 12, panel_height};
    for (const TrendPlotRow& row : axis.rows) {
      draw_trend_panel(canvas, area, plot, row, track_color(a));
      area.x += width;
    }
    top += line_height;
  }
  canvas.write(plot.name, fmt::format("{}; what wear and drift look like, take by take", plot.summary));
}

}  // namespace inbetween
