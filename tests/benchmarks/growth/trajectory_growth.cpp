// Draws a trajectory, and how its size and the time to make it grow:
//   trajectory_growth PICTURE_FOLDER [--quick]
// It writes PICTURE_FOLDER/trajectory.svg and growth-trajectory.svg, and a table in Markdown to standard
// output. scripts/update-performance runs it. With --quick the moves are small, which shows that it works.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/plan/fitted_trajectory.hpp"
#include "host_tools/plan/plan.hpp"
#include "host_tools/plan/solved_track.hpp"
#include "host_tools/plot/plot_canvas.hpp"
#include "host_tools/plot/plot_panel.hpp"
#include "host_tools/plot/plot_scale.hpp"
#include "inbetween/trajectory/bounds.hpp"
#include "tests/support/places.hpp"

namespace inbetween {
namespace {

// --- how it grows

struct Size {
  int keys = 8;
  int frames = 240;
  int axes = 3;
  double sharpness = 1;  ///< how far a corner is from being a cusp, as a share of the legs
};

struct Measured {
  double size = 0;
  double pieces = 0;
  double bytes = 0;
  double microseconds = 0;
};

struct Growth {
  std::string name;
  std::vector<Measured> points;
};

/// Through random keys at an even speed; the sharper the corner in the middle, the nearer its path comes to
/// turning back where it came from.
SolvedTrack solved_track(const Size& size) {
  std::mt19937 random(1989);
  std::uniform_real_distribution<double> coordinate(0.0, 100.0);
  std::vector<double> at;
  for (int k = 0; k < size.keys; ++k) {
    for (int d = 0; d < size.axes; ++d) at.push_back(coordinate(random));
  }
  if (size.sharpness < 1) {
    at.clear();
    const std::vector<double> along{0, 1, 2, 1, 0};
    for (std::size_t k = 0; k < along.size(); ++k) {
      for (int d = 0; d < size.axes; ++d)
        at.push_back(d == 0 ? 50 * along[k] : 50 * size.sharpness * static_cast<double>(k));
    }
  }
  const std::vector<double> speed{0, 0, 10, 12, 10, 0, 0};
  const TrackSpec spec{.path = {.axis_count = size.axes, .keys = at},
                       .control_values = speed,
                       .frames = size.frames,
                       .fps = {24, 1},
                       .arc_length = {}};
  return {spec, Solver::closed_form};
}

double microseconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count();
}

Measured measured(double size, const SolvedTrack& solved) {
  const FittedTrajectory fitted(solved.track());
  const SampledTrack sampled(solved.track());
  TrajectoryFitter fitter;
  double least = 1e300;
  for (int i = 0; i < 3; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    (void)fitter.fit(*sampled);
    least = std::min(least, microseconds_since(begin));
  }
  return {size, static_cast<double>(fitted->pieces().size()), static_cast<double>(fitted.bytes()), least};
}

std::vector<Growth> all_growths(bool is_quick) {
  const auto sizes = [&](std::vector<int> all) { return is_quick ? std::vector<int>{4, 8} : std::move(all); };
  std::vector<Growth> growths(4);
  growths[0].name = "keys";
  for (const int keys : sizes({8, 30, 100, 300, 1000}))
    growths[0].points.push_back(measured(keys, solved_track({.keys = keys, .frames = 30 * keys})));
  growths[1].name = "frames";
  for (const int frames : sizes({24, 240, 2400, 24000, 240000}))
    growths[1].points.push_back(measured(frames, solved_track({.frames = frames})));
  growths[2].name = "axes";
  for (const int axes : sizes({2, 4, 8, 16, 32, 64}))
    growths[2].points.push_back(measured(axes, solved_track({.axes = axes})));
  growths[3].name = "width of a corner";
  for (const double sharpness : {1e-1, 1e-3, 1e-5, 1e-7, 1e-9, 1e-12})
    growths[3].points.push_back(measured(sharpness, solved_track({.sharpness = sharpness})));
  return growths;
}

// --- pictures

std::string power_text(double decade) {
  return decade >= 0 && decade < 4 ? fmt::format("{:g}", std::pow(10, decade))
                                   : fmt::format("1e{:g}", decade);
}

void draw_decades(Canvas& canvas, const Box& area, const Scale& x, const Scale& y) {
  const Stroke grid{.color = plot_color::grid};
  const double step = std::max(1.0, std::ceil(x.range().size() / 6));
  for (double decade = std::ceil(x.range().low); decade <= x.range().high; decade += step) {
    canvas.line({x(decade), area.y}, {x(decade), area.bottom()}, grid);
    canvas.text({x(decade), area.bottom() + 16}, power_text(decade),
                {.color = plot_color::quiet, .align = Align::center});
  }
  for (double decade = std::ceil(y.range().low); decade <= y.range().high; ++decade) {
    canvas.line({area.x, y(decade)}, {area.right(), y(decade)}, grid);
    canvas.text({area.x - 6, y(decade) + 4}, power_text(decade),
                {.color = plot_color::quiet, .align = Align::right});
  }
}

struct Shown {
  const char* name;
  double Measured::*number;
};
constexpr std::array<Shown, 3> shown{{{"pieces", &Measured::pieces},
                                      {"bytes", &Measured::bytes},
                                      {"microseconds to make it", &Measured::microseconds}}};

void draw_growths(const std::filesystem::path& file, const std::vector<Growth>& growths) {
  constexpr double wide = 250, high = 250, left = 60, top = 70, apart = 65;
  Canvas canvas(file, left + 4 * wide + 3 * apart + 20, top + high + 70);
  draw_heading(canvas, {left, 28}, "size of a trajectory, and the time to make it",
               "8 keys, 240 frames, 3 axes but for what is below a panel; both logarithmic", 900);
  std::string description;
  for (std::size_t g = 0; g < growths.size(); ++g) {
    const Growth& growth = growths[g];
    const Box area{left + static_cast<double>(g) * (wide + apart), top, wide, high};
    std::vector<double> sizes;
    for (const Measured& point : growth.points) sizes.push_back(std::log10(point.size));
    const Scale x(widened(range_of(sizes), 0.04), area.x, area.right());
    const Scale y({0, 7.5}, area.bottom(), area.y);
    draw_decades(canvas, area, x, y);
    canvas.outline(area, {.color = plot_color::frame});
    canvas.text({area.x + area.width / 2, area.bottom() + 36}, growth.name,
                {.color = plot_color::ink, .align = Align::center});
    for (std::size_t i = 0; i < shown.size(); ++i) {
      std::vector<Point> line;
      for (const Measured& point : growth.points) {
        line.push_back({x(std::log10(point.size)), y(std::log10(std::max(point.*shown[i].number, 1.0)))});
        description +=
            fmt::format("{} {:g}: {:g} {}; ", growth.name, point.size, point.*shown[i].number, shown[i].name);
      }
      canvas.polyline(line, {.color = track_color(i), .width = 2});
      for (const Point& point : line) canvas.disc(point, 3, track_color(i));
      if (g > 0) continue;
      const double across = left + 190 * static_cast<double>(i);
      canvas.line({across, 50}, {across + 24, 50}, {.color = track_color(i), .width = 2});
      canvas.text({across + 32, 54}, shown[i].name, {.color = plot_color::ink});
    }
  }
  canvas.write("How a trajectory grows", description);
}

void print_table(const std::vector<Growth>& growths) {
  fmt::print("![Size of a trajectory and the time to make it](pictures/growth-trajectory.svg)\n\n");
  fmt::print("| of a trajectory | pieces | bytes | time to make it |\n|---|---:|---:|---:|\n");
  for (const Growth& growth : growths) {
    for (const Measured& point : {growth.points.front(), growth.points.back()}) {
      fmt::print("| {} {:g} | {:g} | {:.0f} KB | {:.2f} ms |\n", growth.name, point.size, point.pieces,
                 point.bytes / 1e3, point.microseconds / 1e3);
    }
  }
  fmt::print("\n");
}

FrameTime time_at(double frame) {
  const double whole = std::floor(frame);
  return {static_cast<std::int32_t>(whole), frame - whole};
}

/// How far what plays is from what is asked, as a share of the tolerance, at so many places.
struct Misses {
  std::vector<double> frames, positions, velocities;
};
Misses misses_of(const FittedTrajectory& fitted) {
  std::vector<AxisPeaks> peaks(fitted->axis_count());
  bound_trajectory(*fitted, peaks);
  std::vector<AxisMotion> asked(peaks.size()), played(peaks.size());
  Misses misses;
  const double end = fitted->end().frame;
  constexpr int places = 1200;
  for (int k = 0; k < places; ++k) {
    const double frame = (k + 0.5) * end / places;
    const SampledSpeed speed = fitted.sampler().sample(time_at(frame), asked);
    fitted->motion(time_at(frame), played);
    double position = 0;
    double velocity = 0;
    for (std::size_t d = 0; d < peaks.size(); ++d) {
      const double travel = peaks[d].highest.value - peaks[d].lowest.value;
      position = std::max(position, std::fabs(played[d].position - asked[d].position) / travel);
      const double counted = std::max(speed.speed / fitted.sampler().weight(d), 24e-6 * travel);
      velocity = std::max(velocity, std::fabs(played[d].velocity - asked[d].velocity) / counted);
    }
    misses.frames.push_back(frame);
    misses.positions.push_back(std::log10(std::max(position * (1 << 30), 1e-6)));
    misses.velocities.push_back(std::log10(std::max(velocity / 1e-6, 1e-6)));
  }
  return misses;
}

/// The axes of reveal over time with the joints of their pieces, and below how far they are from the track.
void draw_trajectory(const std::filesystem::path& file) {
  const Plan plan(read_move_file(in_checkout("examples/reveal.toml")), std::nullopt, {});
  const FittedTrajectory fitted(plan.tracks()[0].track());
  const Misses misses = misses_of(fitted);
  constexpr double wide = 760, left = 70;
  const Box above{left, 60, wide, 220};
  const Box below{left, 340, wide, 160};
  Canvas canvas(file, left + wide + 30, 560);
  const Scale x(widened({0, static_cast<double>(fitted->end().frame)}, 0.01), left, left + wide);
  draw_heading(
      canvas, {left, 28}, "reveal as a trajectory",
      fmt::format("{} pieces, each from one point to the next; every axis from its lowest to its highest",
                  fitted->pieces().size()),
      wide);
  std::vector<AxisPeaks> peaks(fitted->axis_count());
  bound_trajectory(*fitted, peaks);
  draw_bottom_ticks(canvas, above, x);
  std::vector<double> positions(peaks.size());
  for (std::size_t d = 0; d < peaks.size(); ++d) {
    const Scale y(widened({peaks[d].lowest.value, peaks[d].highest.value}, 0.06), above.bottom(), above.y);
    std::vector<Point> line;
    for (const double frame : misses.frames) {
      fitted->positions(time_at(frame), positions);
      line.push_back({x(frame), y(positions[d])});
    }
    canvas.polyline(line, {.color = track_color(d), .width = 2});
    for (const TrajectoryPiece& piece : fitted->pieces()) {
      canvas.disc({x(piece.begin.frame + piece.begin.fraction), y(fitted->values()[piece.begin_row + d])}, 3,
                  track_color(d));
    }
    const double across = above.x + 10 + 90 * static_cast<double>(d);
    canvas.text({across, above.y + 16}, plan.move().tracks[0].axes[d],
                {.color = track_color(d), .bold = true});
  }
  canvas.outline(above, {.color = plot_color::frame});
  draw_heading(canvas, {left, 325}, "how far it is from the track",
               "as a share of a 2^30th of the distance, and of a millionth of the speed; logarithmic", wide);
  const Scale y({-6, 1.5}, below.bottom(), below.y);
  draw_bottom_ticks(canvas, below, x);
  for (double decade = -6; decade <= 0; decade += 2) {
    canvas.line({below.x, y(decade)}, {below.right(), y(decade)}, {.color = plot_color::grid});
    canvas.text({below.x - 6, y(decade) + 4}, fmt::format("1e{:g}", decade),
                {.color = plot_color::quiet, .align = Align::right});
  }
  for (std::size_t i = 0; i < 2; ++i) {
    std::vector<Point> line;
    const std::vector<double>& numbers = i == 0 ? misses.positions : misses.velocities;
    for (std::size_t k = 0; k < numbers.size(); ++k) line.push_back({x(misses.frames[k]), y(numbers[k])});
    canvas.polyline(line, {.color = track_color(i), .width = 1});
    canvas.text({below.x + 10 + 90 * static_cast<double>(i), below.y + 16}, i == 0 ? "position" : "velocity",
                {.color = track_color(i), .bold = true});
  }
  canvas.outline(below, {.color = plot_color::frame});
  canvas.text({left + wide / 2, below.bottom() + 40}, "frame",
              {.color = plot_color::ink, .align = Align::center});
  canvas.write("reveal as a trajectory", "positions with the joints of the pieces, and their error");
}

}  // namespace
}  // namespace inbetween

int main(int argc, char** argv) {
  const bool is_quick = argc == 3 && std::string_view(argv[2]) == "--quick";
  if (argc != 2 && !is_quick) {
    fmt::print(stderr, "usage: trajectory_growth PICTURE_FOLDER [--quick]\n");
    return 2;
  }
  try {
    const std::filesystem::path folder = argv[1];
    inbetween::draw_trajectory(folder / "trajectory.svg");
    const auto growths = inbetween::all_growths(is_quick);
    inbetween::draw_growths(folder / "growth-trajectory.svg", growths);
    inbetween::print_table(growths);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
