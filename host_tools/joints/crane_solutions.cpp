#include "host_tools/joints/crane_solutions.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host_tools/joints/vector_length.hpp"
#include "host_tools/numerics/hypotenuse.hpp"

namespace inbetween {
namespace {

/// Axes are square to each other, or meet in a point, within this (rad, m). It is less than what a solution
/// may miss by (TipSolution::max_miss): TipSolver.WhatIsAlmostACraneHasNoClosedForm.
constexpr double crane_rounding = 1e-12;

/// A joint that moves, with every axis of the rig at 0.
struct MovingJoint {
  const Joint* joint = nullptr;
  Vector3 axis;   // in the world
  Vector3 place;  // a point of it
};

bool is_square(const Vector3& a, const Vector3& b) {
  return std::fabs(dot(a, b)) < crane_rounding;
}

Vector3 part_across(const Vector3& v, const Vector3& direction) {
  return v - direction * dot(v, direction);
}

bool is_on(const Vector3& point, const MovingJoint& joint) {
  return length(part_across(point - joint.place, joint.axis)) < crane_rounding;
}

/// From the root to the link.
std::vector<MovingJoint> moving_joints(const JointTree& tree, std::int32_t link,
                                       const std::vector<Pose>& at_zero) {
  std::vector<MovingJoint> found;
  for (std::int32_t i = link; i >= 0; i = tree.joints()[static_cast<std::size_t>(i)].parent) {
    const Joint& joint = tree.joints()[static_cast<std::size_t>(i)];
    const Pose& pose = at_zero[static_cast<std::size_t>(i)];
    if (joint.kind != JointKind::fixed) found.push_back({&joint, pose.rotation * joint.axis, pose.position});
  }
  std::ranges::reverse(found);
  return found;
}

/// The joints as what they are of a crane, if they can be.
struct CraneParts {
  std::optional<std::array<MovingJoint, 3>> crane;  // track, swing, boom
  std::optional<MovingJoint> level;
  std::vector<MovingJoint> head;  // pan, tilt, perhaps roll
};

std::optional<CraneParts> parts_of(std::vector<MovingJoint> joints) {
  CraneParts parts;
  if (joints.size() >= 5) {
    parts.crane = {joints[0], joints[1], joints[2]};
    std::size_t used = 3;
    if (joints[3].joint->coordinate == joints[2].joint->coordinate) parts.level = joints[used++];
    joints.erase(joints.begin(), joints.begin() + static_cast<std::ptrdiff_t>(used));
  }
  if (joints.size() != 2 && joints.size() != 3) return std::nullopt;
  parts.head = std::move(joints);
  return parts;
}

bool is_crane(const CraneParts& parts) {
  const auto& [track, swing, boom] = *parts.crane;
  const bool moves = track.joint->kind == JointKind::prismatic && swing.joint->kind == JointKind::revolute &&
                     boom.joint->kind == JointKind::revolute;
  if (!moves || !is_square(track.axis, swing.axis) || !is_square(swing.axis, boom.axis)) return false;
  if (!parts.level) return true;
  // It turns back what the boom has turned.
  const double back = dot(parts.level->axis, boom.axis) * parts.level->joint->factor;
  return parts.level->joint->kind == JointKind::revolute &&
         length(cross(parts.level->axis, boom.axis)) < crane_rounding &&
         std::fabs(back + boom.joint->factor) < crane_rounding * std::fabs(boom.joint->factor);
}

/// The point in which the axes of the head meet.
std::optional<Vector3> centre_of(const std::vector<MovingJoint>& head) {
  for (const MovingJoint& joint : head) {
    if (joint.joint->kind != JointKind::revolute) return std::nullopt;
  }
  if (!is_square(head[0].axis, head[1].axis)) return std::nullopt;
  const Vector3 centre = head[0].place + head[0].axis * dot(head[1].place - head[0].place, head[0].axis);
  if (!is_on(centre, head[1])) return std::nullopt;
  if (head.size() == 3 && (!is_on(centre, head[2]) || !is_square(head[1].axis, head[2].axis))) {
    return std::nullopt;
  }
  return centre;
}

}  // namespace

/// Where the centre of the head is to be, and how the camera is to be turned from where it is at 0.
struct CraneSolutions::Look {
  Vector3 centre;
  Vector3 sight;
  std::optional<Rotation3> turn;
};

std::optional<CraneSolutions> CraneSolutions::find(const Kinematics& kinematics, std::int32_t link,
                                                   const std::vector<TipAxis>& axes) {
  const JointTree& tree = kinematics.tree();
  std::vector<Pose> at_zero(tree.joints().size());
  if (!tree.poses(std::vector<double>(tree.coordinate_count()), at_zero)) return std::nullopt;
  const auto parts = parts_of(moving_joints(tree, link, at_zero));
  if (!parts || (parts->crane && !is_crane(*parts))) return std::nullopt;
  const auto centre = centre_of(parts->head);
  if (!centre) return std::nullopt;

  CraneSolutions found;
  std::vector<MovingJoint> joints = parts->head;
  if (parts->crane) joints.insert(joints.begin(), parts->crane->begin(), parts->crane->end());
  for (const MovingJoint& joint : joints) {
    const auto axis =
        std::ranges::find(axes, static_cast<std::size_t>(joint.joint->coordinate), &TipAxis::axis);
    if (axis == axes.end() || joint.joint->offset != 0) return std::nullopt;
    found.followers_.push_back({static_cast<std::size_t>(axis - axes.begin()), joint.joint->factor});
  }
  if (found.followers_.size() != axes.size()) return std::nullopt;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (std::ranges::count(found.followers_, i, &Follower::axis) != 1) return std::nullopt;
  }
  found.camera_ = at_zero[static_cast<std::size_t>(link)];
  found.centre_ = *centre;
  found.mount_ = inverse(found.camera_.rotation) * (found.camera_.position - *centre);
  found.has_roll_ = parts->head.size() == 3;
  const Vector3& lens = found.camera_.rotation.x;
  found.head_ = {parts->head[0].axis, parts->head[1].axis, found.has_roll_ ? parts->head[2].axis : lens};
  // Without a roll, or without a crane that brings the camera to its place, the lens looks from the centre.
  const bool looks_from_centre = hypotenuse(found.mount_.y, found.mount_.z) < crane_rounding;
  if ((!found.has_roll_ || !parts->crane) && !looks_from_centre) return std::nullopt;
  if (!found.has_roll_ && !is_square(lens, found.head_.tilt)) return std::nullopt;
  if (!parts->crane) return found;
  const auto& [track, swing, boom] = *parts->crane;
  const Vector3 end = parts->level ? parts->level->place : *centre;  // what turns with the boom
  found.crane_ = {
      track.axis,      swing.axis, boom.axis, swing.place, boom.place - swing.place + *centre - end,
      end - boom.place};
  found.is_level_ = parts->level.has_value();
  return found;
}

