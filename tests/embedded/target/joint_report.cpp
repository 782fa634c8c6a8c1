#include "tests/embedded/target/joint_report.hpp"

#include <array>
#include <cstdint>

#include "inbetween/base/hash.hpp"
#include "inbetween/joints/angle_of.hpp"
#include "inbetween/joints/crane_positions.hpp"
#include "inbetween/joints/joint_tree.hpp"
#include "tests/embedded/target/report_line.hpp"

namespace inbetween::embedded {
namespace {

constexpr std::size_t axes = 6;
constexpr std::size_t links = 8;
constexpr std::int32_t tip = 7;
constexpr int states = 200;

/// Track in millimetres, swing, boom, pan, tilt and roll in degrees, and a head that the boom keeps level.
std::array<Joint, links> crane() {
  constexpr double mm = 1e-3;
  constexpr double degree = 0.017453292519943295;
  const auto turns = [&](std::int32_t parent, std::int32_t axis, Vector3 at, Vector3 about) {
    return Joint{.kind = JointKind::revolute,
                 .parent = parent,
                 .coordinate = axis,
                 .factor = degree,
                 .origin = {{}, at},
                 .axis = about};
  };
  std::array<Joint, links> joints = {
      Joint{.kind = JointKind::prismatic, .coordinate = 0, .factor = mm, .axis = {1, 0, 0}},
      turns(0, 1, {0, 0, 1.25}, {0, 0, 1}),
      turns(1, 2, {}, {0, -1, 0}),
      turns(2, 2, {2.5, 0, 0}, {0, -1, 0}),
      turns(3, 3, {0, 0, -0.25}, {0, 0, 1}),
      turns(4, 4, {}, {0, -1, 0}),
      turns(5, 5, {}, {1, 0, 0}),
      Joint{.parent = 6, .origin = {{}, {0.125, 0, 0}}}};
  joints[3].factor = -degree;
  return joints;
}

void add(Fnv1a& hash, const Vector3& v) {
  for (const double number : {v.x, v.y, v.z}) hash.add(number);
}

/// A place of a coordinate and its derivatives, a different one for every state and axis.
CoordinateMotion state_of(int state, std::size_t axis) {
  const auto turn = static_cast<double>((state * 37 + static_cast<int>(axis) * 101) % 720 - 360);
  return {turn, turn / 16, -turn / 64};
}

/// The same crane, solved for a place and a direction of its head.
void report_inverse() {
  const CameraCrane crane{.track = {1, 0, 0},
                          .column = {0, 0, 1},
                          .boom = {0, -1, 0},
                          .foot = {},
                          .level = {0, 0, 1},
                          .raised = {2.5, 0, 0}};
  const CameraHead head{.pan = {0, 0, 1}, .tilt = {0, -1, 0}, .roll = {1, 0, 0}};
  Fnv1a cranes;
  Fnv1a heads;
  for (int state = 0; state < states; ++state) {
    const double share = static_cast<double>(state) / states;
    const auto found = crane_positions(crane, {share * 4, share, share * 2}, {false, state % 2 == 1});
    const Rotation3 turn =
        turned_about({0, 0, 1}, sine_cosine(share * 5)) * turned_about({0, 1, 0}, sine_cosine(share));
    const auto angles = head_angles(head, turn, state % 3 == 0);
    passed = passed && found && angles;
    if (!passed) return;
    for (const double number : {found->track, found->swing, found->boom}) cranes.add(number);
    for (const double number : {angles->pan, angles->tilt, angles->roll}) heads.add(number);
  }
  print_hash("crane", cranes.value());
  print_hash("head", heads.value());
}

}  // namespace

void report_joints() {
  const auto joints = crane();
  std::array<Joint, links> memory{};
  const auto tree = JointTree::make(joints, axes, memory);
  std::array<CoordinateMotion, axes> coordinates{};
  std::array<double, axes> positions{};
  std::array<Pose, links> poses{};
  std::array<JacobianColumn, axes> jacobian{};
  std::array<LinkMotion, links> motion{};
  Fnv1a sines;
  Fnv1a tips;
  Fnv1a columns;
  Fnv1a motions;
  for (int state = 0; state < states; ++state) {
    for (std::size_t axis = 0; axis < axes; ++axis) {
      coordinates[axis] = state_of(state, axis);
      positions[axis] = coordinates[axis].position;
      const SineCosine found = sine_cosine(coordinates[axis].position);
      sines.add(found.sine);
      sines.add(found.cosine);
      sines.add(angle_of(found.cosine, found.sine));
    }
    passed = passed && tree && tree->poses(positions, poses) && tree->motion(coordinates, motion);
    if (!passed) return;
    tree->jacobian(tip, poses, jacobian);
    const LinkMotion& camera = motion[static_cast<std::size_t>(tip)];
    add(tips, camera.pose.position);
    add(tips, camera.pose.rotation.x);
    for (const JacobianColumn& column : jacobian) add(columns, column.linear);
    for (const auto& v : {camera.velocity, camera.acceleration, camera.angular_acceleration}) add(motions, v);
  }
  print("double joints");
  print_hash("sines", sines.value());
  print_hash("poses", tips.value());
  print_hash("jacobian", columns.value());
  print_hash("motion", motions.value());
  report_inverse();
  print("\n");
}

}  // namespace inbetween::embedded
