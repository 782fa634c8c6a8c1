#include "host_tools/plot/plot_time.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "host_tools/plot/plot_line.hpp"
#include "host_tools/plot/plot_panel.hpp"
#include "host_tools/plot/plot_scale.hpp"

namespace inbetween {
namespace {

// Narrower than this on average, stripes run together.
constexpr double min_stripe = 4;

// Share of the distance that is travelled at each of the frames that are played, 0 at the first and 1 at the
// last.
struct Progress {
  std::vector<double> at_frame;
  std::int32_t first = 0;
  bool moves = true;

  [[nodiscard]] double at(double frame) const {
    const double last = static_cast<double>(at_frame.size() - 1);
    const double clipped = std::clamp(frame - first, 0.0, last);
    const std::size_t i = std::min(static_cast<std::size_t>(clipped), at_frame.size() - 2);
    const double t = clipped - static_cast<double>(i);
    return (1 - t) * at_frame[i] + t * at_frame[i + 1];
  }
};

Progress progress_of(const PlotMove& move, const PlotTrack& track) {
  Progress out{.at_frame = {0}, .first = move.part.first};
  const std::span<const double> speed =
      std::span(track.speed)
          .subspan(static_cast<std::size_t>(move.part.first),
                   static_cast<std::size_t>(move.part.last - move.part.first) + 1);
  const double greatest = range_of(speed).high;
  for (std::size_t j = 1; j < speed.size(); ++j) {
    const double step = greatest > 0 ? (speed[j - 1] + speed[j]) / greatest : 0;
    out.at_frame.push_back(out.at_frame.back() + step);
  }
  const double total = out.at_frame.back();
  out.moves = total > 0;
  for (std::size_t j = 0; j < out.at_frame.size(); ++j) {
    out.at_frame[j] = out.moves ? out.at_frame[j] / total
                                : static_cast<double>(j) / static_cast<double>(out.at_frame.size() - 1);
  }
  return out;
}

bool is_played(const PlotMove& move, double frame) {
  return frame >= move.part.first && frame <= move.part.last;
}

/// For how many frames the rig rests at the key.
double hold_of(const PlotTrack& track, std::size_t key) {
  return track.key_holds.empty() ? 0 : track.key_holds[key];
}

void draw_keys_above(Canvas& canvas, const Box& bar, const PlotMove& move, const PlotTrack& track,
                     const Progress& progress) {
  std::vector<double> at;
  std::vector<std::string> labels;
  for (std::size_t i = 0; i < track.key_frames.size(); ++i) {
    if (!is_played(move, track.key_frames[i])) continue;
    const double x = bar.x + progress.at(track.key_frames[i]) * bar.width;
    canvas.polygon(std::vector<Point>{{x, bar.y - 1}, {x - 4.5, bar.y - 9}, {x + 4.5, bar.y - 9}},
                   plot_color::key);
    at.push_back(x);
    labels.push_back(fmt::format("{}", i % track.keys.front().size()));
    const double hold = hold_of(track, i);
    if (hold > 0) labels.back() += fmt::format(" (rests {:g} {})", hold, hold == 1 ? "frame" : "frames");
  }
  draw_row_of_labels(canvas, at, bar.y - 13, labels, {.size = 12, .color = plot_color::ink, .bold = true});
}

void draw_frames_below(Canvas& canvas, const Box& bar, const PlotMove& move, const Progress& progress) {
  std::vector<double> at;
  std::vector<std::string> labels;
  const double first = move.part.first;
  const double last = move.part.last;
  std::vector<double> ticks{first};
  for (const double tick : round_ticks({first, last}, 40, 1)) {
    if (tick > first) ticks.push_back(tick);
  }
  if (ticks.back() < last) ticks.push_back(last);
  for (const double tick : ticks) {
    at.push_back(bar.x + progress.at(tick) * bar.width);
    labels.push_back(fmt::format("{:.0f}", tick));
    canvas.line({at.back(), bar.bottom()}, {at.back(), bar.bottom() + 4}, {plot_color::quiet});
  }
  draw_row_of_labels(canvas, at, bar.bottom() + 17, labels, {.size = 11, .color = plot_color::quiet});
}

std::string stripe_remark(const Progress& progress, std::size_t every) {
  const std::string stripe = every == 1 ? "a stripe per frame" : fmt::format("a stripe per {} frames", every);
  return progress.moves
             ? stripe + ", as wide as the distance travelled in it; keys above, frames below"
             : stripe + ", all equally wide because no frame has a speed; keys above, frames below";
}

// Beside the rows of the axes: names and numbers on the left, limits on the right.
constexpr double left_of_rows = 200;
constexpr double right_of_rows = 110;

struct LimitLabel {
  std::string words;
  double base_line = 0;
};

// Draws the line of a limit where it lies in the row; where not, its label has an arrow towards it.
LimitLabel draw_limit(Canvas& canvas, const Box& area, const Scale& y, std::string_view name, double limit) {
  const double top = area.y + 7;
  const double bottom = area.bottom() - 2;
  if (limit > y.range().high) return {fmt::format("↑ {} {}", name, limit), top};
  if (limit < y.range().low) return {fmt::format("↓ {} {}", name, limit), bottom};
  canvas.line({area.x, y(limit)}, {area.right(), y(limit)}, {plot_color::limit, 1, true});
  return {fmt::format("{} {}", name, limit), std::clamp(y(limit) + 4, top, bottom)};
}

void draw_limits(Canvas& canvas, const Box& area, const PlotAxis& axis, const Scale& y) {
  constexpr double line_of_text = 12;
  const TextStyle style{.size = 11, .color = plot_color::quiet};
  LimitLabel maximum;
  LimitLabel minimum;
  if (axis.maximum) maximum = draw_limit(canvas, area, y, "max", *axis.maximum);
  if (axis.minimum) minimum = draw_limit(canvas, area, y, "min", *axis.minimum);
  if (axis.maximum && axis.minimum) {
    maximum.base_line = std::min(maximum.base_line, area.bottom() - 2 - line_of_text);
    minimum.base_line = std::max(minimum.base_line, maximum.base_line + line_of_text);
  }
  for (const LimitLabel& label : {maximum, minimum}) {
    canvas.text({area.right() + 8, label.base_line}, label.words,
                shrunk(canvas, label.words, style, right_of_rows));
  }
}

const std::vector<double>& line_of(const PlotAxis& axis) {
  return axis.line.empty() ? axis.positions : axis.line;
}

// The moved range, keys that are passed in some distance, and each limit that is not much further out.
Range row_range(const PlotAxis& axis, std::span<const double> passed_keys) {
  constexpr double rounding = 1e-12;  // of a position, in any unit that a rig is measured in
  Range moved = range_of(line_of(axis));
  for (const double key : passed_keys) moved = {std::min(moved.low, key), std::max(moved.high, key)};
  if (moved.size() < rounding) moved = {moved.low, moved.low};
  moved = widened(moved, 0);
  const Range near = widened(moved, 0.6);
  Range shown = moved;
  for (const auto& limit : {axis.minimum, axis.maximum}) {
    if (limit && near.contains(*limit)) shown = {std::min(shown.low, *limit), std::max(shown.high, *limit)};
  }
  return widened(shown, 0.08);
}

// The track that moves an axis, and which of its axes that is.
struct Mover {
  const PlotTrack* track = nullptr;
  std::size_t index = 0;
  std::size_t axis = 0;
};

Mover mover_of(const PlotMove& move, std::size_t axis) {
  for (std::size_t t = 0; t < move.tracks.size(); ++t) {
    const auto& axes = move.tracks[t].axes;
    const auto found = std::find(axes.begin(), axes.end(), axis);
    if (found != axes.end()) return {&move.tracks[t], t, static_cast<std::size_t>(found - axes.begin())};
  }
  return {};
}

Range range_in_frames(const PlotMove& move) {
  return {static_cast<double>(move.first_frame), static_cast<double>(move.last_frame)};
}

/// A row that is lower has its unit behind its name.
constexpr double two_lines = 32;

void draw_row(Canvas& canvas, const Box& area, double left, const PlotMove& move, std::size_t index) {
  const PlotAxis& axis = move.axes[index];
  const Mover mover = mover_of(move, index);
  const bool passes_keys = mover.track != nullptr && !mover.track->passed.empty();
  const std::span<const double> passed_keys =
      passes_keys ? std::span<const double>(mover.track->keys[mover.axis]) : std::span<const double>();
  const Scale y(row_range(axis, passed_keys), area.bottom(), area.y);
  const Scale x(range_in_frames(move), area.x, area.right());
  shade_outside(canvas, area, x, {static_cast<double>(move.part.first), static_cast<double>(move.part.last)});
  const TickLabels labels = draw_left_ticks(canvas, area, y);
  canvas.outline(area, {plot_color::frame});
  const TextStyle bold{.size = 12, .color = plot_color::ink, .bold = true};
  const TextStyle plain{.size = 11, .color = plot_color::quiet};
  const double room = area.x - left - 62;
  const double middle = area.y + area.height / 2;
  if (area.height < two_lines) {
    canvas.text({left, middle + 4}, elided(canvas, axis_title(axis.name, axis.unit, labels), bold, room),
                bold);
  } else {
    std::string below = axis_title("", axis.unit, labels);
    if (!below.empty()) below.erase(0, 1);  // the space behind the name
    canvas.text({left, below.empty() ? middle + 4 : middle - 2}, elided(canvas, axis.name, bold, room), bold);
    canvas.text({left, middle + 13}, elided(canvas, below, plain, room), plain);
  }
  draw_limits(canvas, area, axis, y);
  const Color color = mover.track ? track_color(mover.index) : plot_color::quiet;
  // The samples of the line count from 0.
  const std::vector<double>& line = line_of(axis);
  const Scale sample({0, static_cast<double>(line.size() - 1)}, area.x, area.right());
  canvas.polyline(series_line(line, sample, y), {color, 2});
  if (!mover.track) return;
  const auto& keys = mover.track->keys[mover.axis];
  const double radius = keys.size() > 60 ? 1.8 : 3;
  for (std::size_t i = 0; i < mover.track->key_frames.size(); ++i) {
    if (!is_played(move, mover.track->key_frames[i])) continue;
    // A closed path ends where it began, or a whole turn further.
    const double at = i < keys.size() ? keys[i] : mover.track->path[mover.axis].back();
    const Point begin{x(mover.track->key_frames[i]), y(at)};
    canvas.disc(begin, radius, plot_color::key);
    if (passes_keys && i < keys.size()) {
      canvas.line(begin, {begin.x, y(mover.track->passed[mover.axis][i])}, {plot_color::key, 1});
    }
    const double hold = hold_of(*mover.track, i);
    if (hold == 0) continue;
    const double to = std::min(mover.track->key_frames[i] + hold, static_cast<double>(move.part.last));
    const Point end{x(to), begin.y};
    canvas.line(begin, end, {plot_color::key, radius});
    canvas.disc(end, radius, plot_color::key);
  }
}

double height_of_row(std::size_t axes) {
  return axes <= 8 ? 92 : axes <= 24 ? 64 : 46;
}

constexpr double over_rows = 52;
constexpr double under_rows = 40;
/// Between the rows of so many axes.
double gap_of_rows(std::size_t axes) {
  return axes <= 24 ? 12 : 4;
}

void draw_time_ticks(Canvas& canvas, const Box& rows, const PlotMove& move) {
  const TextStyle style{.size = 11, .color = plot_color::quiet, .align = Align::center};
  const Range shown = range_in_frames(move);
  const Scale frame(shown, rows.x, rows.right());
  for (const double tick : round_ticks(frame.range(), ticks_across(rows.width), 1)) {
    canvas.line({frame(tick), rows.y}, {frame(tick), rows.bottom()}, {plot_color::grid});
    canvas.text({frame(tick), rows.bottom() + 16}, fmt::format("{:.0f}", tick), style);
  }
  const Scale second({shown.low / move.frames_per_second, shown.high / move.frames_per_second}, rows.x,
                     rows.right());
  const auto ticks = round_ticks(second.range(), ticks_across(rows.width));
  const TickLabels labels = tick_labels(ticks);
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    canvas.line({second(ticks[i]), rows.y - 4}, {second(ticks[i]), rows.y}, {plot_color::frame});
    canvas.text({second(ticks[i]), rows.y - 8}, labels.labels[i], style);
  }
  const TextStyle name{.size = 11, .color = plot_color::quiet, .align = Align::right};
  canvas.text({rows.x - 24, rows.y - 8}, axis_title("seconds", "", labels), name);
  canvas.text({rows.x - 24, rows.bottom() + 16}, "frames", name);
}

}  // namespace

