#include "host_tools/joints/tip_deviation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host_tools/joints/branch.hpp"
#include "host_tools/joints/vector_length.hpp"
#include "host_tools/numerics/hypotenuse.hpp"

namespace inbetween {
namespace {

/// Chebyshev's places on [0, 1].
constexpr std::array chebyshev_4 = {0.038060233744356624, 0.30865828381745514, 0.69134171618254492,
                                    0.96193976625564337};
/// The largest sum of the magnitudes of their Lagrange polynomials (Lebesgue constant).
constexpr double lebesgue_4 = 1.8479;
constexpr std::array chebyshev_3 = {0.066987298107780674, 0.5, 0.93301270189221931};
/// The same of these.
constexpr double lebesgue_3 = 1.667;
/// max |product of (t - t_i)| / n!, for e. TipDeviation.OneJointThatTurnsIsBoundedWithNothingToSpare.
constexpr double remainder_4 = 1.0 / 3072;
/// The same for e'.
constexpr double remainder_3 = 1.0 / 192;
/// No t is farther than this from a place of chebyshev_3: the largest distance is half of that between two of
/// them, 0.2165. TipDeviation.ItsBoundsHoldBetweenThePlacesWhereNothingIsOff.
constexpr double gap_3 = 0.22;

Jet product(const Jet& a, const Jet& b) {
  return {a[0] * b[0], a[0] * b[1] + a[1] * b[0], a[0] * b[2] + 2 * a[1] * b[1] + a[2] * b[0],
          a[0] * b[3] + 3 * a[1] * b[2] + 3 * a[2] * b[1] + a[3] * b[0],
          a[0] * b[4] + 4 * a[1] * b[3] + 6 * a[2] * b[2] + 4 * a[3] * b[1] + a[4] * b[0]};
}

Jet sum(const Jet& a, const Jet& b) {
  Jet result;
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = a[i] + b[i];
  return result;
}

/// By the control points of Bernstein's form.
Jet jet_of(const Cubic& c) {
  const auto largest = [](std::initializer_list<double> values) {
    double result = 0;
    for (const double value : values) result = std::max(result, std::fabs(value));
    return result;
  };
  return {largest({c.c0, c.c0 + c.c1 / 3, c.c0 + (2 * c.c1 + c.c2) / 3, c.value(1)}),
          largest({c.c1, c.c1 + c.c2, c.derivative(1)}), largest({2 * c.c2, c.second(1)}),
          std::fabs(c.third()), 0};
}

Jet jet_of(std::span<const Cubic> xyz) {
  Jet result{};
  for (const Cubic& c : xyz) {
    const Jet one = jet_of(c);
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = hypotenuse(result[i], one[i]);
  }
  return result;
}

Jet rotation_by(const Jet& angle) {
  const double a = angle[1];
  const double b = angle[2];
  const double c = angle[3];
  return {1, a, b + a * a, c + 3 * a * b + a * a * a, 4 * a * c + 3 * b * b + 6 * a * a * b + a * a * a * a};
}

struct LinkJets {
  Jet position{};                // of the link in the world
  Jet direction{1, 0, 0, 0, 0};  // of its x axis
};

Jet value_of(const Joint& joint, std::span<const Jet> coordinates) {
  Jet value{};
  if (joint.coordinate >= 0) value = coordinates[static_cast<std::size_t>(joint.coordinate)];
  for (double& bound : value) bound *= std::fabs(joint.factor);
  value[0] += std::fabs(joint.offset);
  return value;
}

LinkJets link_jets(const JointTree& tree, std::int32_t link, std::span<const Jet> coordinates) {
  LinkJets result;
  const Branch branch = branch_to(tree, link);
  for (const auto& [joint, arm] : branch.joints) {
    result.position[0] += arm;
    const Jet value = value_of(joint, coordinates);
    if (joint.kind == JointKind::revolute) {
      const Jet rotation = rotation_by(value);
      result.position = product(rotation, result.position);
      result.direction = product(rotation, result.direction);
    } else {
      result.position = sum(result.position, value);
    }
  }
  result.position[0] += branch.base;
  return result;
}

class Stretch {
 public:
  Stretch(const Kinematics& kinematics, std::int32_t link, const TipStretch& stretch)
      : tree_(kinematics.tree()),
        link_(link),
        stretch_(stretch),
        coordinates_(tree_.coordinate_count()),
        poses_(tree_.joints().size()),
        columns_(tree_.coordinate_count()) {}

