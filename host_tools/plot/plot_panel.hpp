// The shared part of the panels of a plot: the page, colours, headings, grids with tick numbers, and key
// numbers that do not collide.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/plot/plot_canvas.hpp"
#include "host_tools/plot/plot_scale.hpp"

namespace inbetween {

/// Every picture is drawn on such a page, in pixels.
inline constexpr double page_width = 1400;
/// Of a sheet of paper of that width (A4).
inline constexpr double sheet_height = 1980;
inline constexpr double page_margin = 44;
inline constexpr double content_width = page_width - 2 * page_margin;
inline constexpr double title_height = 66;

// Okabe and Ito's palette (2008), told apart by readers with any colour vision.
namespace plot_color {
constexpr Color ink{0.13, 0.13, 0.15};
constexpr Color quiet{0.42, 0.42, 0.45};
constexpr Color grid{0.90, 0.90, 0.91};
constexpr Color frame{0.72, 0.72, 0.74};
constexpr Color paper{1, 1, 1};
constexpr Color key{0.835, 0.369, 0};
constexpr Color limit{0.58, 0.58, 0.61};
constexpr Color aim{0.34, 0.46, 0.22};
}  // namespace plot_color

/// The colour of track `index`; they repeat after four.
[[nodiscard]] Color track_color(std::size_t index);

/// A bold name and, behind it, quiet remarks, on the base line through `at`. An ellipsis replaces what does
/// not fit into `width`.
void draw_heading(Canvas& canvas, Point at, std::string_view name, std::string_view remarks, double width);

/// How many tick numbers stand comfortably along so many pixels, horizontally and vertically.
[[nodiscard]] int ticks_across(double width);
[[nodiscard]] int ticks_up(double height);

/// Numbers left of `area` and, where `grid`, a line across it at each tick. Returns what the axis' title has
/// to tell.
TickLabels draw_left_ticks(Canvas& canvas, const Box& area, const Scale& y, bool grid = true);
/// Numbers right of `area`.
TickLabels draw_right_ticks(Canvas& canvas, const Box& area, const Scale& y);
/// Numbers below `area` and a line up through it at each tick.
TickLabels draw_bottom_ticks(Canvas& canvas, const Box& area, const Scale& x);

/// A grey ground for what `x` shows outside `inside`: the rolls of a move.
void shade_outside(Canvas& canvas, const Box& area, const Scale& x, const Range& inside);

/// Places small labels beside points. Labels never overlap each other, and overlap the drawing only if there
/// is no other place.
class LabelPlacer {
 public:
  explicit LabelPlacer(const Box& inside) : inside_(inside) {}

  /// Something that labels should not cover.
  void avoid(Point point) { obstacles_.push_back(point); }

  /// Draws `words` near `anchor`, or returns false if every place collides with a label or leaves the box.
  [[nodiscard]] bool place(Canvas& canvas, Point anchor, std::string_view words, const TextStyle& style);

 private:
  [[nodiscard]] double cost(const Box& box) const;

  Box inside_;
  std::vector<Point> obstacles_;
  std::vector<Box> taken_;
};

/// Draws labels from left to right on one base line and leaves out those that would touch the one before.
/// The last label is always drawn. `at` is ascending, as long as `labels`.
void draw_row_of_labels(Canvas& canvas, std::span<const double> at, double base_line,
                        std::span<const std::string> labels, const TextStyle& style);

}  // namespace inbetween
