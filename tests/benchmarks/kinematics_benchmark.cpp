#include <benchmark/benchmark.h>

#include <array>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "inbetween/joints/crane_positions.hpp"
#include "inbetween/joints/joint_tree.hpp"

/// A tick of an articulated rig: the pose, velocity and acceleration of every link, and the Jacobian of its
/// tip. And the reverse, for the rig that has a closed form.

namespace inbetween {
namespace {

/// A track, then joints that turn about z and y in turns, 0.5 m apart.
std::vector<Joint> crane(std::int32_t axes) {
  std::vector<Joint> joints = {
      {.kind = JointKind::prismatic, .coordinate = 0, .factor = 1e-3, .axis = {1, 0, 0}}};
  for (std::int32_t i = 1; i < axes; ++i) {
    const bool swings = i % 2 == 1;
    joints.push_back({.kind = JointKind::revolute,
                      .parent = i - 1,
                      .coordinate = i,
                      .factor = std::numbers::pi / 180,
                      .origin = {{}, {0.5, 0, 0}},
                      .axis = swings ? Vector3{0, 0, 1} : Vector3{0, 1, 0}});
  }
  return joints;
}

void kinematics_tick(benchmark::State& state) {
  const auto axes = static_cast<std::int32_t>(state.range(0));
  const std::vector<Joint> joints = crane(axes);
  std::vector<Joint> memory(joints.size());
  const auto tree = JointTree::make(joints, axes, memory);
  if (!tree) throw std::runtime_error(tree.error().what);
  std::vector<CoordinateMotion> coordinates(joints.size());
  std::vector<double> positions(joints.size());
  std::vector<LinkMotion> motion(joints.size());
  std::vector<Pose> poses(joints.size());
  std::vector<JacobianColumn> jacobian(joints.size());
  double angle = 0;
  for ([[maybe_unused]] auto _ : state) {
    angle = angle < 90 ? angle + 0.01 : 0;
    for (std::size_t i = 0; i < joints.size(); ++i) {
      coordinates[i] = {angle, 1, 1};
      positions[i] = angle;
    }
    if (!tree->motion(coordinates, motion) || !tree->poses(positions, poses)) {
      throw std::runtime_error("not placed");
    }
    tree->jacobian(axes - 1, poses, jacobian);
    benchmark::DoNotOptimize(motion.back());
    benchmark::DoNotOptimize(jacobian.front());
  }
}
BENCHMARK(kinematics_tick)->Arg(6);

/// The six positions of a camera crane from the place and the direction of its camera.
void crane_inverse(benchmark::State& state) {
  const CameraCrane crane{.track = {1, 0, 0},
                          .column = {0, 0, 1},
                          .boom = {0, -1, 0},
                          .foot = {0, 0, 0.4},
                          .level = {0.2, 0, 0.65},
                          .raised = {2.5, 0, 0}};
  const CameraHead head{.pan = {0, 0, 1}, .tilt = {0, -1, 0}, .roll = {1, 0, 0}};
  double angle = 0;
  for ([[maybe_unused]] auto _ : state) {
    angle = angle < 1 ? angle + 0.001 : 0;
    const auto positions = crane_positions(crane, {2 + angle, 1, 1 + angle}, {});
    const auto turn =
        turned_about({0, 0, 1}, sine_cosine(angle)) * turned_about({0, 1, 0}, sine_cosine(angle / 2));
    if (!positions) throw std::runtime_error(positions.error().what);
    const auto swung = turned_about(crane.column, sine_cosine(positions->swing));
    auto angles = head_angles(head, inverse(swung) * turn, false);
    if (!angles) throw std::runtime_error(angles.error().what);
    benchmark::DoNotOptimize(*positions);
    benchmark::DoNotOptimize(*angles);
  }
}
BENCHMARK(crane_inverse);

}  // namespace
}  // namespace inbetween

BENCHMARK_MAIN();
