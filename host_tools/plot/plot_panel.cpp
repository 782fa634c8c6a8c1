#include "host_tools/plot/plot_panel.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace inbetween {
namespace {

constexpr double tick_size = 11;
constexpr double label_gap = 6;
// The middle of a digit is this share of the font's size above the base line.
constexpr double half_digit = 0.36;

bool overlap(const Box& a, const Box& b) {
  return a.x < b.right() && b.x < a.right() && a.y < b.bottom() && b.y < a.bottom();
}

bool contains(const Box& outer, const Box& inner) {
  return outer.x <= inner.x && inner.right() <= outer.right() && outer.y <= inner.y &&
         inner.bottom() <= outer.bottom();
}

}  // namespace

Color track_color(std::size_t index) {
  constexpr std::array<Color, 4> colors{
      {{0, 0.447, 0.698}, {0, 0.620, 0.451}, {0.8, 0.475, 0.655}, {0.337, 0.706, 0.914}}};
  return colors[index % colors.size()];
}

void draw_heading(Canvas& canvas, Point at, std::string_view name, std::string_view remarks, double width) {
  const TextStyle bold{.size = 14, .color = plot_color::ink, .bold = true};
  const TextStyle plain{.size = 12, .color = plot_color::quiet};
  const std::string shown = elided(canvas, name, bold, width);
  canvas.text(at, shown, bold);
  const double used = canvas.text_width(shown, bold) + 10;
  if (used < width) canvas.text({at.x + used, at.y}, elided(canvas, remarks, plain, width - used), plain);
}

int ticks_across(double width) {
  return std::max(2, static_cast<int>(width / 75));
}
int ticks_up(double height) {
  return std::max(3, static_cast<int>(height / 30));
}

TickLabels draw_left_ticks(Canvas& canvas, const Box& area, const Scale& y, bool grid) {
  const auto ticks = round_ticks(y.range(), ticks_up(area.height));
  TickLabels labels = tick_labels(ticks);
  const TextStyle style{.size = tick_size, .color = plot_color::quiet, .align = Align::right};
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const double at = y(ticks[i]);
    if (grid) canvas.line({area.x, at}, {area.right(), at}, {plot_color::grid});
    canvas.text({area.x - label_gap, at + half_digit * tick_size}, labels.labels[i], style);
  }
  return labels;
}

TickLabels draw_right_ticks(Canvas& canvas, const Box& area, const Scale& y) {
  const auto ticks = round_ticks(y.range(), ticks_up(area.height));
  TickLabels labels = tick_labels(ticks);
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const double at = y(ticks[i]);
    canvas.line({area.right(), at}, {area.right() + 4, at}, {plot_color::frame});
    canvas.text({area.right() + label_gap + 2, at + half_digit * tick_size}, labels.labels[i],
                {.size = tick_size, .color = plot_color::quiet});
  }
  return labels;
}

TickLabels draw_bottom_ticks(Canvas& canvas, const Box& area, const Scale& x) {
  const auto ticks = round_ticks(x.range(), ticks_across(area.width));
  TickLabels labels = tick_labels(ticks);
  const TextStyle style{.size = tick_size, .color = plot_color::quiet, .align = Align::center};
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const double at = x(ticks[i]);
    canvas.line({at, area.y}, {at, area.bottom()}, {plot_color::grid});
    canvas.text({at, area.bottom() + label_gap + tick_size - 2}, labels.labels[i], style);
  }
  return labels;
}

void shade_outside(Canvas& canvas, const Box& area, const Scale& x, const Range& inside) {
  for (const Range& part : {Range{x.range().low, inside.low}, Range{inside.high, x.range().high}}) {
    if (part.size() <= 0) continue;
    canvas.rectangle({x(part.low), area.y, x(part.high) - x(part.low), area.height},
                     plot_color::grid.faded(0.6));
  }
}

double LabelPlacer::cost(const Box& box) const {
  if (!contains(inside_, box)) return std::numeric_limits<double>::infinity();
  for (const Box& other : taken_) {
    if (overlap(box, other)) return std::numeric_limits<double>::infinity();
  }
  return static_cast<double>(std::count_if(obstacles_.begin(), obstacles_.end(), [&](Point p) {
    return box.x <= p.x && p.x <= box.right() && box.y <= p.y && p.y <= box.bottom();
  }));
}

bool LabelPlacer::place(Canvas& canvas, Point anchor, std::string_view words, const TextStyle& style) {
  constexpr int directions = 12;
  constexpr double leader_from = 18;  // from here on the eye needs a line from the point to its label
  constexpr double marker = 6.5;      // where that line leaves the point's own marker
  constexpr std::array<double, 4> distances{9, 16, 26, 38};
  const double width = canvas.text_width(words, style);
  const double height = 0.75 * style.size;  // of a digit: labels have no descenders worth keeping free
  double lowest_total = std::numeric_limits<double>::infinity();
  Box best;
  for (std::size_t ring = 0; ring < distances.size(); ++ring) {
    for (int i = 0; i < directions; ++i) {
      const double angle = 2 * std::numbers::pi * i / directions - std::numbers::pi / 2;
      const Point toward{std::cos(angle), std::sin(angle)};
      // The side that faces the anchor stands off by the distance, so that a wide label does not cover it.
      const double across = std::clamp(1.5 * toward.x, -1.0, 1.0) * width / 2;
      const double up = std::clamp(1.5 * toward.y, -1.0, 1.0) * height / 2;
      const Point center{anchor.x + toward.x * distances[ring] + across,
                         anchor.y + toward.y * distances[ring] + up};
      const Box box{center.x - width / 2 - 2, center.y - height / 2 - 2, width + 4, height + 4};
      // A label two steps away is as bad as one that covers three points of the path.
      const double total = cost(box) + 1.5 * static_cast<double>(ring);
      if (total < lowest_total) {
        lowest_total = total;
        best = box;
      }
    }
  }
  if (!std::isfinite(lowest_total)) return false;
  taken_.push_back(best);
  const Point nearest{std::clamp(anchor.x, best.x, best.right()),
                      std::clamp(anchor.y, best.y, best.bottom())};
  const double far = std::hypot(nearest.x - anchor.x, nearest.y - anchor.y);
  if (far > leader_from) {
    const double off = marker / far;
    const Point start{anchor.x + off * (nearest.x - anchor.x), anchor.y + off * (nearest.y - anchor.y)};
    canvas.line(start, nearest, {plot_color::quiet, 0.7});
  }
  canvas.text({best.x + 2, best.bottom() - 2}, words, style);
  return true;
}

void draw_row_of_labels(Canvas& canvas, std::span<const double> at, double base_line,
                        std::span<const std::string> labels, const TextStyle& style) {
  constexpr double min_gap = 7;
  TextStyle centered = style;
  centered.align = Align::center;
  if (at.empty()) return;
  const double last_left = at.back() - canvas.text_width(labels.back(), style) / 2;
  double free_from = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < at.size(); ++i) {
    const double half = canvas.text_width(labels[i], style) / 2;
    const bool last = i + 1 == at.size();
    if (!last && (at[i] - half < free_from || at[i] + half + min_gap > last_left)) continue;
    canvas.text({at[i], base_line}, labels[i], centered);
    free_from = at[i] + half + min_gap;
  }
}

}  // namespace inbetween
