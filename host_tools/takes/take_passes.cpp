#include "host_tools/takes/take_passes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

#include "host_tools/takes/take_line.hpp"

namespace inbetween {
namespace {

/// Between points of a rig or a picture, whose squares are numbers: std::hypot, for any others, took a fifth
/// of the time of a report.
double distance_of(const Vector3& a, const Vector3& b) {
  const Vector3 away = a - b;
  return std::sqrt(dot(away, away));
}

/// Of points in any number of dimensions up to 3.
PathFigures figures_of(const Vector3& command, std::span<const Vector3> passes) {
  const auto count = static_cast<double>(passes.size());
  // Differences are small, and their mean loses no digits of them.
  Vector3 away;
  for (const Vector3& pass : passes) away += pass - command;
  away = away * (1 / count);
  const Vector3 centre = command + away;
  double sum = 0;
  for (const Vector3& pass : passes) sum += distance_of(pass, centre);
  const double mean = sum / count;
  double squares = 0;
  for (const Vector3& pass : passes) squares += std::pow(distance_of(pass, centre) - mean, 2);
  return {.accuracy = distance_of(away, {}), .repeatability = mean + 3 * std::sqrt(squares / (count - 1))};
}

/// The postures of a moment: as commanded, and in each pass.
class Postures {
 public:
  Postures(const RigMeasures& measures, std::size_t passes)
      : measures_(measures), links_(passes), points_(passes) {}

  void take(std::span<const double> commanded, const std::vector<std::vector<double>>& passes) {
    commanded_ = commanded;
    passes_ = &passes;
    measures_.poses(commanded, links_commanded_);
    for (std::size_t k = 0; k < passes.size(); ++k) measures_.poses(passes[k], links_[k]);
  }

  PathFigures of_axis(std::size_t axis) {
    for (std::size_t k = 0; k < points_.size(); ++k) points_[k] = {(*passes_)[k][axis], 0, 0};
    return figures_of({commanded_[axis], 0, 0}, points_);
  }

  PathFigures of_tip(std::size_t link) {
    for (std::size_t k = 0; k < points_.size(); ++k) points_[k] = links_[k][link].position * mm_per_m;
    return figures_of(links_commanded_[link].position * mm_per_m, points_);
  }

  PathFigures of_picture() {
    const LensView& lens = *measures_.lens();
    const std::size_t link = measures_.lens_link();
    PathFigures largest;
    for (const Vector3& mark : lens.marks(links_commanded_[link])) {
      constexpr double away = std::numeric_limits<double>::infinity();
      for (std::size_t k = 0; k < points_.size(); ++k) {
        const std::optional<ImagePoint> image = lens.image_of(links_[k][link], mark);
        if (!image) return {away, away};
        points_[k] = {image->x, image->y, 0};
      }
      const std::optional<ImagePoint> command = lens.image_of(links_commanded_[link], mark);
      const PathFigures figures = figures_of({command->x, command->y, 0}, points_);
      largest = {std::max(largest.accuracy, figures.accuracy),
                 std::max(largest.repeatability, figures.repeatability)};
    }
    return largest;
  }

 private:
  const RigMeasures& measures_;
  std::span<const double> commanded_ = {};
  const std::vector<std::vector<double>>* passes_ = nullptr;
  std::vector<Pose> links_commanded_;
  std::vector<std::vector<Pose>> links_;
  std::vector<Vector3> points_;
};

void add(PathReport::Of& of, const PathFigures& figures, const FrameTime& at) {
  if (of.frames.empty() || figures.accuracy > of.largest.accuracy) {
    of.largest.accuracy = figures.accuracy;
    of.accuracy_at = at;
  }
  if (of.frames.empty() || figures.repeatability > of.largest.repeatability) {
    of.largest.repeatability = figures.repeatability;
    of.repeatability_at = at;
  }
  auto frame = std::ranges::lower_bound(of.frames, at.frame, {}, &PathFrame::frame);
  if (frame == of.frames.end() || frame->frame != at.frame) frame = of.frames.insert(frame, {at.frame, {}});
  frame->figures = {std::max(frame->figures.accuracy, figures.accuracy),
                    std::max(frame->figures.repeatability, figures.repeatability)};
}

void refuse_passes(std::span<const TakeSamples> takes, const RigMeasures& measures) {
  if (takes.size() < 2)
    throw std::runtime_error("inbetween: error: repeatability is between takes; name two or more");
  for (const TakeSamples& take : takes) measures.refuse_other_axes(take);
}

std::vector<PathReport::Of> empty_figures(const RigMeasures& measures) {
  std::vector<PathReport::Of> empty;
  for (const Measure& measure : measures.all()) {
    if (measure.kind != Measure::Kind::angle) empty.push_back({.measure = measure});
  }
  return empty;
}

void add_posture(Postures& now, const RigMeasures& measures, const FrameTime& at,
                 std::vector<PathReport::Of>& all) {
  std::size_t axis = 0, tip = 0;
  for (PathReport::Of& of : all) {
    switch (of.measure.kind) {
      case Measure::Kind::axis:
        add(of, now.of_axis(axis++), at);
        break;
      case Measure::Kind::distance:
        add(of, now.of_tip(static_cast<std::size_t>(measures.kinematics()->tips()[tip++].link)), at);
        break;
      case Measure::Kind::picture:
        add(of, now.of_picture(), at);
        break;
      case Measure::Kind::angle:
        break;
    }
  }
}

/// `worst`: where the rig was commanded to be at accuracy_at of each.
void add_interpolation(const RigMeasures& measures, std::span<const double> missed,
                       const std::vector<std::vector<double>>& worst, std::vector<PathReport::Of>& all) {
  std::size_t at = 0;
  for (std::size_t m = 0; m < measures.all().size(); ++m) {
    if (measures.all()[m].kind == Measure::Kind::angle) continue;
    all[at].interpolation = measures.effect_of(missed, worst[at], m);
    ++at;
  }
}

}  // namespace

PathReport path_report(std::span<const TakeSamples> takes, const RigMeasures& measures) {
  refuse_passes(takes, measures);
  const TakeSamples& grid = takes.front();
  PathReport report{.measures = empty_figures(measures)};
  std::vector<TakeLine> lines;
  for (const TakeSamples& take : takes) {
    report.takes.push_back(take.number());
    lines.emplace_back(take);
  }
  const std::size_t axes = grid.axes().size();
  std::vector<std::vector<double>> passes(takes.size(), std::vector<double>(axes));
  std::vector<double> missed(axes);
  std::vector<std::size_t> near(takes.size());
  Postures now(measures, takes.size());
  std::vector<std::vector<double>> worst(report.measures.size());
  for (const std::size_t i : lines.front().samples()) {
    bool is_everywhere = true;
    for (std::size_t k = 0; k < takes.size(); ++k) {
      is_everywhere =
          is_everywhere && lines[k].actual_at({grid[i].turn, grid[i].time}, passes[k], missed, near[k]);
    }
    if (!is_everywhere) {
      ++report.left_out;
      continue;
    }
    ++report.places;
    now.take(grid.commanded(i), passes);
    add_posture(now, measures, grid[i].time, report.measures);
    for (std::size_t m = 0; m < report.measures.size(); ++m) {
      if (report.measures[m].accuracy_at == grid[i].time)
        worst[m].assign(grid.commanded(i).begin(), grid.commanded(i).end());
    }
  }
  if (report.places == 0) {
    throw std::runtime_error("inbetween: error: the takes have no frame in common; name takes of one move");
  }
  add_interpolation(measures, missed, worst, report.measures);
  return report;
}

}  // namespace inbetween
