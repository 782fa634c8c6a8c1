#include "host_tools/plot/plot_limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "host_tools/plot/plot_line.hpp"
#include "host_tools/plot/plot_panel.hpp"
#include "host_tools/plot/plot_scale.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/frame_range.hpp"

namespace inbetween {
namespace {

constexpr double above_rows = 34;
constexpr double below_rows = 40;
constexpr double row_height = 104;
constexpr double row_gap = 12;
constexpr double axis_gap = 16;  // more, where the next row is of another axis
// Beside the rows: names and numbers on the left, limits and peaks on the right.
constexpr double left_room = 200;
constexpr double right_room = 190;
/// A peak further beyond its limit is cut off, so that the limit can still be seen.
constexpr double max_shown = 3;

Range played_frames(const LimitsPlot& plot) {
  return {static_cast<double>(plot.part.first), static_cast<double>(plot.part.last)};
}

Range range_in_frames(const LimitsPlot& plot) {
  return {static_cast<double>(plot.first_frame), static_cast<double>(plot.last_frame)};
}

/// The range of values that a row shows.
double shown_magnitude(const LimitsRow& row) {
  if (!row.limit) {
    double largest = 0;
    for (const Point& sample : row.samples) largest = std::max(largest, std::fabs(sample.y));
    return std::isfinite(row.peak) ? std::max(row.peak, largest) : largest;
  }
  return std::max(*row.limit, std::min(row.peak, max_shown * *row.limit));
}

void require_consistent(const LimitsPlot& plot) {
  const auto require = [](bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(what);
  };
  require(plot.frames >= 1, "frames must be at least 1");
  require(plot.part.first >= 0 && plot.part.first < plot.part.last && plot.part.last <= plot.frames,
          "part must be some of the frames 0..N");
  require(plot.first_frame <= plot.part.first && plot.last_frame >= plot.part.last,
          "first_frame and last_frame must enclose the frames that are played");
  require(std::isfinite(plot.frames_per_second) && plot.frames_per_second > 0,
          "frames_per_second must be positive");
  for (const LimitsRow& row : plot.rows) {
    require(row.samples.size() >= 2, "a row needs two samples");
    for (const Point& sample : row.samples) {
      require(std::isfinite(sample.x) && std::isfinite(sample.y), "a sample is not finite");
    }
  }
}

double rows_height(const LimitsPlot& plot) {
  double height = 0;
  for (std::size_t i = 0; i < plot.rows.size(); ++i) {
    if (i > 0) height += row_gap + (plot.rows[i].axis == plot.rows[i - 1].axis ? 0 : axis_gap);
    height += row_height;
  }
  for (std::size_t i = 0; i < plot.curves.size(); ++i) height += axis_gap + row_gap + row_height;
  return height;
}

/// The values as a line, ended at the edge of the row where they leave it.
std::vector<Point> line_of(const LimitsRow& row, const Scale& x, const Scale& y) {
  std::vector<Point> line;
  line.reserve(row.samples.size());
  for (const Point& sample : row.samples) {
    line.push_back({x(sample.x), y(std::clamp(sample.y, y.range().low, y.range().high))});
  }
  return simplified(line, 0.1);
}

void draw_limits(Canvas& canvas, const Box& area, const Scale& y, const LimitsRow& row) {
  const Color color = row.exceeded ? plot_color::key : plot_color::limit;
  if (!row.limit) return;
  for (const double limit : {*row.limit, -*row.limit}) {
    canvas.line({area.x, y(limit)}, {area.right(), y(limit)}, {color, 1.2, true});
    if (!row.exceeded) continue;
    const double edge = limit > 0 ? area.y : area.bottom();
    canvas.rectangle({area.x, std::min(edge, y(limit)), area.width, std::fabs(y(limit) - edge)},
                     plot_color::key.faded(0.08));
  }
}

void draw_peak(Canvas& canvas, const Scale& x, const Scale& y, const LimitsRow& row) {
  if (row.peak <= 0) return;
  const double value = row.peak_is_below ? -row.peak : row.peak;
  const Point at{x(row.peak_frame), y(std::clamp(value, y.range().low, y.range().high))};
  canvas.disc(at, 4, row.exceeded ? plot_color::key : plot_color::ink);
}

std::string peak_words(const LimitsRow& row) {
  if (row.peak <= 0) return "at rest";
  if (!std::isfinite(row.peak)) return fmt::format("no bound, frame {:.1f}", row.peak_frame);
  return fmt::format("peak {:.5g}, frame {:.1f}", row.peak, row.peak_frame);
}

std::string limit_words(const LimitsRow& row) {
  if (!row.limit) return "no limit";
  const double share = row.peak / *row.limit;
  if (!std::isfinite(share)) return fmt::format("limit {:g}", *row.limit);
  return share < 10 ? fmt::format("limit {:g}, {:.3g} % of it", *row.limit, 100 * share)
                    : fmt::format("limit {:g}, {:.3g} times it", *row.limit, share);
}

/// The label of a row: the peak, and what the line cannot show.
std::string remark(const LimitsRow& row) {
  std::string words;
  if (!row.steps.empty()) words = counted(static_cast<std::int64_t>(row.steps.size()), "step");
  if (row.limit && row.peak > max_shown * *row.limit) words += words.empty() ? "cut off" : ", cut off";
  return words;
}

void draw_row(Canvas& canvas, const Box& area, const LimitsPlot& plot, const LimitsRow& row, Color color,
              bool names_axis) {
  const double magnitude = shown_magnitude(row);
  const Scale y(widened({-magnitude, magnitude}, 0.08), area.bottom(), area.y);
  const Scale x(range_in_frames(plot), area.x, area.right());
  shade_outside(canvas, area, x, played_frames(plot));
  const TickLabels labels = draw_left_ticks(canvas, area, y);
  draw_limits(canvas, area, y, row);
  canvas.outline(area, {plot_color::frame});
  const TextStyle bold{.size = 12, .color = plot_color::ink, .bold = true};
  const TextStyle plain{.size = 11, .color = plot_color::quiet};
  const double room = left_room - 62;
  const double middle = area.y + area.height / 2;
  const double left = area.x - left_room;
  if (names_axis) canvas.text({left, middle - 16}, elided(canvas, row.axis, bold, room), bold);
  canvas.text({left, middle}, row.quantity, plain);
  std::string unit = axis_title("", row.unit, labels);
  if (!unit.empty()) unit.erase(0, 1);  // the space behind the name
  canvas.text({left, middle + 15}, elided(canvas, unit, plain, room), plain);
  canvas.polyline(line_of(row, x, y), {color, 2});
  for (const double frame : row.steps) {
    canvas.line({x(frame), area.y}, {x(frame), area.bottom()}, {plot_color::key, 1.6});
  }
  draw_peak(canvas, x, y, row);
  const bool refused = row.exceeded || !row.steps.empty();
  const TextStyle told{.size = 11, .color = refused ? plot_color::key : plot_color::quiet, .bold = refused};
  double base_line = middle - 8;
  for (const std::string& words : {peak_words(row), limit_words(row), remark(row)}) {
    canvas.text({area.right() + 10, base_line}, elided(canvas, words, told, right_room - 10), told);
    base_line += 15;
  }
}

void draw_frames(Canvas& canvas, const Box& rows, const LimitsPlot& plot) {
  const TextStyle style{.size = 11, .color = plot_color::quiet, .align = Align::center};
  const Scale frame(range_in_frames(plot), rows.x, rows.right());
  for (const double tick : round_ticks(frame.range(), ticks_across(rows.width), 1)) {
    canvas.line({frame(tick), rows.y}, {frame(tick), rows.bottom()}, {plot_color::grid});
    canvas.text({frame(tick), rows.bottom() + 16}, fmt::format("{:.0f}", tick), style);
  }
  const TextStyle name{.size = 11, .color = plot_color::quiet, .align = Align::right};
  canvas.text({rows.x - 24, rows.bottom() + 16}, "frames", name);
}

/// Two lines over one scale: dashed as drawn, whole as fitted.
void draw_curve(Canvas& canvas, const Box& area, const LimitsPlot& plot, const FittedCurve& curve,
                Color color) {
  double top = 0;
  for (const std::vector<Point>* samples : {&curve.before, &curve.after}) {
    for (const Point& sample : *samples) top = std::max(top, sample.y);
  }
  const Scale y({0, top > 0 ? 1.08 * top : 1}, area.bottom(), area.y);
  const Scale x(range_in_frames(plot), area.x, area.right());
  shade_outside(canvas, area, x, played_frames(plot));
  draw_left_ticks(canvas, area, y);
  canvas.outline(area, {plot_color::frame});
  const auto line_of_curve = [&](const std::vector<Point>& samples) {
    std::vector<Point> line;
    line.reserve(samples.size());
    for (const Point& sample : samples) line.push_back({x(sample.x), y(sample.y)});
    return simplified(line, 0.1);
  };
  canvas.polyline(line_of_curve(curve.before), {plot_color::ink.faded(0.7), 1.4, true});
  canvas.polyline(line_of_curve(curve.after), {color, 2.2});
  const TextStyle bold{.size = 12, .color = plot_color::ink, .bold = true};
  const TextStyle plain{.size = 11, .color = plot_color::quiet};
  const double middle = area.y + area.height / 2;
  canvas.text({area.x - left_room, middle - 16}, elided(canvas, curve.axes, bold, left_room - 62), bold);
  canvas.text({area.x - left_room, middle}, "speed curve", plain);
  canvas.text({area.right() + 10, middle - 8}, "dashed: as drawn", plain);
  canvas.text({area.right() + 10, middle + 7}, "line: as fitted", plain);
}

}  // namespace

void draw_limits_plot(const LimitsPlot& plot, const std::filesystem::path& file, PictureStyle style) {
  require_consistent(plot);
  const double height = rows_height(plot);
  Canvas canvas(file, page_width,
                std::ceil(page_margin + title_height + above_rows + height + below_rows + page_margin / 2),
                style);
  const TextStyle title{.size = 24, .color = plot_color::ink, .bold = true};
  const TextStyle quiet{.size = 13, .color = plot_color::quiet};
  const std::string summary =
      fmt::format("{}  ·  {} fps  ·  {:.6g} s", frames_in_words(plot.part, plot.frames), plot.frame_rate,
                  (plot.part.last - plot.part.first) / plot.frames_per_second);
  canvas.text({page_margin, page_margin + 18}, elided(canvas, plot.name, title, content_width), title);
  canvas.text({page_margin, page_margin + 42}, summary, quiet);
  Box area{page_margin + left_room, page_margin + title_height + above_rows,
           content_width - left_room - right_room, row_height};
  const bool rolls = plot.first_frame < plot.part.first || plot.last_frame > plot.part.last;
  const std::string remarks = "dashed: limits of the rig; dots: proven peaks; orange: what does not fit";
  draw_heading(canvas, {page_margin, area.y - 14}, "Limits",
               rolls ? remarks + "; grey: pre-roll and post-roll" : remarks, content_width);
  draw_frames(canvas, {area.x, area.y, area.width, height}, plot);
  std::size_t axis = 0;
  for (std::size_t i = 0; i < plot.rows.size(); ++i) {
    const bool is_next_axis = i > 0 && plot.rows[i].axis != plot.rows[i - 1].axis;
    if (is_next_axis) {
      area.y += axis_gap;
      ++axis;
    }
    draw_row(canvas, area, plot, plot.rows[i], track_color(axis), i == 0 || is_next_axis);
    area.y += row_height + row_gap;
  }
  for (std::size_t i = 0; i < plot.curves.size(); ++i) {
    area.y += axis_gap;
    draw_curve(canvas, area, plot, plot.curves[i], track_color(i));
    area.y += row_height + row_gap;
  }
  canvas.write(plot.name, fmt::format("{}; velocity, acceleration and jerk against the limits", summary));
}

}  // namespace inbetween