  /// What is drawn, in one of its places.
  static Vector3 value(std::span<const Cubic> xyz, double t) {
    return {xyz[0].value(t), xyz[1].value(t), xyz[2].value(t)};
  }
  static Vector3 slope(std::span<const Cubic> xyz, double t) {
    return {xyz[0].derivative(t), xyz[1].derivative(t), xyz[2].derivative(t)};
  }

  const Pose& pose(double t) {
    for (std::size_t i = 0; i < stretch_.axes.size(); ++i) {
      coordinates_[stretch_.coordinates[i]] = stretch_.axes[i].value(t);
    }
    // Out of range only where no axis of a rig ever goes.
    static_cast<void>(tree_.poses(coordinates_, poses_));
    return poses_[static_cast<std::size_t>(link_)];
  }
  /// The derivative of the link's position, after pose(t).
  Vector3 pose_slope(double t) {
    tree_.jacobian(link_, poses_, columns_);
    Vector3 result;
    for (std::size_t i = 0; i < stretch_.axes.size(); ++i) {
      result += columns_[stretch_.coordinates[i]].linear * stretch_.axes[i].derivative(t);
    }
    return result;
  }

  [[nodiscard]] LinkJets jets() const {
    std::vector<Jet> coordinates(tree_.coordinate_count());
    for (std::size_t i = 0; i < stretch_.axes.size(); ++i) {
      coordinates[stretch_.coordinates[i]] = jet_of(stretch_.axes[i]);
    }
    return link_jets(tree_, link_, coordinates);
  }

 private:
  const JointTree& tree_;
  std::int32_t link_;
  const TipStretch& stretch_;
  std::vector<double> coordinates_;
  std::vector<Pose> poses_;
  std::vector<JacobianColumn> columns_;
};

}  // namespace

Jet position_jet(const Kinematics& kinematics, std::int32_t link, std::span<const Jet> coordinates) {
  return link_jets(kinematics.tree(), link, coordinates).position;
}

TipDeviation tip_deviation(const Kinematics& kinematics, std::int32_t link, const TipStretch& stretch) {
  Stretch along(kinematics, link, stretch);
  const LinkJets jets = along.jets();
  TipDeviation result;
  if (!stretch.position.empty()) {
    const Jet drawn = jet_of(stretch.position);
    for (const double t : chebyshev_4) {
      result.off = std::max(result.off, length(along.pose(t).position - Stretch::value(stretch.position, t)));
    }
    result.off = lebesgue_4 * result.off + remainder_4 * jets.position[4];
    result.slowest = std::numeric_limits<double>::infinity();
    for (const double t : chebyshev_3) {
      static_cast<void>(along.pose(t));
      const Vector3 slope = Stretch::slope(stretch.position, t);
      result.speed = std::max(result.speed, length(along.pose_slope(t) - slope));
      result.slowest = std::min(result.slowest, length(slope));
    }
    result.speed = lebesgue_3 * result.speed + remainder_3 * jets.position[4];
    result.slowest = std::max(result.slowest - gap_3 * drawn[2], 0.0);
    result.fastest = drawn[1];
  }
  if (stretch.aim.empty()) return result;
  // The sine of the angle is |(A - p) x lens| / |A - p|.
  const Jet sight = sum(jet_of(stretch.aim), jets.position);
  double nearest = std::numeric_limits<double>::infinity();
  for (const double t : chebyshev_4) {
    const Pose& pose = along.pose(t);
    const Vector3 to_aim = Stretch::value(stretch.aim, t) - pose.position;
    nearest = std::min(nearest, length(to_aim));
    result.aim = std::max(result.aim, length(cross(to_aim, pose.rotation.x)));
  }
  constexpr double gap_4 = 0.2;  // as gap_3, of chebyshev_4: 0.1913
  nearest -= gap_4 * sight[1];
  const double sine = lebesgue_4 * result.aim + remainder_4 * product(sight, jets.direction)[4];
  result.aim = nearest > sine ? std::asin(sine / nearest) : std::numeric_limits<double>::infinity();
  return result;
}

}  // namespace inbetween
