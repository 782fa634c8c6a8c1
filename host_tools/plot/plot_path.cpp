#include "host_tools/plot/plot_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host_tools/plot/plot_line.hpp"
#include "host_tools/plot/plot_panel.hpp"
#include "host_tools/plot/plot_scale.hpp"

namespace inbetween {
namespace {

// Closer than this on average, ticks run together into a band.
constexpr double min_tick_gap = 4.5;
// A scribble that fills its panel is not made clearer by more.
constexpr double max_ticks = 1000;
constexpr std::size_t max_points = 20'000;
constexpr Stroke tick_stroke{plot_color::ink.faded(0.75), 1};
constexpr double longest_aspect = 12;
constexpr std::string_view slow_and_fast = ": crowded is slow, sparse is fast";
constexpr std::string_view ruler_meaning = ": crowded is slow, sparse is fast; up: forward, down: back";

using Segment = std::pair<Point, Point>;

struct KeyMark {
  Point at;
  std::vector<std::string> words;
  bool start = false;
  bool end = false;
};

// An axis on the frames that are played, without the rolls, which are not on the path.
std::span<const double> on_the_path(const PlotMove& move, const PlotTrack& track, std::size_t axis) {
  return std::span(move.axes[track.axes[axis]].positions)
      .subspan(static_cast<std::size_t>(move.part.first - move.first_frame),
               static_cast<std::size_t>(move.part.last - move.part.first) + 1);
}

Range path_range(const PlotMove& move, const PlotTrack& track, std::size_t axis) {
  Range range = range_of(track.path[axis]);
  for (const std::span<const double> values :
       {std::span<const double>(track.keys[axis]), on_the_path(move, track, axis)}) {
    const Range more = range_of(values);
    range = {std::min(range.low, more.low), std::max(range.high, more.high)};
  }
  return range;
}

bool same_unit(const PlotMove& move, const PlotTrack& track, PlotPlane plane) {
  return move.axes[track.axes[plane.across]].unit == move.axes[track.axes[plane.up]].unit;
}

bool equal_scales(const PlotMove& move, const PlotTrack& track, PlotPlane plane) {
  const Range across = path_range(move, track, plane.across);
  const Range up = path_range(move, track, plane.up);
  const double longer = std::max(across.size(), up.size());
  const double shorter = std::min(across.size(), up.size());
  return same_unit(move, track, plane) && (longer <= longest_aspect * shorter || shorter <= 1e-9 * longer);
}

Box plane_area(const Box& panel) {
  return {panel.x + 58, panel.y + 48, panel.width - 58 - 14, panel.height - 48 - 42};
}

// Room for the markers and key numbers at the edge.
constexpr double edge = 26;

struct Scales {
  Scale x;
  Scale y;
};

Scales plane_scales(const PlotMove& move, const PlotTrack& track, PlotPlane plane, const Box& area) {
  const auto fit = [](Range range, double pixels, double pixels_per_unit) {
    const double spare = (pixels / pixels_per_unit - range.size()) / 2;
    return Range{range.low - spare, range.high + spare};
  };
  Range across = widened(path_range(move, track, plane.across), 0);
  Range up = widened(path_range(move, track, plane.up), 0);
  double x_pixels = (area.width - 2 * edge) / across.size();
  double y_pixels = (area.height - 2 * edge) / up.size();
  if (equal_scales(move, track, plane)) {
    // A coordinate that does not move has no size of its own to be fitted.
    const bool across_moves = path_range(move, track, plane.across).size() > 1e-9 * up.size();
    const bool up_moves = path_range(move, track, plane.up).size() > 1e-9 * across.size();
    const double common = across_moves == up_moves ? std::min(x_pixels, y_pixels)
                          : across_moves           ? x_pixels
                                                   : y_pixels;
    x_pixels = y_pixels = common;
  }
  across = fit(across, area.width, x_pixels);
  up = fit(up, area.height, y_pixels);
  return {Scale(across, area.x, area.right()), Scale(up, area.bottom(), area.y)};
}

std::vector<Point> path_on_page(const PlotTrack& track, PlotPlane plane, const Scales& scales) {
  std::vector<Point> points;
  const auto& across = track.path[plane.across];
  const auto& up = track.path[plane.up];
  for (std::size_t i = 0; i < across.size(); ++i) points.push_back({scales.x(across[i]), scales.y(up[i])});
  return points;
}

std::size_t tick_every(const PlotMove& move, double length) {
  const double tick_limit = std::clamp(length / min_tick_gap, 1.0, max_ticks);
  return static_cast<std::size_t>(round_step((move.part.last - move.part.first) / tick_limit));
}

std::string tick_remark(std::size_t every, bool any, std::string_view meaning) {
  if (!any) return "no motion to be seen here";
  if (every == 1) return fmt::format("a tick at every frame{}", meaning);
  return fmt::format("a tick at every {}{} frame{}", every, every == 2 ? "nd" : "th", meaning);
}

// Unit normal of the direction on the page; nothing where the path stands still in this plane.
std::optional<Point> normal_of(double dx, double dy) {
  const double length = std::hypot(dx, dy);
  if (!(length > 0) || !std::isfinite(length)) return std::nullopt;
  return Point{-dy / length, dx / length};
}

std::vector<Segment> plane_ticks(const PlotMove& move, const PlotTrack& track, PlotPlane plane,
                                 const Scales& scales, std::size_t every) {
  constexpr double half = 6;
  const std::span<const double> across = on_the_path(move, track, plane.across);
  const std::span<const double> up = on_the_path(move, track, plane.up);
  std::vector<Segment> ticks;
  std::optional<Point> normal;
  for (std::size_t j = 0; j < across.size(); j += every) {
    const std::size_t frame = j + static_cast<std::size_t>(move.part.first);
    const auto here = normal_of(track.tangents[plane.across][frame] * scales.x.pixels_per_unit(),
                                track.tangents[plane.up][frame] * scales.y.pixels_per_unit());
    // On a cusp the direction is undefined. The direction before it tells the eye more than a gap.
    if (here) normal = here;
    if (!normal) continue;
    const Point at{scales.x(across[j]), scales.y(up[j])};
    ticks.push_back({{at.x - half * normal->x, at.y - half * normal->y},
                     {at.x + half * normal->x, at.y + half * normal->y}});
  }
  return ticks;
}

KeyMark& mark_at(std::vector<KeyMark>& marks, Point at) {
  constexpr double same_place = 4;
  for (KeyMark& mark : marks) {
    if (std::hypot(mark.at.x - at.x, mark.at.y - at.y) <= same_place) return mark;
  }
  return marks.emplace_back(KeyMark{at, {}, false, false});
}

// More numbers than this hide the path.
std::size_t number_every(std::size_t keys) {
  constexpr double max_numbers = 30;
  return static_cast<std::size_t>(round_step(static_cast<double>(keys) / max_numbers));
}

// Keys that fall on one place of the page share a mark. The start is the first key; the end is where the path
// ends, which on a closed path is the first key again.
std::vector<KeyMark> key_marks(const std::vector<Point>& keys, Point path_end, bool closed) {
  std::vector<KeyMark> marks;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    KeyMark& mark = mark_at(marks, keys[i]);
    const bool start = i == 0;
    const bool end = i + 1 == keys.size() && !closed;
    mark.start = mark.start || start;
    mark.end = mark.end || end;
    if (!start && !end && i % number_every(keys.size()) != 0) continue;
    mark.words.push_back(fmt::format("{}{}{}", i, start ? " start" : "",
                                     !end    ? ""
                                     : start ? ", end"
                                             : " end"));
  }
  if (closed) {
    KeyMark& mark = mark_at(marks, path_end);
    mark.words.push_back("end");
    mark.end = true;
  }
  return marks;
}

std::string words_of(const KeyMark& mark) {
  constexpr std::size_t max_words = 4;
  if (mark.words.size() > max_words) return fmt::format("{} … {}", mark.words.front(), mark.words.back());
  return fmt::format("{}", fmt::join(mark.words, ", "));
}

void draw_mark(Canvas& canvas, const KeyMark& mark, double radius) {
  canvas.disc(mark.at, radius + 1.5, plot_color::paper);
  if (mark.end) {
    const double side = 2 * radius + 1;
    canvas.rectangle({mark.at.x - side / 2, mark.at.y - side / 2, side, side}, plot_color::key);
  }
  if (mark.start) {
    canvas.disc(mark.at, mark.end ? radius - 1 : radius + 0.5, plot_color::paper);
    if (!mark.end) canvas.ring(mark.at, radius + 0.5, {plot_color::key, 2});
  }
  if (!mark.start && !mark.end) canvas.disc(mark.at, radius, plot_color::key);
}

// Returns a remark for the heading if numbers are missing, otherwise "".
std::string draw_marks(Canvas& canvas, const Box& area, const std::vector<KeyMark>& marks, std::size_t keys,
                       std::span<const Point> drawing) {
  const double radius = keys > 60 ? 2.5 : 4.5;
  LabelPlacer labels(area);
  for (const Point p : drawing) labels.avoid(p);
  const auto is_end = [](const KeyMark& mark) { return mark.start || mark.end; };
  for (const KeyMark& mark : marks) {
    if (!is_end(mark)) draw_mark(canvas, mark, radius);
    for (int i = 0; i < 20; ++i) labels.avoid(mark.at);
  }
  for (const KeyMark& mark : marks) {
    if (is_end(mark)) draw_mark(canvas, mark, 4.5);
  }
  bool all = number_every(keys) == 1;
  const TextStyle style{.size = 12, .color = plot_color::ink, .bold = true};
  for (const KeyMark& mark : marks) {
    if (!mark.words.empty()) all = labels.place(canvas, mark.at, words_of(mark), style) && all;
  }
  return all ? "" : "; not every key is numbered";
}

void draw_across_title(Canvas& canvas, const Box& area, const PlotAxis& axis, const TickLabels& labels) {
  const TextStyle style{.size = 12, .color = plot_color::ink, .align = Align::center};
  const std::string title = axis_title(axis.name, axis.unit, labels);
  canvas.text({area.x + area.width / 2, area.bottom() + 35}, elided(canvas, title, style, area.width), style);
}

void draw_plane_axes(Canvas& canvas, const Box& panel, const Box& area, const Scales& scales,
                     const PlotAxis& across, const PlotAxis& up) {
  const TextStyle style{.size = 12, .color = plot_color::ink};
  const std::string title = axis_title(up.name, up.unit, draw_left_ticks(canvas, area, scales.y));
  canvas.text({panel.x, area.y - 10}, elided(canvas, title, style, panel.width), style);
  draw_across_title(canvas, area, across, draw_bottom_ticks(canvas, area, scales.x));
}

bool closed(const PlotTrack& track) {
  return track.key_frames.size() > track.keys.front().size();
}

// Points a few pixels apart, for labels to keep clear of.
std::vector<Point> spots_along(std::span<const Point> line) {
  constexpr double apart = 4;
  std::vector<Point> spots;
  for (std::size_t i = 1; i < line.size() && spots.size() < 5000; ++i) {
    const Point a = line[i - 1];
    const Point b = line[i];
    const int steps = 1 + static_cast<int>(std::hypot(b.x - a.x, b.y - a.y) / apart);
    for (int k = 0; k < steps; ++k) {
      const double t = static_cast<double>(k) / steps;
      spots.push_back({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)});
    }
  }
  return spots;
}

}  // namespace

