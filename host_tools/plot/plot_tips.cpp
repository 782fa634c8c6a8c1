#include "host_tools/plot/plot_tips.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host_tools/plot/plot_line.hpp"
#include "host_tools/plot/plot_panel.hpp"
#include "host_tools/plot/plot_scale.hpp"

namespace inbetween {
namespace {

constexpr double view_gap = 36;
/// More postures than this hide the path.
constexpr double max_postures = 24;
constexpr Stroke bone_stroke{plot_color::limit.faded(0.8), 1.5};
constexpr Stroke shadow_stroke{plot_color::frame, 1.5};

enum class View { plan, elevation, perspective };

/// Where the points of a view are on its picture plane, in metres there.
class Projection {
 public:
  /// The perspective looks at the middle of `places` from the front, the right and above, from so far away
  /// that its lines converge a little.
  Projection(View view, const std::vector<PlotPlace>& places) : view_(view) {
    if (view != View::perspective) return;
    PlotPlace low = places.front();
    PlotPlace high = places.front();
    for (const PlotPlace& place : places) {
      for (std::size_t d = 0; d < 3; ++d) {
        low[d] = std::min(low[d], place[d]);
        high[d] = std::max(high[d], place[d]);
      }
    }
    double squares = 0;
    for (std::size_t d = 0; d < 3; ++d) {
      middle_[d] = (low[d] + high[d]) / 2;
      squares += (high[d] - low[d]) * (high[d] - low[d]);
    }
    eye_distance_ = 2.5 * std::max(std::sqrt(squares), 1e-9);
  }

  [[nodiscard]] Point operator()(const PlotPlace& place) const {
    if (view_ == View::plan) return {place[0], place[1]};
    if (view_ == View::elevation) return {place[0], place[2]};
    // The eye is 35 degrees to the right of the front, where y is least, and 25 degrees up.
    constexpr double right_x = 0.8192, right_y = 0.5736, up = 0.4226, level = 0.9063;
    const double x = place[0] - middle_[0];
    const double y = place[1] - middle_[1];
    const double z = place[2] - middle_[2];
    const double across = x * right_x + y * right_y;
    const double away = y * right_x - x * right_y;
    const double depth = eye_distance_ + away * level - z * up;
    const double size = eye_distance_ / depth;
    return {across * size, (z * level + away * up) * size};
  }

 private:
  View view_;
  PlotPlace middle_{};
  double eye_distance_ = 1;
};

/// The path on the floor of the picture, which shows in the perspective how high the tip is.
std::vector<PlotPlace> shadow_of(const PlotTip& tip, double floor) {
  std::vector<PlotPlace> shadow = tip.places;
  for (PlotPlace& place : shadow) place[2] = floor;
  return shadow;
}

/// Everything that a picture of the tip shows.
std::vector<PlotPlace> all_places(const PlotTip& tip) {
  std::vector<PlotPlace> places = tip.places;
  for (const PlotPosture& posture : tip.postures) {
    for (const auto& [from, to] : posture.bones) places.insert(places.end(), {from, to});
    if (posture.aim) places.push_back(*posture.aim);
  }
  return places;
}

/// As the tip looks: to the point at which it is to look, and otherwise a short distance.
struct Look {
  PlotPlace from{}, to{};
};
Look look_of(const PlotPosture& posture, double metres) {
  PlotPlace to = posture.tip;
  double away = 0;
  for (std::size_t d = 0; d < 3; ++d) {
    if (posture.aim) away += std::pow((*posture.aim)[d] - posture.tip[d], 2);
  }
  if (away > 0) metres = std::min(metres, std::sqrt(away));
  for (std::size_t d = 0; d < 3; ++d) to[d] += metres * posture.view[d];
  return {posture.tip, to};
}

/// One scale for both directions, in which `points` fill the area.
struct PictureScale {
  Scale x, y;

