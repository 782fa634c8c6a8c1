// Measures how the time of a command grows with the size of a move, draws it, and tells the exponents:
//   growth PICTURE_FOLDER [--quick]
// It writes PICTURE_FOLDER/growth-QUANTITY.svg, and tables in Markdown to standard output.
// scripts/update-performance runs it. With --quick the moves are small, which shows that it works and
// measures nothing.
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/plot/plot_canvas.hpp"
#include "host_tools/plot/plot_panel.hpp"
#include "host_tools/plot/plot_scale.hpp"
#include "tests/support/places.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace {

/// A move of this size, and its rig. What is not measured is small.
struct Size {
  int keys = 8;
  int frames = 2400;
  int axes = 3;
  int values = 12;
  int locks = 0;
};

/// A curve ends after a point that took so long, so that all of them take a few minutes.
constexpr double max_seconds = 4;
/// A time below this is measured again, and the least of a few is taken.
constexpr double seconds_repeated = 0.4;
constexpr int repetitions = 3;
/// The exponent is that of the points above this: below it the start of the program is much of the time.
constexpr double min_seconds_fitted = 0.02;
/// The limits that a fit has to keep, as a share of the peaks of the move.
constexpr double tight = 0.9;

struct Quantity {
  const char* name;
  int Size::*size;
  std::vector<int> sizes;
};

struct GrowingCommand {
  const char* name;
  std::vector<std::string> words;  ///< MOVE, RIG and OUT stand for files
  bool is_tight = false;           ///< the rig is too slow for the move
};

struct Measured {
  double size = 0, seconds = 0;
};

struct Curve {
  std::string name;
  std::vector<Measured> points;
  std::optional<double> exponent;
};

std::string move_text(const Size& size) {
  std::vector<std::string> names;
  for (int d = 0; d < size.axes; ++d) names.push_back(fmt::format("'a{}'", d));
  std::string text = fmt::format("name = 'growth'\nfps = 24\nframes = {}\n[[track]]\naxes = [{}]\nkeys = [\n",
                                 size.frames, fmt::join(names, ", "));
  const int last = size.keys - 1;
  for (int k = 0; k <= last; ++k) {
    std::vector<double> at;
    for (int d = 0; d < size.axes; ++d) at.push_back(10 * k + 2 * std::sin(1.7 * k + d));
    text += fmt::format("{{ at = [{:.4f}]", fmt::join(at, ", "));
    // Spread evenly, each a little off the frame on which it would be met.
    const bool is_locked = k > 0 && k < last && k * size.locks / last != (k - 1) * size.locks / last;
    if (is_locked) {
      const double evenly = static_cast<double>(size.frames) * k / last;
      text += fmt::format(", frame = {}", std::lround(evenly) + k % 3 - 1);
    }
    text += " },\n";
  }
  text += "]\nspeed = [0, 0";
  for (int i = 0; i < size.values; ++i) text += fmt::format(", {:.3f}", 30 + 3 * std::sin(0.9 * i));
  return text + ", 0, 0]\n";
}

std::string rig_of(const Size& size, double max_velocity, double max_acceleration) {
  std::vector<AxisText> axes;
  for (int d = 0; d < size.axes; ++d) {
    axes.push_back({.name = fmt::format("a{}", d),
                    .min = -1e6,
                    .max = 1e6,
                    .max_velocity = max_velocity,
                    .max_acceleration = max_acceleration});
  }
  return rig_text(axes);
}

/// A rig on which the move fits easily, or one that is a little too slow for it.
std::string rig_for(const Size& size, bool is_tight) {
  const std::string wide = rig_of(size, 1e6, 1e9);
  if (!is_tight) return wide;
  const CheckReport report = check(Plan(parse_move(move_text(size), "move"), parse_rig(wide, "rig"), {}));
  double velocity = 0;
  double acceleration = 0;
  for (const CheckedAxis& axis : report.axes) {
    velocity = std::max(velocity, axis.velocity.value);
    acceleration = std::max(acceleration, axis.acceleration.value);
  }
  return rig_of(size, tight * velocity, acceleration);
}

