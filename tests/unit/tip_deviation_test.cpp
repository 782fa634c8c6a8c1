// The bounds between exact places, against what another library finds between them.
#include "host_tools/joints/tip_deviation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "tests/support/jointed_rig.hpp"
#include "tests/support/oracle_kinematics.hpp"

namespace inbetween {
namespace tip_deviation_test {

using Kind = OracleJointKind;
using Numbers = std::array<double, 3>;

/// Where a polynomial of third degree, or of second, meets a function so that it is near it everywhere.
std::vector<double> chebyshev_places(int count) {
  std::vector<double> places;
  for (int k = 0; k < count; ++k)
    places.push_back((1 - std::cos(std::numbers::pi * (2 * k + 1) / (2 * count))) / 2);
  return places;
}

/// The polynomial through values at places, by powers (Newton's divided differences).
std::vector<double> polynomial_through(const std::vector<double>& places, std::vector<double> values) {
  const std::size_t n = places.size();
  for (std::size_t k = 1; k < n; ++k) {
    for (std::size_t i = n - 1; i >= k; --i)
      values[i] = (values[i] - values[i - 1]) / (places[i] - places[i - k]);
  }
  std::vector<double> powers(n);
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t i = n - 1; i > 0; --i) powers[i] = powers[i - 1] - places[k] * powers[i];
    powers[0] = values[k] - places[k] * powers[0];
  }
  return powers;
}

struct MovedArm {
  std::vector<OracleJoint> joints;
  std::vector<Cubic> axes;
  [[nodiscard]] int last() const { return static_cast<int>(joints.size()) - 1; }
  [[nodiscard]] std::vector<double> positions(double t) const {
    std::vector<double> result;
    for (const Cubic& axis : axes) result.push_back(axis.value(t));
    return result;
  }
  [[nodiscard]] std::vector<double> velocities(double t) const {
    std::vector<double> result;
    for (const Cubic& axis : axes) result.push_back(axis.derivative(t));
    return result;
  }
};

MovedArm random_arm(std::mt19937_64& random, double first, double second, double third) {
  const auto within = [&](double reach) {
    return std::uniform_real_distribution<double>(-reach, reach)(random);
  };
  MovedArm arm;
  for (int i = 0; i < 3; ++i) {
    arm.joints.push_back({.kind = i == 1 ? Kind::prismatic : Kind::revolute,
                          .parent = i - 1,
                          .coordinate = i,
                          .xyz = {within(1), within(1), within(1)},
                          .axis = {within(1), within(1), 1}});
    arm.axes.push_back({within(2), within(first), within(second), within(third)});
  }
  arm.joints.push_back({.kind = Kind::fixed, .parent = 2, .xyz = {within(1), 1, within(1)}});
  return arm;
}

/// A cubic in each direction that meets a function at the places where the bounds are sampled.
std::vector<Cubic> drawn_through(const std::function<Numbers(double)>& function) {
  const std::vector<double> places = chebyshev_places(4);
  std::vector<Cubic> drawn;
  for (std::size_t d = 0; d < 3; ++d) {
    std::vector<double> values;
    for (const double t : places) values.push_back(function(t)[d]);
    const std::vector<double> c = polynomial_through(places, values);
    drawn.push_back({c[0], c[1], c[2], c[3]});
  }
  return drawn;
}

/// One whose slope meets that of the link at the places where the slopes are sampled.
std::vector<Cubic> drawn_with_slopes(const std::function<Numbers(double)>& slope) {
  const std::vector<double> places = chebyshev_places(3);
  std::vector<Cubic> drawn;
  for (std::size_t d = 0; d < 3; ++d) {
    std::vector<double> values;
    for (const double t : places) values.push_back(slope(t)[d]);
    const std::vector<double> c = polynomial_through(places, values);
    drawn.push_back({0, c[0], c[1] / 2, c[2] / 3});
  }
  return drawn;
}