  [[nodiscard]] Point operator()(Point point) const { return {x(point.x), y(point.y)}; }
  [[nodiscard]] double pixels_per_metre() const { return std::fabs(x(1) - x(0)); }
};

PictureScale fitted(const std::vector<Point>& points, const Box& area) {
  constexpr double margin = 22;
  std::vector<double> across;
  std::vector<double> up;
  for (const Point& point : points) {
    across.push_back(point.x);
    up.push_back(point.y);
  }
  Range x = range_of(across);
  Range y = range_of(up);
  const double nothing = 1e-6 * (1 + std::fabs(x.low) + std::fabs(y.low));
  const double metres = std::max({x.size() / (area.width - 2 * margin), y.size() / (area.height - 2 * margin),
                                  nothing / area.width});  // a pixel
  const auto around = [&](const Range& range, double pixels) {
    const double middle = (range.low + range.high) / 2;
    return Range{middle - metres * pixels / 2, middle + metres * pixels / 2};
  };
  return {Scale(around(x, area.width), area.x, area.right()),
          Scale(around(y, area.height), area.bottom(), area.y)};
}

std::vector<Point> on_page(const std::vector<PlotPlace>& places, const Projection& projection,
                           const PictureScale& scale) {
  std::vector<Point> points;
  points.reserve(places.size());
  for (const PlotPlace& place : places) points.push_back(scale(projection(place)));
  return points;
}

/// Across the path on the page, where it moves there.
std::vector<std::pair<Point, Point>> frame_ticks(const std::vector<Point>& path, std::size_t every) {
  constexpr double half = 5;
  std::vector<std::pair<Point, Point>> ticks;
  for (std::size_t j = 0; j < path.size(); j += every) {
    const Point& before = path[j == 0 ? 0 : j - 1];
    const Point& after = path[std::min(j + 1, path.size() - 1)];
    const double length = std::hypot(after.x - before.x, after.y - before.y);
    if (!(length > 1e-6)) continue;
    const double x = -half * (after.y - before.y) / length;
    const double y = half * (after.x - before.x) / length;
    ticks.push_back({{path[j].x - x, path[j].y - y}, {path[j].x + x, path[j].y + y}});
  }
  return ticks;
}

void draw_view_axes(Canvas& canvas, const Box& area, const PictureScale& scale, View view) {
  const TextStyle style{.size = 12, .color = plot_color::ink};
  const char* up = view == View::plan ? "y" : "z";
  canvas.text({area.x - 40, area.y - 8}, axis_title(up, "m", draw_left_ticks(canvas, area, scale.y)), style);
  const TickLabels labels = draw_bottom_ticks(canvas, area, scale.x);
  canvas.text({area.x + area.width / 2, area.bottom() + 35}, axis_title("x", "m", labels),
              {.size = 12, .color = plot_color::ink, .align = Align::center});
}

/// The directions x, y and z in a corner.
void draw_directions(Canvas& canvas, const Box& area) {
  constexpr double length = 28;
  const Projection directions(View::perspective, {{-1, -1, -1}, {1, 1, 1}});
  const Point corner{area.x + 34, area.bottom() - 30};
  for (const auto& [name, place] :
       {std::pair<const char*, PlotPlace>{"x", {1, 0, 0}}, std::pair<const char*, PlotPlace>{"y", {0, 1, 0}},
        std::pair<const char*, PlotPlace>{"z", {0, 0, 1}}}) {
    const Point to = directions(place);
    const Point end{corner.x + length * to.x, corner.y - length * to.y};
    canvas.line(corner, end, {plot_color::quiet, 1.5});
    canvas.text({end.x + 3, end.y - 2}, name, {.size = 11, .color = plot_color::quiet});
  }
}

/// An arrow as it looks, and where it is to look a cross with a dotted line to it.
void draw_look(Canvas& canvas, const PlotPosture& posture, const Projection& projection,
               const PictureScale& scale) {
  constexpr double pixels = 34;
  constexpr double head = 5;
  const Look look = look_of(posture, pixels / scale.pixels_per_metre());
  const Point from = scale(projection(look.from));
  const Point to = scale(projection(look.to));
  if (posture.aim) {
    const Point aim = scale(projection(*posture.aim));
    canvas.line(from, aim, {plot_color::aim.faded(0.5), 1, true});
    canvas.line({aim.x - head, aim.y - head}, {aim.x + head, aim.y + head}, {plot_color::aim, 2});
    canvas.line({aim.x - head, aim.y + head}, {aim.x + head, aim.y - head}, {plot_color::aim, 2});
  }
  const double length = std::hypot(to.x - from.x, to.y - from.y);
  if (length < 2) return;  // towards the eye, or away from it
  const Point along{(to.x - from.x) / length, (to.y - from.y) / length};
  canvas.line(from, to, {plot_color::aim, 1.8});
  canvas.polygon(std::vector<Point>{{to.x + head * along.x, to.y + head * along.y},
                                    {to.x - 0.6 * head * along.y, to.y + 0.6 * head * along.x},
                                    {to.x + 0.6 * head * along.y, to.y - 0.6 * head * along.x}},
                 plot_color::aim);
}

void draw_postures(Canvas& canvas, const Box& area, const PlotTip& tip, const Projection& projection,
                   const PictureScale& scale, const std::vector<Point>& path) {
  const auto every =
      static_cast<std::size_t>(round_step(static_cast<double>(tip.postures.size()) / max_postures));
  LabelPlacer labels(area);
  for (const Point& point : path) labels.avoid(point);
  for (std::size_t i = 0; i < tip.postures.size(); i += every) {
    std::vector<std::pair<Point, Point>> bones;
    for (const auto& [from, to] : tip.postures[i].bones) {
      bones.emplace_back(scale(projection(from)), scale(projection(to)));
    }
    canvas.lines(bones, bone_stroke);
    for (const auto& [from, to] : bones) canvas.disc(to, 2.2, plot_color::limit);
  }
  for (std::size_t i = 0; i < tip.postures.size(); i += every) {
    const Point at = scale(projection(tip.postures[i].tip));
    draw_look(canvas, tip.postures[i], projection, scale);
    canvas.disc(at, 4, plot_color::key);
    // A label without room is left out: the frames of all keys stand below the speed curves too.
    static_cast<void>(labels.place(canvas, at, fmt::format("{}", std::round(10 * tip.postures[i].frame) / 10),
                                   {.size = 12, .color = plot_color::ink, .bold = true}));
  }
}

std::string_view name_of(View view) {
  return view == View::plan ? "Plan" : view == View::elevation ? "Elevation" : "Perspective";
}

void draw_view(Canvas& canvas, const Box& panel, const PlotMove& move, const PlotTip& tip, View view,
               Color color, std::string_view name) {
  const Box area{panel.x + 48, panel.y + 48, panel.width - 48 - 8, panel.height - 48 - 42};
  std::vector<PlotPlace> places = all_places(tip);
  const auto lowest = std::ranges::min_element(places, {}, [](const PlotPlace& place) { return place[2]; });
  const std::vector<PlotPlace> shadow = shadow_of(tip, (*lowest)[2]);
  if (view == View::perspective) places.insert(places.end(), shadow.begin(), shadow.end());
  const Projection projection(view, places);
  std::vector<Point> flat;
  flat.reserve(places.size());
  for (const PlotPlace& place : places) flat.push_back(projection(place));
  const PictureScale scale = fitted(flat, area);
  const std::vector<Point> path = on_page(tip.places, projection, scale);
  const double length = length_of(path);
  const auto every = static_cast<std::size_t>(
      round_step((move.part.last - move.part.first) / std::clamp(length / 4.5, 1.0, 1000.0)));
  if (view == View::perspective) {
    canvas.polyline(simplified_to(on_page(shadow, projection, scale), 5000), shadow_stroke);
    draw_directions(canvas, area);
  } else {
    draw_view_axes(canvas, area, scale, view);
  }
  draw_postures(canvas, area, tip, projection, scale, path);
  canvas.lines(frame_ticks(path, every), {plot_color::ink.faded(0.75), 1});
  canvas.polyline(simplified_to(path, 20'000), {color, 2});
  const std::string ticks = every == 1
                                ? "a tick at every frame"
                                : fmt::format("a tick at every {}{} frame", every, every == 2 ? "nd" : "th");
  const std::string remarks = view == View::perspective ? "grey below: the path on the floor" : ticks;
  draw_heading(canvas, {panel.x, panel.y + 14}, name, remarks, panel.width);
}

}  // namespace

void draw_tip(Canvas& canvas, const Box& area, const PlotMove& move, const PlotTip& tip, Color color) {
  const double width = (area.width - 2 * view_gap) / 3;
  Box panel{area.x, area.y, width, area.height};
  for (const View view : {View::plan, View::elevation, View::perspective}) {
    draw_view(canvas, panel, move, tip, view, color, name_of(view));
    panel.x += width + view_gap;
  }
}

namespace {

constexpr double low_tip_height = 330;

std::size_t tips_across(std::size_t tips) {
  return tips <= 4 ? tips : std::max<std::size_t>(4, (tips + 1) / 2);
}

}  // namespace

void draw_tips(Canvas& canvas, const Box& area, const PlotMove& move) {
  const std::size_t across = tips_across(move.tips.size());
  const auto columns = static_cast<double>(std::max<std::size_t>(across, 3));
  const double width = (area.width - (columns - 1) * view_gap) / columns;
  for (std::size_t i = 0; i < move.tips.size(); ++i) {
    const std::size_t line = i / across;
    const Box panel{area.x + static_cast<double>(i % across) * (width + view_gap),
                    area.y + static_cast<double>(line) * low_tip_height, width, low_tip_height};
    draw_view(canvas, panel, move, move.tips[i], View::perspective, track_color(i), move.tips[i].name);
  }
}

double tips_height(std::size_t tips) {
  if (tips == 0) return 0;
  const std::size_t lines = (tips - 1) / tips_across(tips) + 1;
  return low_tip_height * static_cast<double>(lines);
}

}  // namespace inbetween