double path_panel_height(const PlotMove& move, const PlotTrack& track, PlotPlane plane, double width) {
  constexpr double min_height = 270;
  constexpr double max_height = 470;
  const Range across = path_range(move, track, plane.across);
  const Range up = path_range(move, track, plane.up);
  if (!equal_scales(move, track, plane)) return 380;
  if (across.size() <= 0) return up.size() > 0 ? max_height : min_height;
  const Box area = plane_area({0, 0, width, 0});
  const double wanted = (area.width - 2 * edge) * (up.size() / across.size()) + 2 * edge;
  return std::clamp(wanted - area.height, min_height, max_height);
}

void draw_path_panel(Canvas& canvas, const Box& panel, const PlotMove& move, const PlotTrack& track,
                     PlotPlane plane, Color color) {
  const Box area = plane_area(panel);
  const Scales scales = plane_scales(move, track, plane, area);
  draw_plane_axes(canvas, panel, area, scales, move.axes[track.axes[plane.across]],
                  move.axes[track.axes[plane.up]]);
  const auto path = path_on_page(track, plane, scales);
  const auto line = simplified_to(path, max_points);
  const std::size_t every = tick_every(move, length_of(line));
  const auto ticks = plane_ticks(move, track, plane, scales, every);
  canvas.lines(ticks, tick_stroke);
  canvas.polyline(line, {color, 2});

  std::vector<Point> keys;
  for (std::size_t i = 0; i < track.keys[plane.across].size(); ++i) {
    keys.push_back({scales.x(track.keys[plane.across][i]), scales.y(track.keys[plane.up][i])});
  }
  auto spots = spots_along(line);
  for (const auto& [from, to] : ticks) spots.insert(spots.end(), {from, to});
  if (!track.passed.empty()) {
    for (std::size_t i = 0; i < keys.size(); ++i) {
      const Point passed{scales.x(track.passed[plane.across][i]), scales.y(track.passed[plane.up][i])};
      canvas.line(keys[i], passed, {plot_color::key, 1});
    }
  }
  std::string remarks = plane.up == 1
                            ? tick_remark(every, !ticks.empty(), slow_and_fast)
                            : "third axis over the first; " + tick_remark(every, !ticks.empty(), "");
  if (same_unit(move, track, plane) && !equal_scales(move, track, plane)) remarks += "; scales differ";
  remarks += draw_marks(canvas, area, key_marks(keys, path.back(), closed(track)), keys.size(), spots);
  draw_heading(canvas, {panel.x, panel.y + 14}, "Path", remarks, panel.width);
}