bool CraneSolutions::is_for(const TipTarget& target) const {
  return target.aim && target.position.has_value() == crane_.has_value() &&
         target.roll.has_value() == has_roll_;
}

std::optional<CraneSolutions::Look> CraneSolutions::look_of(const TipTarget& target) const {
  const Vector3 to_aim = *target.aim - target.position.value_or(centre_);
  if (length(to_aim) == 0) return std::nullopt;
  Look look{.centre = centre_, .sight = to_aim * (1 / length(to_aim)), .turn = {}};
  if (!has_roll_) {
    if (target.position) look.centre = *target.position - look.sight * mount_.x;
    return look;
  }
  const Vector3 level = cross(Vector3{0, 0, 1}, look.sight);
  if (length(level) == 0) return std::nullopt;  // straight up or down, where level means nothing
  const Vector3 y = level * (1 / length(level));
  const Vector3 z = cross(look.sight, y);
  const SineCosine roll = sine_cosine(*target.roll);
  const Rotation3 camera{look.sight, y * roll.cosine + z * roll.sine, z * roll.cosine - y * roll.sine};
  look.turn = camera * inverse(camera_.rotation);
  if (target.position) look.centre = *target.position - camera * mount_;
  return look;
}

void CraneSolutions::add_heads(const Look& look, const CranePositions& crane,
                               std::vector<std::vector<double>>& solutions) const {
  Rotation3 plate;  // on which the head stands
  if (crane_) {
    plate = turned_about(crane_->column, sine_cosine(crane.swing));
    if (!is_level_) plate = plate * turned_about(crane_->boom, sine_cosine(crane.boom));
  }
  const Rotation3 from_plate = inverse(plate);
  for (const bool over : {false, true}) {
    const auto head = look.turn ? head_angles(head_, from_plate * *look.turn, over)
                                : head_angles(head_, from_plate * look.sight, over);
    if (!head) return;
    std::vector<double> values;
    if (crane_) values = {crane.track, crane.swing, crane.boom};
    values.insert(values.end(), {head->pan, head->tilt, head->roll});
    std::vector<double>& positions = solutions.emplace_back(followers_.size());
    for (std::size_t i = 0; i < followers_.size(); ++i) {
      positions[followers_[i].axis] = values[i] / followers_[i].factor;
    }
  }
}

std::vector<std::vector<double>> CraneSolutions::of(const TipTarget& target) const {
  std::vector<std::vector<double>> solutions;
  if (!is_for(target)) return solutions;
  const auto look = look_of(target);
  if (!look) return solutions;
  if (!crane_) {
    add_heads(*look, {}, solutions);
    return solutions;
  }
  for (const bool leans_back : {false, true}) {
    for (const bool is_behind : {false, true}) {
      const auto crane = crane_positions(*crane_, look->centre, {leans_back, is_behind});
      if (crane) add_heads(*look, *crane, solutions);
    }
  }
  return solutions;
}

}  // namespace inbetween
