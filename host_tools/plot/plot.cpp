#include "host_tools/plot/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <string_view>

#include "host_tools/plot/plot_panel.hpp"
#include "host_tools/plot/plot_path.hpp"
#include "host_tools/plot/plot_speed.hpp"
#include "host_tools/plot/plot_time.hpp"
#include "host_tools/plot/plot_tips.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/frame_range.hpp"

namespace inbetween {
namespace {

constexpr double gutter = 36;
constexpr double left_width = 640;
constexpr double track_title_height = 40;
constexpr double section_gap = 26;
// Beyond this, the width of a range overflows.
constexpr double greatest_value = 1e300;

// The places of all parts, from the top of the page down.
struct TrackLayout {
  double title = 0;  // base line
  Box path;
  std::optional<Box> third;  // the plane of the first and the third axis
  Box speed;
  Box bar;
};

struct Layout {
  std::vector<std::optional<TrackLayout>> tracks;  // those that are shown
  std::vector<Box> tips;                           // without their titles: one for each, or for all
  Box positions;
  double height = 0;
};

// The path stands on the left, the speed curve on the right, the time bar below both.
TrackLayout track_layout(const PlotMove& move, const PlotTrack& track, double y) {
  constexpr double third_height = 270;
  constexpr double speed_beside_third = 230;
  const bool third = track.axes.size() > 2;
  const double right = page_margin + left_width + gutter;
  const double right_width = content_width - left_width - gutter;
  const double height = third                    ? speed_beside_third + section_gap + third_height
                        : track.axes.size() == 1 ? ruler_height
                                                 : path_panel_height(move, track, {0, 1}, left_width);
  TrackLayout out;
  out.path = {page_margin, y, left_width, height};
  out.speed = {right, y, right_width, third ? speed_beside_third : height};
  if (third) out.third = Box{right, out.speed.bottom() + section_gap, right_width, third_height};
  out.bar = {page_margin, y + height + section_gap, content_width, time_bar_height};
  return out;
}

/// From `y` on; returns where they end.
double lay_out_tracks(const PlotMove& move, bool has_all, double y, Layout& out) {
  for (const PlotTrack& track : move.tracks) {
    if (!has_all && track.control_values.empty()) {
      out.tracks.emplace_back();
      continue;
    }
    TrackLayout next = track_layout(move, track, y + track_title_height);
    next.title = y + 18;
    y = next.bar.bottom() + section_gap;
    out.tracks.emplace_back(next);
  }
  return y;
}

/// The positions come first, in rows so low that a page without speed curves is no higher than a sheet.
Layout layout_of_puppet(const PlotMove& move) {
  Layout out;
  constexpr double top = page_margin + title_height;
  const double tips =
      move.tips.empty() ? 0 : track_title_height + tips_height(move.tips.size()) + section_gap;
  const double room = sheet_height - page_margin / 2 - top - section_gap - tips;
  out.positions = {page_margin, top, content_width, std::min(positions_height(move), room)};
  const double y = lay_out_tracks(move, false, out.positions.bottom() + section_gap, out);
  double bottom = y - section_gap;
  if (!move.tips.empty()) {
    out.tips.push_back({page_margin, y + track_title_height, content_width, tips_height(move.tips.size())});
    bottom = out.tips.back().bottom();
  }
  out.height = std::ceil(bottom + page_margin / 2);
  return out;
}

Layout layout_of(const PlotMove& move) {
  if (is_puppet(move)) return layout_of_puppet(move);
  Layout out;
  double y = lay_out_tracks(move, true, page_margin + title_height, out);
  for (std::size_t i = 0; i < move.tips.size(); ++i) {
    out.tips.push_back({page_margin, y + track_title_height, content_width, tip_height});
    y = out.tips.back().bottom() + section_gap;
  }
  out.positions = {page_margin, y, content_width, positions_height(move)};
  out.height = std::ceil(out.positions.bottom() + page_margin / 2);
  return out;
}

std::string summary(const PlotMove& move) {
  const double milliseconds =
      std::round(1000 * ((move.part.last - move.part.first) / move.frames_per_second));
  return fmt::format("{}  ·  {} fps  ·  {} s  ·  {}", frames_in_words(move.part, move.frames),
                     move.frame_rate, milliseconds / 1000,
                     counted(static_cast<std::int64_t>(move.tracks.size()), "track"));
}

std::string names_of(const PlotMove& move, std::span<const std::size_t> axes) {
  std::vector<std::string_view> names;
  for (const std::size_t axis : axes) names.push_back(move.axes[axis].name);
  return fmt::format("{}", fmt::join(names, ", "));
}

void draw_page_title(Canvas& canvas, const PlotMove& move) {
  const TextStyle name{.size = 26, .color = plot_color::ink, .bold = true};
  canvas.text({page_margin, page_margin + 16}, elided(canvas, move.name, name, content_width), name);
  canvas.text({page_margin, page_margin + 40}, summary(move), {.size = 14, .color = plot_color::quiet});
}

void draw_section_title(Canvas& canvas, double base_line, const std::string& title, Color color) {
  const TextStyle style{.size = 17, .color = plot_color::ink, .bold = true};
  canvas.rectangle({page_margin, base_line - 14, 5, 18}, color);
  canvas.text({page_margin + 14, base_line}, elided(canvas, title, style, content_width - 14), style);
}

void draw_track(Canvas& canvas, const TrackLayout& layout, const PlotMove& move, std::size_t index) {
  const PlotTrack& track = move.tracks[index];
  const Color color = track_color(index);
  draw_section_title(canvas, layout.title, fmt::format("Track {}: {}", index + 1, names_of(move, track.axes)),
                     color);
  if (track.axes.size() == 1) {
    draw_ruler(canvas, layout.path, move, track, color);
  } else {
    draw_path_panel(canvas, layout.path, move, track, {0, 1}, color);
  }
  if (layout.third) draw_path_panel(canvas, *layout.third, move, track, {0, 2}, color);
  draw_speed_panel(canvas, layout.speed, move, track, color);
  draw_time_bar(canvas, layout.bar, move, track, color);
}

constexpr std::string_view tips_in_words =
    "in space, with the posture at each key (arrow: as it looks; cross: at what)";

void draw_tips_section(Canvas& canvas, const Box& area, const PlotMove& move) {
  draw_section_title(canvas, area.y - track_title_height + 18, fmt::format("Tips {}", tips_in_words),
                     plot_color::quiet);
  draw_tips(canvas, area, move);
}

void draw_tip_section(Canvas& canvas, const Box& area, const PlotMove& move, std::size_t index) {
  const PlotTip& tip = move.tips[index];
  const Color color = track_color(index);
  draw_section_title(canvas, area.y - track_title_height + 18, fmt::format("{} {}", tip.name, tips_in_words),
                     color);
  draw_tip(canvas, area, move, tip, color);
}

void require(bool holds, std::string_view what) {
  if (!holds) throw std::invalid_argument(fmt::format("draw_plot: {}", what));
}

void require_finite(std::span<const double> values, std::string_view what) {
  require(std::all_of(values.begin(), values.end(), [](double v) { return std::abs(v) <= greatest_value; }),
          fmt::format("{} must be finite and at most {:g}", what, greatest_value));
}

// One row per axis of the track, all of the same length.
void require_rows(const std::vector<std::vector<double>>& rows, std::size_t axes, std::size_t columns,
                  std::string_view what) {
  require(rows.size() == axes, fmt::format("{} needs a row for each axis of its track", what));
  for (const auto& row : rows) {
    require(row.size() == columns,
            fmt::format("a row of {} has {} numbers, not {}", what, row.size(), columns));
    require_finite(row, what);
  }
}

void require_consistent(const PlotTrack& track, const PlotMove& move) {
  const std::size_t positions = static_cast<std::size_t>(move.frames) + 1;
  require(!track.axes.empty(), "a track needs an axis");
  for (const std::size_t axis : track.axes)
    require(axis < move.axes.size(), "a track names an axis that is not there");
  require(!track.path.empty() && !track.path.front().empty(), "path needs a sample");
  require(!track.keys.empty() && !track.keys.front().empty(), "keys needs a key");
  require_rows(track.path, track.axes.size(), track.path.front().size(), "path");
  require_rows(track.tangents, track.axes.size(), positions, "tangents");
  require_rows(track.keys, track.axes.size(), track.keys.front().size(), "keys");
  const std::size_t keys = track.keys.front().size();
  if (!track.passed.empty()) require_rows(track.passed, track.axes.size(), keys, "passed");
  require(track.key_frames.size() == keys || track.key_frames.size() == keys + 1,
          "key_frames needs a frame for each key, and one more on a closed path");
  require(track.speed.size() == positions, "speed needs a value for each of the frames 0..N");
  require(track.control_values.empty() == track.curve.empty(), "control_values and curve come together");
  require(track.curve.size() != 1, "curve needs two samples");
  require(track.key_holds.empty() || track.key_holds.size() == track.key_frames.size(),
          "key_holds needs a number for each key, or none");
  for (const auto* values : {&track.key_frames, &track.key_holds, &track.control_values, &track.curve,
                             &track.speed, &track.speed_line}) {
    require_finite(*values, "key_frames, control_values, curve, speed and speed_line");
  }
}

void require_consistent(const PlotMove& move) {
  require(move.frames >= 1, "frames must be at least 1");
  require(move.part.first >= 0 && move.part.first < move.part.last && move.part.last <= move.frames,
          "part must be some of the frames 0..N");
  require(move.first_frame <= move.part.first && move.last_frame >= move.part.last,
          "first_frame and last_frame must enclose the frames that are played");
  require(std::isfinite(move.frames_per_second) && move.frames_per_second > 0,
          "frames_per_second must be positive");
  require(!move.axes.empty(), "a move needs an axis");
  for (const PlotAxis& axis : move.axes) {
    require(axis.positions.size() == static_cast<std::size_t>(move.last_frame - move.first_frame) + 1,
            "positions needs a value for each of the frames first_frame..last_frame");
    require_finite(axis.positions, "positions");
    require_finite(axis.line, "line");
    for (const auto& limit : {axis.minimum, axis.maximum}) {
      if (limit) require_finite(std::span(&*limit, 1), "a limit");
    }
  }
  for (const PlotTrack& track : move.tracks) require_consistent(track, move);
  for (const PlotTip& tip : move.tips) {
    require(tip.places.size() == static_cast<std::size_t>(move.part.last - move.part.first) + 1,
            "places needs one for each of the frames that are played");
    for (const PlotPlace& place : tip.places) require_finite(place, "places");
  }
}

}  // namespace

bool is_puppet(const PlotMove& move) {
  std::size_t axes = 0;
  for (const PlotTrack& track : move.tracks) axes += track.control_values.empty() ? track.axes.size() : 0;
  return axes > 3;
}

void draw_plot(const PlotMove& move, const std::filesystem::path& file, PictureStyle style) {
  require_consistent(move);
  const Layout layout = layout_of(move);
  Canvas canvas(file, page_width, layout.height, style);
  draw_page_title(canvas, move);
  for (std::size_t i = 0; i < move.tracks.size(); ++i) {
    if (layout.tracks[i]) draw_track(canvas, *layout.tracks[i], move, i);
  }
  if (is_puppet(move)) {
    if (!move.tips.empty()) draw_tips_section(canvas, layout.tips.front(), move);
  } else {
    for (std::size_t i = 0; i < move.tips.size(); ++i) draw_tip_section(canvas, layout.tips[i], move, i);
  }
  draw_positions(canvas, layout.positions, move);
  std::vector<std::string_view> names;
  for (const PlotAxis& axis : move.axes) names.push_back(axis.name);
  canvas.write(move.name, fmt::format("{}; axes: {}", summary(move), fmt::join(names, ", ")));
}

}  // namespace inbetween