void draw_ruler(Canvas& canvas, const Box& panel, const PlotMove& move, const PlotTrack& track, Color color) {
  constexpr double tick_length = 24;
  const Box area{panel.x + 20, panel.y + 28, panel.width - 40, panel.height - 28 - 42};
  const double y = area.y + area.height / 2;
  const PlotAxis& axis = move.axes[track.axes.front()];
  const Range drawn = path_range(move, track, 0);
  const Scale x(widened(drawn, 0), area.x + edge, area.right() - edge);
  draw_across_title(canvas, area, axis, draw_bottom_ticks(canvas, area, x));

  std::vector<Point> path;
  for (const double value : track.path.front()) path.push_back({x(value), y});
  const std::size_t every = tick_every(move, length_of(path));
  std::vector<Segment> ticks;
  const std::span<const double> positions = on_the_path(move, track, 0);
  for (std::size_t j = 0; j < positions.size(); j += every) {
    const double direction = track.tangents.front()[j + static_cast<std::size_t>(move.part.first)];
    if (direction == 0) continue;
    const Point at{x(positions[j]), y};
    ticks.push_back({at, {at.x, direction > 0 ? y - tick_length : y + tick_length}});
  }
  canvas.lines(ticks, tick_stroke);
  const std::array<Point, 2> line{{{x(drawn.low), y}, {x(drawn.high), y}}};
  canvas.polyline(line, {color, 2});

  std::vector<Point> keys;
  for (const double value : track.keys.front()) keys.push_back({x(value), y});
  auto spots = spots_along(line);
  for (const auto& [from, to] : ticks) {
    for (int i = 1; i <= 12; ++i) spots.push_back({from.x, from.y + (to.y - from.y) * i / 12});
  }
  std::string remarks = tick_remark(every, !ticks.empty(), ruler_meaning);
  remarks += draw_marks(canvas, area, key_marks(keys, path.back(), closed(track)), keys.size(), spots);
  draw_heading(canvas, {panel.x, panel.y + 14}, "Path", remarks, panel.width);
}

}  // namespace inbetween
