
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "host_tools/plan/axes_in_space.hpp"
#include "host_tools/plan/network_track.hpp"

namespace inbetween {
namespace {

/// One point of the row, as if it had a track of its own.
struct RowPoint {
  MoveTrack track;                // of the axes that move it
  std::vector<std::size_t> axes;  // of the row's track
};

RowPoint point_on(const MoveTrack& row, const Tip& tip, const Kinematics& kinematics, const RigFile& rig) {
  RowPoint point{.track = row, .axes = {}};
  point.track.axes.clear();
  point.track.axis_places.clear();
  MoveSpace& space = *point.track.space;
  space.tips = {tip.name};
  space.near.clear();
  for (std::size_t d = 0; d < row.axes.size(); ++d) {
    const auto axis = std::ranges::find(rig.axes, row.axes[d], &RigAxis::name) - rig.axes.begin();
    if (!kinematics.tree().moves(static_cast<std::int32_t>(axis), tip.link)) continue;
    point.axes.push_back(d);
    point.track.axes.push_back(row.axes[d]);
    point.track.axis_places.push_back(row.axis_places[d]);
    if (!row.space->near.empty()) space.near.push_back(row.space->near[d]);
  }
  return point;
}

/// An axis that moves two points cannot follow both, and one that moves none follows nothing.
void refuse_shared_and_idle_axes(const MoveTrack& row, const std::vector<RowPoint>& points) {
  for (std::size_t d = 0; d < row.axes.size(); ++d) {
    std::vector<std::string> moved;
    for (const RowPoint& point : points) {
      if (std::ranges::find(point.axes, d) != point.axes.end())
        moved.push_back(in_quotes(point.track.space->tips.front()));
    }
    if (moved.size() == 1) continue;
    const std::string axis = in_quotes(row.axes[d]);
    throw InputError(
        row.axis_places[d],
        moved.empty()
            ? fmt::format("axis {} moves no point of the row; give it a track of its own", axis)
            : fmt::format("axis {} moves {}, and each point of a row has axes of its own; leave all "
                          "but one of them out of the row",
                          axis, fmt::join(moved, " and ")));
  }
}

std::vector<RowPoint> points_of(const MoveTrack& row, const Kinematics& kinematics, const RigFile& rig) {
  const MoveSpace& space = *row.space;
  std::vector<RowPoint> points;
  for (const std::string& tip : space.tips)
    points.push_back(point_on(row, tip_named(tip, space.place, kinematics), kinematics, rig));
  refuse_shared_and_idle_axes(row, points);
  const auto has_two_axes = [](const RowPoint& point) { return point.axes.size() == 2; };
  if (space.elbow_up && std::ranges::none_of(points, has_two_axes)) {
    throw InputError(space.elbow_place,
                     "elbow is for arms of two joints, and no point of the row has two axes; remove it");
  }
  return points;
}

/// x, y and z of one point over time, as the network has them.
SolvedTrack drawn_point(const CubicsOverFrames& network, std::size_t point, const TrackSpec& spec) {
  const std::size_t row = network.cubics.size() / network.knots.size();
  std::vector<Cubic> cubics;
  for (std::size_t i = world_coordinates * point; i < network.cubics.size(); i += row) {
    const std::span<const Cubic> place = std::span(network.cubics).subspan(i, world_coordinates);
    cubics.insert(cubics.end(), place.begin(), place.end());
  }
  constexpr std::array<double, world_coordinates> weights{1, 1, 1};
  TrackSpec own = spec;
  own.cubics = CubicPathSpec{.spline = Spline::smooth,
                             .closed = false,
                             .axis_count = static_cast<std::int32_t>(world_coordinates),
                             .key_count = static_cast<std::int32_t>(spec.key_frames.size()),
                             .cubics = cubics,
                             .weights = weights,
                             .knots = network.knots,
                             .over_frames = true};
  return {own, Solver::closed_form};
}

/// One path of the axes of all points, which have the same steps.
TrackedPath together(const std::vector<TrackedPath>& found, const std::vector<RowPoint>& points,
                     std::size_t axes) {
  TrackedPath all = found.front();
  const std::size_t steps = all.path.knots.size();
  all.path.weights.assign(axes, 1);
  all.path.cubics.assign(axes * steps, {});
  for (std::size_t p = 0; p < points.size(); ++p) {
    const std::vector<std::size_t>& own = points[p].axes;
    const FollowedPath& path = found[p].path;
    for (std::size_t i = 0; i < path.cubics.size(); ++i)
      all.path.cubics[i / own.size() * axes + own[i % own.size()]] = path.cubics[i];
    FollowAccuracy& worst = all.path.accuracy;
    worst.off_m = std::max(worst.off_m, path.accuracy.off_m);
    worst.speed_share = std::max(worst.speed_share, path.accuracy.speed_share);
  }
  return all;
}

}  // namespace

TrackedPath axes_of_points(const MoveTrack& track, const TrackSpec& spec, const Kinematics& kinematics,
                           const RigFile& rig) {
  const std::vector<RowPoint> points = points_of(track, kinematics, rig);
  const CubicsOverFrames network = network_of(track, spec);
  std::vector<SolvedTrack> drawn;
  for (std::size_t p = 0; p < points.size(); ++p) drawn.push_back(drawn_point(network, p, spec));
  std::vector<TrackedPath> found(points.size());
  // All are parts of one path, so they have the steps of the one that needs most.
  for (std::int32_t steps = min_steps_per_frame, before = 0; steps != before;) {
    before = steps;
    for (std::size_t p = 0; p < points.size(); ++p) {
      if (found[p].steps_per_frame != steps)
        found[p] = tracked_path(points[p].track, drawn[p].track(), nullptr, kinematics, rig, steps);
      steps = std::max(steps, found[p].steps_per_frame);
    }
  }
  return together(found, points, track.axes.size());
}

}  // namespace inbetween