/// Processor seconds that a program takes, of the system and its own.
double seconds_of(const std::vector<std::string>& words) {
  std::fflush(stdout);  // or the child would write what is in the buffer once more
  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error("growth: cannot start a program");
  if (child == 0) {
    std::vector<char*> arguments;
    for (const std::string& word : words)
      arguments.push_back(const_cast<char*>(word.c_str()));  // NOLINT: execv
    arguments.push_back(nullptr);
    if (std::freopen("/dev/null", "w", stdout) != nullptr &&
        std::freopen("/dev/null", "w", stderr) != nullptr) {
      ::execv(arguments[0], arguments.data());
    }
    ::_exit(127);
  }
  int status = 0;
  rusage usage{};
  ::wait4(child, &status, 0, &usage);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw std::runtime_error(fmt::format("growth: error: {} ended with status {}", fmt::join(words, " "),
                                         WIFEXITED(status) ? WEXITSTATUS(status) : -1));
  }
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double measure(const GrowingCommand& command, const Size& size) {
  const TemporaryFile move("growth.toml", move_text(size));
  const TemporaryFile rig("rig.toml", rig_for(size, command.is_tight));
  std::vector<std::string> words{in_build("inbetween")};
  for (std::string word : command.words) {
    if (word == "MOVE") word = move.path().string();
    if (word == "RIG") word = rig.path().string();
    if (word == "OUT") word = move.path().string() + ".fitted";
    words.push_back(word);
  }
  double least = seconds_of(words);
  for (int i = 1; i < repetitions && least < seconds_repeated; ++i)
    least = std::min(least, seconds_of(words));
  return least;
}

/// The slope of log seconds over log size, by least squares (Gauss).
std::optional<double> exponent_of(const std::vector<Measured>& points) {
  double count = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const Measured& point : points) {
    if (point.seconds < min_seconds_fitted) continue;
    const double log_size = std::log(point.size);
    const double log_seconds = std::log(point.seconds);
    count += 1;
    x += log_size;
    y += log_seconds;
    xx += log_size * log_size;
    xy += log_size * log_seconds;
  }
  if (count < 2) return std::nullopt;
  return (count * xy - x * y) / (count * xx - x * x);
}

/// Moves grow in what is measured; what has to go with it, goes with it.
Size size_with(const Quantity& quantity, int number) {
  Size size;
  size.*quantity.size = number;
  if (quantity.size == &Size::keys) size.frames = std::max(size.frames, 10 * size.keys);
  if (quantity.size == &Size::locks) {
    size.keys = 2 * size.locks + 2;
    size.frames = std::max(size.frames, 20 * size.keys);
  }
  if (quantity.size == &Size::values) size.frames = std::max(size.frames, 10 * size.values);
  return size;
}

std::vector<Curve> measure_all(const Quantity& quantity, const std::vector<GrowingCommand>& commands) {
  std::vector<Curve> curves;
  for (const GrowingCommand& command : commands) {
    Curve& curve = curves.emplace_back(Curve{.name = command.name, .points = {}, .exponent = {}});
    for (const int number : quantity.sizes) {
      curve.points.push_back({static_cast<double>(number), measure(command, size_with(quantity, number))});
      fmt::print(stderr, "{} of {} {}: {:.3f} s\n", command.name, number, quantity.name,
                 curve.points.back().seconds);
      if (curve.points.back().seconds > max_seconds) break;
    }
    curve.exponent = exponent_of(curve.points);
  }
  return curves;
}

// --- picture

constexpr double page_wide = 760;
constexpr double page_high = 420;
constexpr Box area{70, 50, 470, 310};

std::string number_text(double number) {
  if (number >= 1e6) return fmt::format("{:g} 000 000", number / 1e6);
  if (number >= 1e4) return fmt::format("{:g} 000", number / 1e3);
  return fmt::format("{:g}", number);
}

/// Lines at the sizes that were measured, and at 1, 10, 100 parts of a second.
void draw_grid(Canvas& canvas, const Quantity& quantity, const Scale& x, const Scale& y) {
  const Stroke grid{.color = plot_color::grid};
  for (const int size : quantity.sizes) {
    const double across = x(std::log10(size));
    canvas.line({across, area.y}, {across, area.bottom()}, grid);
    canvas.text({across, area.bottom() + 16}, number_text(size),
                {.color = plot_color::quiet, .align = Align::center});
  }
  for (double decade = std::ceil(y.range().low); decade <= y.range().high; ++decade) {
    canvas.line({area.x, y(decade)}, {area.right(), y(decade)}, grid);
    canvas.text({area.x - 6, y(decade) + 4}, fmt::format("{:g} s", std::pow(10, decade)),
                {.color = plot_color::quiet, .align = Align::right});
  }
}

