#include "host_tools/plot/plot_line.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace inbetween {
namespace {

// Directions from one point, as angles relative to the first direction put in.
class Wedge {
 public:
  // Whether `to` lies in the wedge and no nearer than the points before it; if so, the wedge is narrowed to
  // the directions that pass it within `tolerance`.
  bool narrow(Point from, Point to, double tolerance) {
    const double distance = std::hypot(to.x - from.x, to.y - from.y);
    if (!started_ && distance <= tolerance) return true;
    if (distance < farthest_) return false;
    farthest_ = distance;
    const double angle = std::atan2(to.y - from.y, to.x - from.x);
    if (!started_) zero_ = angle;
    started_ = true;
    const double relative = std::remainder(angle - zero_, 2 * std::numbers::pi);
    if (relative < low_ || relative > high_) return false;
    const double half = std::asin(tolerance / distance);
    low_ = std::max(low_, relative - half);
    high_ = std::min(high_, relative + half);
    return true;
  }

 private:
  bool started_ = false;
  double zero_ = 0;
  double low_ = -std::numbers::pi;
  double high_ = std::numbers::pi;
  double farthest_ = 0;
};

// First, least, greatest and last of values[begin..end), in order.
void add_extremes(std::span<const double> values, std::size_t begin, std::size_t end, const Scale& x,
                  const Scale& y, std::vector<Point>& points) {
  const auto [low, high] = std::minmax_element(values.begin() + static_cast<std::ptrdiff_t>(begin),
                                               values.begin() + static_cast<std::ptrdiff_t>(end));
  std::array<std::size_t, 4> kept{begin, static_cast<std::size_t>(low - values.begin()),
                                  static_cast<std::size_t>(high - values.begin()), end - 1};
  std::sort(kept.begin(), kept.end());
  const auto last = std::unique(kept.begin(), kept.end());
  for (auto i = kept.begin(); i != last; ++i) points.push_back({x(static_cast<double>(*i)), y(values[*i])});
}

}  // namespace

std::vector<Point> series_line(std::span<const double> values, const Scale& x, const Scale& y) {
  std::vector<Point> points;
  const auto column = [&](std::size_t i) { return std::floor(x(static_cast<double>(i))); };
  for (std::size_t begin = 0, end = 0; begin < values.size(); begin = end) {
    while (end < values.size() && column(end) == column(begin)) ++end;
    add_extremes(values, begin, end, x, y, points);
  }
  return simplified(points, 0.1);
}

std::vector<Point> simplified(std::span<const Point> points, double tolerance) {
  if (points.size() < 3) return {points.begin(), points.end()};
  std::vector<Point> kept{points.front()};
  Wedge wedge;
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (wedge.narrow(kept.back(), points[i], tolerance)) continue;
    kept.push_back(points[i - 1]);
    wedge = Wedge{};
    wedge.narrow(kept.back(), points[i], tolerance);
  }
  kept.push_back(points.back());
  return kept;
}

std::vector<Point> simplified_to(std::span<const Point> points, std::size_t max_points) {
  double tolerance = 0.1;
  std::vector<Point> kept = simplified(points, tolerance);
  while (kept.size() > max_points) kept = simplified(points, tolerance *= 2);
  return kept;
}

double length_of(std::span<const Point> points) {
  double length = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    length += std::hypot(points[i].x - points[i - 1].x, points[i].y - points[i - 1].y);
  }
  return length;
}

}  // namespace inbetween