Numbers difference(const Numbers& a, const Numbers& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
double size(const Numbers& v) {
  return std::hypot(v[0], v[1], v[2]);
}
Numbers at(const std::vector<Cubic>& drawn, double t) {
  return {drawn[0].value(t), drawn[1].value(t), drawn[2].value(t)};
}
Numbers slope_at(const std::vector<Cubic>& drawn, double t) {
  return {drawn[0].derivative(t), drawn[1].derivative(t), drawn[2].derivative(t)};
}

double worst(const std::function<double(double)>& of) {
  double most = 0;
  for (int k = 0; k <= 200; ++k) most = std::max(most, of(k / 200.0));
  return most;
}

const std::vector<std::size_t> all_three = {0, 1, 2};

/// What is drawn meets the link wherever the bounds look: they must know what is between.
void expect_bounds(const MovedArm& arm) {
  const Kinematics kinematics = kinematics_of(arm.joints);
  const OracleTree oracle(arm.joints);
  const auto pose = [&](double t) { return oracle.pose(arm.last(), arm.positions(t)); };
  const auto velocity = [&](double t) -> Numbers {
    const auto twist = oracle.motion(arm.last(), arm.positions(t), arm.velocities(t), {0, 0, 0}).velocity;
    return {twist[0], twist[1], twist[2]};
  };
  const auto deviation = [&](const std::vector<Cubic>& position, const std::vector<Cubic>& aim) {
    return tip_deviation(kinematics, arm.last() + 1, {arm.axes, all_three, position, aim});
  };
  constexpr double rounding = 1e-13;
  const auto path = drawn_through([&](double t) { return pose(t).position; });
  const double found_off = worst([&](double t) { return size(difference(pose(t).position, at(path, t))); });
  EXPECT_GT(found_off, 1e-9);
  EXPECT_LE(found_off, deviation(path, {}).off + rounding);
  EXPECT_LE(deviation(path, {}).off, 1000 * found_off) << "of use";

  const auto slopes = drawn_with_slopes(velocity);
  const TipDeviation of_slopes = deviation(slopes, {});
  EXPECT_LE(worst([&](double t) { return size(difference(velocity(t), slope_at(slopes, t))); }),
            of_slopes.speed + rounding);
  for (int k = 0; k <= 200; ++k) {
    EXPECT_LE(of_slopes.slowest, size(slope_at(slopes, k / 200.0)) + rounding);
  }
  EXPECT_GE(of_slopes.fastest + rounding, worst([&](double t) { return size(slope_at(slopes, t)); }));

  const auto sight = drawn_through([&](double t) -> Numbers {
    const OraclePose p = pose(t);
    return {p.position[0] + 3 * p.columns[0][0], p.position[1] + 3 * p.columns[0][1],
            p.position[2] + 3 * p.columns[0][2]};
  });
  const double found_aim = worst([&](double t) {
    const OraclePose p = pose(t);
    const Numbers to_aim = difference(at(sight, t), p.position);
    const Numbers& lens = p.columns[0];
    const double along = to_aim[0] * lens[0] + to_aim[1] * lens[1] + to_aim[2] * lens[2];
    const Numbers across = difference(to_aim, {lens[0] * along, lens[1] * along, lens[2] * along});
    return std::atan2(size(across), along);
  });
  EXPECT_LE(found_aim, deviation({}, sight).aim + rounding);
}

TEST(TipDeviation, APathBesideTheTipIsAtLeastAsFarOffAsItIsDrawn) {
  std::mt19937_64 random(1903);
  for (int i = 0; i < 20; ++i) {
    const MovedArm arm = random_arm(random, 0.3, 0.2, 0.1);
    const Kinematics kinematics = kinematics_of(arm.joints);
    const OracleTree oracle(arm.joints);
    const auto position = [&](double t) -> Numbers {
      return oracle.pose(arm.last(), arm.positions(t)).position;
    };
    const std::vector<Cubic> beside = drawn_through([&](double t) -> Numbers {
      const Numbers place = position(t);
      return {place[0] + 0.25, place[1], place[2]};
    });
    const TipDeviation bound = tip_deviation(kinematics, arm.last() + 1, {arm.axes, all_three, beside, {}});
    EXPECT_LE(worst([&](double t) { return size(difference(position(t), at(beside, t))); }), bound.off) << i;
  }
}

TEST(TipDeviation, ItsBoundsHoldBetweenThePlacesWhereNothingIsOff) {
  std::mt19937_64 random(11);
  for (int i = 0; i < 300; ++i) {
    // Each of the derivatives of an axis is the largest in some of them.
    expect_bounds(
        random_arm(random, i % 3 == 0 ? 0.5 : 0.01, i % 3 == 1 ? 0.3 : 0.01, i % 3 == 2 ? 0.2 : 0.01));
  }
}

/// Each joint of the arm hangs on two more that are fixed.
MovedArm with_fixed_joints(const MovedArm& arm, std::mt19937_64& random) {
  const auto within = [&](double reach) {
    return std::uniform_real_distribution<double>(-reach, reach)(random);
  };
  MovedArm result = {.joints = {}, .axes = arm.axes};
  for (const OracleJoint& joint : arm.joints) {
    for (int i = 0; i < 2; ++i) {
      result.joints.push_back({.kind = Kind::fixed,
                               .parent = result.last(),
                               .xyz = {within(1), within(1), within(1)},
                               .rpy = {within(3), within(3), within(3)}});
    }
    result.joints.push_back(joint);
    result.joints.back().parent = result.last() - 1;
  }
  return result;
}

TEST(TipDeviation, ItsBoundsHoldThroughFixedJointsToo) {
  std::mt19937_64 random(12);
  for (int i = 0; i < 100; ++i) {
    expect_bounds(with_fixed_joints(
        random_arm(random, i % 3 == 0 ? 0.5 : 0.01, i % 3 == 1 ? 0.3 : 0.01, i % 3 == 2 ? 0.2 : 0.01),
        random));
  }
}

// Exporters make a link of every screw and every frame.
TEST(TipDeviation, FixedJointsInARowCountAsOne) {
  std::vector<OracleJoint> joints = {{.kind = Kind::fixed, .parent = -1, .xyz = {0, 0, 1}},
                                     {.kind = Kind::revolute, .parent = 0, .coordinate = 0},
                                     {.kind = Kind::fixed, .parent = 1, .xyz = {1, 0, 0}}};
  const auto reach = [&] {
    const auto last = static_cast<std::int32_t>(joints.size());
    return position_jet(kinematics_of(joints), last, std::vector{Jet{0.3, 0.5}});
  };
  const Jet expected = reach();
  for (int i = 0; i < 1000; ++i) {  // there and back
    joints.push_back({.kind = Kind::fixed,
                      .parent = static_cast<int>(joints.size()) - 1,
                      .xyz = {i % 2 == 0 ? 0.25 : -0.25, 0, 0}});
  }
  const Jet found = reach();
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-9);
}

