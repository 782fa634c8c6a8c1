#include "host_tools/plan/space_track.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "host_tools/plan/axes_in_space.hpp"

namespace inbetween {

std::int32_t link_of(const MoveSpace& space, const Kinematics& kinematics) {
  const auto link = std::ranges::find(kinematics.links(), *space.aim_node);
  if (link != kinematics.links().end()) return static_cast<std::int32_t>(link - kinematics.links().begin());
  throw InputError(space.aim_place,
                   fmt::format("the rig has no link {} to look at; name one of its URDF file, "
                               "or give a point: aim = [x, y, z]",
                               in_quotes(*space.aim_node)));
}

namespace {

/// Whether other tracks move the link at which this one looks.
bool looks_at_what_moves(const MoveFile& move, std::size_t track, const Kinematics& kinematics,
                         std::span<const AxisInMove> axes) {
  const std::optional<MoveSpace>& space = move.tracks[track].space;
  if (!space || !space->aim_node) return false;
  const std::int32_t link = link_of(*space, kinematics);
  bool moves = false;
  for (std::size_t a = 0; a < kinematics.tree().coordinate_count(); ++a) {
    if (!kinematics.tree().moves(static_cast<std::int32_t>(a), link) || axes[a].held) continue;
    if (!axes[a].track) {
      throw InputError(
          space->aim_place,
          fmt::format("it is not known where {} stands; put the axes that move it in a track, of one "
                      "key where it stays, or give the keys of this track their own aim = [x, y, z]",
                      in_quotes(*space->aim_node)));
    }
    if (*axes[a].track == track) {
      throw InputError(space->aim_place,
                       fmt::format("{} moves with the axes of this track; look at a link that "
                                   "stays, or that another track moves",
                                   in_quotes(*space->aim_node)));
    }
    moves = true;
  }
  return moves;
}

/// The place of a link all of whose axes are held.
void settle_aim(MoveSpace& space, const Kinematics& kinematics, std::span<const AxisInMove> axes) {
  std::vector<double> coordinates(kinematics.tree().coordinate_count());
  for (std::size_t a = 0; a < coordinates.size(); ++a) coordinates[a] = axes[a].held.value_or(0);
  std::vector<Pose> poses(kinematics.links().size());
  static_cast<void>(kinematics.tree().poses(coordinates, poses));
  const Vector3& point = poses[static_cast<std::size_t>(link_of(space, kinematics))].position;
  space.fixed_aim = {point.x, point.y, point.z};
  space.aim_node.reset();
}

}  // namespace

void settle_aims(MoveFile& move, const Kinematics* kinematics, std::span<const AxisInMove> axes) {
  for (std::size_t t = 0; t < move.tracks.size(); ++t) {
    MoveTrack& track = move.tracks[t];
    if (!track.space && !track.distance) continue;
    if (kinematics == nullptr) {
      throw InputError(
          track.space ? track.space->place : track.distance->place,
          "this needs the geometry of the rig; plan with --rig RIG, whose file has [kinematics]");
    }
    if (!track.space || !track.space->aim_node) continue;
    if (!looks_at_what_moves(move, t, *kinematics, axes)) settle_aim(*track.space, *kinematics, axes);
  }
  for (const MoveTrack& track : move.tracks) {
    if (!track.space || !track.space->aim_node) continue;
    const std::int32_t link = link_of(*track.space, *kinematics);
    for (std::size_t a = 0; a < axes.size(); ++a) {
      if (!axes[a].track || !kinematics->tree().moves(static_cast<std::int32_t>(a), link)) continue;
      const std::optional<MoveSpace>& other = move.tracks[*axes[a].track].space;
      if (!other || !other->aim_node) continue;
      throw InputError(
          track.space->aim_place,
          fmt::format("{} is moved by a track that itself looks at a link that moves; look at one that "
                      "does not depend on another's look",
                      in_quotes(*track.space->aim_node)));
    }
  }
}

TrackedPath axes_looking_at(const MoveTrack& track, const Track& drawn, const Kinematics& kinematics,
                            const RigFile& rig, std::vector<DrivenCoordinate> driven) {
  LinkInTime aim(kinematics, link_of(*track.space, kinematics), std::move(driven));
  return tracked_path(track, drawn, &aim, kinematics, rig);
}

std::vector<double> space_row(const MoveSpace& space, const MoveKey& key) {
  std::vector<double> row = key.at;
  row.insert(row.end(), space.fixed_aim.begin(), space.fixed_aim.end());
  return row;
}

std::vector<double> space_weights(const MoveSpace& space) {
  const SpaceRows rows(space);
  std::vector<double> weights(rows.count);
  for (const std::size_t row : space.has_at ? rows.at : rows.aim) weights[row] = 1;
  return weights;
}

FollowedPath axes_in_space(const MoveTrack& track, const Track& drawn, const Kinematics& kinematics,
                           const RigFile& rig) {
  return AxesInSpace(track, drawn, kinematics, rig).follow();
}

FollowedPath tip_of_axes(const MoveTrack& track, const Path& drawn, const Kinematics& kinematics,
                         const RigFile& rig) {
  const MoveDistance& distance = *track.distance;
  const Tip& tip = tip_named(distance.tip, distance.place, kinematics);
  const std::vector<std::size_t> coordinates = coordinates_for(track, tip, distance.place, kinematics, rig);
  std::vector<double> values(kinematics.tree().coordinate_count());
  std::vector<Pose> poses(kinematics.links().size());
  std::vector<JacobianColumn> columns(values.size());
  const auto link = static_cast<std::size_t>(tip.link);
  const auto place_links = [&](const PathPoint& place) {
    for (std::size_t i = 0; i < coordinates.size(); ++i) {
      values[coordinates[i]] = drawn.segment(place.segment)[i].value(place.t);
    }
    static_cast<void>(kinematics.tree().poses(values, poses));
  };
  const Follower follower{.at =
                              [&](const PathPoint& place) {
                                place_links(place);
                                const Vector3& p = poses[link].position;
                                return Follower::Row{p.x, p.y, p.z};
                              },
                          .slope =
                              [&](const PathPoint& place) {
                                place_links(place);
                                kinematics.tree().jacobian(tip.link, poses, columns);
                                Vector3 v;
                                for (std::size_t i = 0; i < coordinates.size(); ++i) {
                                  v += columns[coordinates[i]].linear *
                                       drawn.segment(place.segment)[i].derivative(place.t);
                                }
                                return Follower::Row{v.x, v.y, v.z};
                              }};
  double length = min_length;
  std::optional<Vector3> before;
  for (std::int32_t i = 0; i < drawn.segment_count(); ++i) {
    for (int k = 0; k <= chords_between_keys; ++k) {
      place_links({i, static_cast<double>(k) / chords_between_keys});
      const Vector3 step = poses[link].position - before.value_or(poses[link].position);
      length += std::sqrt(dot(step, step));
      before = poses[link].position;
    }
  }
  const std::vector<std::size_t> axes = rows_from(0, coordinates.size());
  const std::vector<std::size_t> guides = rows_from(coordinates.size(), 3);
  const FollowLayout layout{.axes = axes, .guides = guides, .position = guides, .aim = {}};
  return followed_path(drawn, is_c2(track), follower, layout, kinematics, tip.link, coordinates,
                       {.off_m = off_share * length}, [&](const FollowObstacle& obstacle) {
                         const auto key = static_cast<std::size_t>(obstacle.where.segment);
                         throw InputError(
                             track.keys[key].place,
                             fmt::format("after key {}: {} comes to a standstill while the axes go on, and "
                                         "no distance says how fast; measure the axes there",
                                         key, in_quotes(tip.name)));
                       });
}

}  // namespace inbetween