void draw(const std::filesystem::path& file, const Quantity& quantity, const std::vector<Curve>& curves) {
  Canvas canvas(file, page_wide, page_high);
  std::vector<double> sizes, times;
  for (const Curve& curve : curves) {
    for (const Measured& point : curve.points) {
      sizes.push_back(std::log10(point.size));
      times.push_back(std::log10(std::max(point.seconds, 1e-4)));
    }
  }
  const Scale x(widened(range_of(sizes), 0.03), area.x, area.right());
  const Scale y(widened(range_of(times), 0.05), area.bottom(), area.y);
  draw_heading(canvas, {area.x, 28}, fmt::format("processor time over {}", quantity.name),
               "both logarithmic; behind a command the exponent of its line", page_wide - area.x);
  draw_grid(canvas, quantity, x, y);
  canvas.outline(area, {.color = plot_color::frame});
  for (std::size_t i = 0; i < curves.size(); ++i) {
    std::vector<Point> line;
    for (const Measured& point : curves[i].points) {
      line.push_back({x(std::log10(point.size)), y(std::log10(std::max(point.seconds, 1e-4)))});
    }
    const Color color = track_color(i);
    canvas.polyline(line, {.color = color, .width = 2});
    for (const Point& point : line) canvas.disc(point, 3, color);
    const double row = area.y + 14 + 24 * static_cast<double>(i);
    canvas.line({area.right() + 14, row - 4}, {area.right() + 38, row - 4}, {.color = color, .width = 2});
    const auto exponent = curves[i].exponent;
    canvas.text({area.right() + 46, row},
                curves[i].name + (exponent ? fmt::format(": {:.2f}", *exponent) : ""),
                {.color = plot_color::ink});
  }
  std::string description;
  for (const Curve& curve : curves) {
    for (const Measured& point : curve.points) {
      description += fmt::format("{} {}: {:.3f} s; ", curve.name, point.size, point.seconds);
    }
  }
  canvas.write(fmt::format("How the time grows with {}", quantity.name), description);
}

void print_table(const Quantity& quantity, const std::vector<Curve>& curves) {
  fmt::print("![Processor time of each command over {}](pictures/growth-{}.svg)\n\n", quantity.name,
             quantity.name);
  fmt::print("| {} | time of the largest | exponent |\n|---|---:|---:|\n", quantity.name);
  for (const Curve& curve : curves) {
    fmt::print(
        "| `{}`, {} to {} | {:.2f} s | {} |\n", curve.name, number_text(curve.points.front().size),
        number_text(curve.points.back().size), curve.points.back().seconds,
        curve.exponent ? fmt::format("{:.2f}", *curve.exponent) : "no more than the start of the program");
  }
  fmt::print("\n");
}

void measure_growth(const std::filesystem::path& folder, bool is_quick) {
  const std::vector<GrowingCommand> commands{
      {"plan", {"plan", "MOVE", "--rig", "RIG"}},
      {"check", {"check", "MOVE", "--rig", "RIG"}},
      {"check --fit", {"check", "MOVE", "--rig", "RIG", "--fit", "OUT", "--seconds", "1000"}, true},
      {"run --sim --fast", {"run", "MOVE", "--rig", "RIG", "--sim", "--fast"}}};
  std::vector<Quantity> quantities{{"keys", &Size::keys, {300, 1000, 3000, 10000}},
                                   {"frames", &Size::frames, {1000, 10000, 100000, 1000000}},
                                   {"axes", &Size::axes, {4, 8, 16, 32, 64}},
                                   {"values", &Size::values, {100, 300, 1000, 2044}},
                                   {"locks", &Size::locks, {30, 100, 300, 500}}};
  for (Quantity& quantity : quantities) {
    if (is_quick) quantity.sizes = {4, 8};
    if (is_quick && quantity.size == &Size::frames) quantity.sizes = {240, 480};
    const std::vector<Curve> curves = measure_all(quantity, commands);
    draw(folder / fmt::format("growth-{}.svg", quantity.name), quantity, curves);
    print_table(quantity, curves);
  }
}

}  // namespace
}  // namespace inbetween

int main(int argc, char** argv) {
  const bool is_quick = argc == 3 && std::string_view(argv[2]) == "--quick";
  if (argc != 2 && !is_quick) {
    fmt::print(stderr, "usage: growth PICTURE_FOLDER [--quick]\n");
    return 2;
  }
  try {
    inbetween::measure_growth(argv[1], is_quick);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
