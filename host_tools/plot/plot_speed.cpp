#include "host_tools/plot/plot_speed.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host_tools/plot/plot_line.hpp"
#include "host_tools/plot/plot_panel.hpp"
#include "host_tools/plot/plot_scale.hpp"

namespace inbetween {
namespace {

// phi at frame j of N, between the samples of the curve.
double curve_at_frame(const PlotTrack& track, std::size_t frame, std::size_t frames) {
  const double at =
      static_cast<double>(frame) / static_cast<double>(frames) * static_cast<double>(track.curve.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(at), track.curve.size() - 2);
  const double t = at - static_cast<double>(i);
  return (1 - t) * track.curve[i] + t * track.curve[i + 1];
}

// The speed along the path is phi times a factor that is the same at every frame, unless a key breaks the
// move.
struct SpeedPerPhi {
  double factor = 0;  // 0: nothing moves
  bool everywhere = true;
};

SpeedPerPhi speed_per_phi(const PlotTrack& track) {
  const double greatest = range_of(track.speed).high;
  if (track.curve.size() < 2 || !(greatest > 0)) return {};
  const std::size_t frames = track.speed.size() - 1;
  double products = 0;
  double squares = 0;
  for (std::size_t j = 0; j <= frames; ++j) {
    const double phi = curve_at_frame(track, j, frames);
    products += phi * (track.speed[j] / greatest);
    squares += phi * phi;
  }
  if (!(products > 0 && squares > 0)) return {};
  SpeedPerPhi found{greatest * (products / squares), true};
  for (std::size_t j = 0; j <= frames; ++j) {
    // The eye cannot tell 2 % apart on this panel.
    const double off = std::abs(track.speed[j] - found.factor * curve_at_frame(track, j, frames));
    if (off > 0.02 * greatest) found.everywhere = false;
  }
  return found;
}

std::string speed_unit(const PlotTrack& track) {
  return track.speed_unit.empty() ? "unit/s" : track.speed_unit;
}

void draw_frames_below(Canvas& canvas, const Box& area, const PlotMove& move) {
  const Scale frame({0, static_cast<double>(move.frames)}, area.x, area.right());
  const TextStyle style{.size = 11, .color = plot_color::quiet, .align = Align::center};
  for (const double tick : round_ticks(frame.range(), ticks_across(area.width), 1)) {
    canvas.line({frame(tick), area.bottom() + 20}, {frame(tick), area.bottom() + 23}, {plot_color::frame});
    canvas.text({frame(tick), area.bottom() + 34}, fmt::format("{:.0f}", tick), style);
  }
  canvas.text({area.x - 14, area.bottom() + 34}, "frame",
              {.size = 11, .color = plot_color::quiet, .align = Align::right});
}

/// What is not played is grey, behind the lines of the keys.
void draw_key_lines(Canvas& canvas, const Box& area, const PlotMove& move, const PlotTrack& track) {
  const Scale frame({0, static_cast<double>(move.frames)}, area.x, area.right());
  shade_outside(canvas, area, frame,
                {static_cast<double>(move.part.first), static_cast<double>(move.part.last)});
  constexpr std::size_t max_lines = 60;  // more lines would hide the curve
  if (track.key_frames.size() > max_lines) return;
  for (const double at : track.key_frames) {
    canvas.line({frame(at), area.y}, {frame(at), area.bottom()}, {plot_color::key.faded(0.45), 1, true});
  }
}

void draw_control_values(Canvas& canvas, const std::vector<double>& values, const Scale& a, const Scale& y) {
  std::vector<Point> polygon;
  for (std::size_t i = 0; i < values.size(); ++i)
    polygon.push_back({a(static_cast<double>(i)), y(values[i])});
  const double apart = std::abs(a.pixels_per_unit());
  const double radius = std::clamp(apart / 4, 1.2, 4.0);
  canvas.polyline(polygon, {plot_color::quiet.faded(0.6), 1});
  for (const Point p : polygon) {
    if (radius > 3) canvas.disc(p, radius + 1.2, plot_color::paper);
    canvas.disc(p, radius, plot_color::ink);
  }
}

// Speed alone, over frames: a track that is timed by frames has no curve.
void draw_plain_speed(Canvas& canvas, const Box& panel, const Box& area, const PlotMove& move,
                      const PlotTrack& track, Color color) {
  const std::vector<double>& line = track.speed_line.empty() ? track.speed : track.speed_line;
  const Range range = widened({0, range_of(line).high}, 0);
  const Scale y({std::min(0.0, range.low), range.high * 1.06}, area.bottom(), area.y);
  const Scale sample({0, static_cast<double>(line.size() - 1)}, area.x, area.right());
  const TickLabels labels = draw_left_ticks(canvas, area, y);
  draw_frames_below(canvas, area, move);
  draw_key_lines(canvas, area, move, track);
  canvas.polyline(series_line(line, sample, y), {color, 2});
  draw_heading(canvas, {panel.x, panel.y + 14}, "Speed",
               axis_title("along the path", speed_unit(track), labels) + "; vertical: keys", panel.width);
}

}  // namespace

void draw_speed_panel(Canvas& canvas, const Box& panel, const PlotMove& move, const PlotTrack& track,
                      Color color) {
  const Box area{panel.x + 58, panel.y + 34, panel.width - 58 - 64, panel.height - 34 - 42};
  if (track.curve.empty()) return draw_plain_speed(canvas, panel, area, move, track, color);
  const SpeedPerPhi real = speed_per_phi(track);
  double top = std::max(range_of(track.control_values).high, range_of(track.curve).high);
  if (!real.everywhere) top = std::max(top, range_of(track.speed).high / real.factor);
  const Range range{0, top > 0 ? 1.06 * top : 1};
  const Scale y(range, area.bottom(), area.y);
  const double f = static_cast<double>(std::max<std::size_t>(track.control_values.size(), 2) - 1);
  const Scale a({0, f}, area.x, area.right());
  const Scale sample({0, static_cast<double>(track.curve.size() - 1)}, area.x, area.right());

  draw_left_ticks(canvas, area, y);
  const TextStyle style{.size = 11, .color = plot_color::quiet, .align = Align::center};
  for (const double tick : round_ticks(a.range(), ticks_across(area.width), 1)) {
    canvas.line({a(tick), area.y}, {a(tick), area.bottom()}, {plot_color::grid});
    canvas.text({a(tick), area.bottom() + 16}, fmt::format("{:.0f}", tick), style);
  }
  canvas.text({area.x - 14, area.bottom() + 16}, "a",
              {.size = 11, .color = plot_color::quiet, .align = Align::right});
  draw_frames_below(canvas, area, move);
  draw_key_lines(canvas, area, move, track);

  std::string remarks = "drawn, with control values";
  if (real.factor > 0) {
    const Scale speed({0, range.high * real.factor}, area.bottom(), area.y);
    const TickLabels labels = draw_right_ticks(canvas, area, speed);
    remarks += real.everywhere ? "; right" : "; right, dashed";
    remarks += axis_title(": along the path", speed_unit(track), labels);
    if (!real.everywhere) {
      const Scale frame({0, static_cast<double>(move.frames)}, area.x, area.right());
      canvas.polyline(series_line(track.speed, frame, speed), {plot_color::ink.faded(0.7), 1.2, true});
    }
  }
  remarks += "; vertical: keys";
  canvas.polyline(series_line(track.curve, sample, y), {color, 2.2});
  draw_control_values(canvas, track.control_values, a, y);
  draw_heading(canvas, {panel.x, panel.y + 14}, "Speed curve", remarks, panel.width);
}

}  // namespace inbetween