void draw_time_bar(Canvas& canvas, const Box& panel, const PlotMove& move, const PlotTrack& track,
                   Color color) {
  const Box bar{panel.x + 8, panel.y + 52, panel.width - 16, 40};
  const Progress progress = progress_of(move, track);
  const std::int32_t frames = move.part.last - move.part.first;
  const auto every = static_cast<std::size_t>(round_step(std::max(1.0, frames * min_stripe / bar.width)));
  canvas.rectangle(bar, color.faded(0.25));
  std::vector<Box> stripes;
  for (std::size_t j = 0; j + 1 < progress.at_frame.size(); j += 2 * every) {
    const double from = bar.x + progress.at_frame[j] * bar.width;
    const double to =
        bar.x + progress.at_frame[std::min(j + every, progress.at_frame.size() - 1)] * bar.width;
    if (to > from) stripes.push_back({from, bar.y, to - from, bar.height});
  }
  canvas.rectangles(stripes, color);
  draw_keys_above(canvas, bar, move, track, progress);
  draw_frames_below(canvas, bar, move, progress);
  draw_heading(canvas, {panel.x, panel.y + 14}, "Time bar", stripe_remark(progress, every), panel.width);
}

double positions_height(const PlotMove& move) {
  const double gap = gap_of_rows(move.axes.size());
  const auto rows = static_cast<double>(move.axes.size());
  return over_rows + rows * (height_of_row(move.axes.size()) + gap) - gap + under_rows;
}