/// One joint that turns: nothing is lost by adding bounds, and each term of its derivatives is needed.
TEST(TipDeviation, OneJointThatTurnsIsBoundedWithNothingToSpare) {
  for (const Cubic& turn :
       {Cubic{0.3, 0.2, 0, 0}, Cubic{0.3, 0, 0.05, 0}, Cubic{0.3, 0.5, 0.02, 0}, Cubic{0.3, 0.05, 0, 0.2}}) {
    MovedArm arm;
    arm.joints = {{.kind = Kind::revolute, .parent = -1, .coordinate = 0},
                  {.kind = Kind::fixed, .parent = 0, .xyz = {1, 0, 0}}};
    arm.axes = {turn};
    const Kinematics kinematics = kinematics_of(arm.joints);
    const OracleTree oracle(arm.joints);
    const auto place = [&](double t) { return oracle.pose(1, arm.positions(t)).position; };
    const auto path = drawn_through(place);
    const double found = worst([&](double t) { return size(difference(place(t), at(path, t))); });
    const std::vector<std::size_t> only = {0};
    const double bound = tip_deviation(kinematics, 2, {arm.axes, only, path, {}}).off;
    EXPECT_LE(found, bound * (1 + 1e-6)) << turn.c1 << " " << turn.c2 << " " << turn.c3;
    EXPECT_LE(bound, 4 * found) << turn.c1 << " " << turn.c2 << " " << turn.c3;
  }
}

}  // namespace tip_deviation_test
}  // namespace inbetween