std::string dots_in_words(const PlotMove& move) {
  const bool passes =
      std::ranges::any_of(move.tracks, [](const PlotTrack& track) { return !track.passed.empty(); });
  return passes ? "dots: keys, a line to where the axis is then" : "dots: keys";
}

void draw_positions(Canvas& canvas, const Box& panel, const PlotMove& move) {
  const double gap = gap_of_rows(move.axes.size());
  const double height =
      (panel.height - over_rows - under_rows + gap) / static_cast<double>(move.axes.size()) - gap;
  Box area{panel.x + left_of_rows, panel.y + over_rows, panel.width - left_of_rows - right_of_rows, height};
  const bool rolls = move.first_frame < move.part.first || move.last_frame > move.part.last;
  draw_heading(
      canvas, {panel.x, panel.y + 14}, "Axis positions",
      dots_in_words(move) + (rolls ? "; dashed: limits; grey: pre-roll and post-roll" : "; dashed: limits"),
      panel.width);
  draw_time_ticks(canvas, {area.x, area.y, area.width, panel.height - over_rows - under_rows}, move);
  for (std::size_t i = 0; i < move.axes.size(); ++i) {
    draw_row(canvas, area, panel.x, move, i);
    area.y += height + gap;
  }
}

}  // namespace inbetween
