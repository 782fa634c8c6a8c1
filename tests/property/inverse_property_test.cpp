// Inverse kinematics of random rigs, measured with another library's forward kinematics (Orocos KDL).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "host_tools/joints/crane_solutions.hpp"
#include "host_tools/joints/tip_solver.hpp"
#include "tests/support/jointed_rig.hpp"
#include "tests/support/oracle_kinematics.hpp"
#include "tests/support/property.hpp"

namespace inbetween {
namespace inverse_property_test {

using Kind = OracleJointKind;
using Numbers = std::array<double, 3>;
constexpr double pi = std::numbers::pi;

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  bool toss() { return between(0, 1) < 0.5; }
  Numbers numbers(double reach) {
    return {between(-reach, reach), between(-reach, reach), between(-reach, reach)};
  }
  std::vector<double> angles(std::size_t count, double reach) {
    std::vector<double> result(count);
    for (double& angle : result) angle = between(-reach, reach);
    return result;
  }

 private:
  std::mt19937_64 engine_;
};

/// Links behind one another, each with a coordinate of its own unless it is fixed.
class Chain {
 public:
  OracleJoint& add(Kind kind, const Numbers& xyz, const Numbers& axis) {
    joints_.push_back({.kind = kind,
                       .parent = last_++,
                       .coordinate = kind == Kind::fixed ? -1 : coordinates_++,
                       .xyz = xyz,
                       .axis = axis});
    return joints_.back();
  }
  /// Follows coordinate `of`.
  void add_mimic(int of, double factor, const Numbers& xyz, const Numbers& axis) {
    joints_.push_back({.kind = Kind::revolute,
                       .parent = last_++,
                       .coordinate = of,
                       .factor = factor,
                       .xyz = xyz,
                       .axis = axis});
  }
  [[nodiscard]] const std::vector<OracleJoint>& joints() const { return joints_; }
  [[nodiscard]] int last() const { return last_; }
  [[nodiscard]] std::size_t coordinates() const { return static_cast<std::size_t>(coordinates_); }

 private:
  std::vector<OracleJoint> joints_;
  int last_ = -1;
  int coordinates_ = 0;
};

struct CraneKind {
  bool has_crane = true, is_level = true, has_roll = true;
};

/// A crane on a floor that is turned anyhow, with every length that a crane can have.
Chain random_crane(const CraneKind& kind, Random& random) {
  Chain chain;
  const auto turned = [&](const Numbers& rpy) {
    chain.add(Kind::fixed, random.numbers(1), {1, 0, 0}).rpy = rpy;
  };
  turned(random.numbers(pi));
  const double up = random.toss() ? 1 : -1;
  if (kind.has_crane) {
    const double track = random.between(-pi, pi);
    chain.add(Kind::prismatic, random.numbers(1), {std::cos(track), std::sin(track), 0});
    chain.add(Kind::revolute, random.numbers(1), {0, 0, up});
    const double boom = random.between(-pi, pi);
    const Numbers axis = {std::cos(boom), std::sin(boom), 0};
    chain.add(Kind::revolute, random.numbers(1), axis);
    if (kind.is_level) {
      const double side = random.toss() ? 1 : -1;
      chain.add_mimic(2, -side, random.numbers(2), {side * axis[0], side * axis[1], 0});
    }
    turned(random.numbers(pi));
  }
  chain.add(Kind::revolute, {0, 0, random.between(-1, 1)}, {0, 0, 1});
  chain.add(Kind::revolute, {0, 0, random.between(-1, 1)}, {0, -1, 0});
  // The roll leans in the plane that the tilt turns.
  const double lean = kind.has_roll ? random.between(-1, 1) : 0;
  if (kind.has_roll) chain.add(Kind::revolute, {0, 0, 0}, {std::cos(lean), 0, std::sin(lean)});
  const bool is_free = kind.has_roll && kind.has_crane;
  OracleJoint& camera = chain.add(Kind::fixed, {random.between(-0.5, 0.5), 0, 0}, {1, 0, 0});
  if (is_free) {
    camera.xyz = random.numbers(0.5);
    camera.rpy = random.numbers(pi);
  }
  return chain;
}

/// What the link does in this pose, as a target that asks for it.
TipTarget target_of(const OraclePose& pose, double distance) {
  const auto vector = [](const Numbers& v) { return Vector3{v[0], v[1], v[2]}; };
  const Vector3 position = vector(pose.position);
  return {.position = position,
          .aim = position + vector(pose.columns[0]) * distance,
          .roll = std::atan2(pose.columns[1][2], pose.columns[2][2])};
}

/// The larger of the distance of the places and of the differences of the directions.
double difference(const OraclePose& a, const OraclePose& b, bool has_roll) {
  double worst = 0;
  for (std::size_t d = 0; d < 3; ++d) {
    worst = std::max(
        {worst, std::fabs(a.position[d] - b.position[d]), std::fabs(a.columns[0][d] - b.columns[0][d])});
    if (has_roll) worst = std::max(worst, std::fabs(a.columns[1][d] - b.columns[1][d]));
  }
  return worst;
}

std::vector<TipAxis> all_axes(std::size_t count, const std::vector<double>& near) {
  std::vector<TipAxis> axes;
  for (std::size_t i = 0; i < count; ++i) axes.push_back({i, -4, 4, near[i]});
  return axes;
}

/// Whether two places of an axis are the same but for whole turns.
bool is_same_place(double a, double b, bool slides) {
  const double turns = slides ? 0 : std::round((a - b) / (2 * pi));
  return std::fabs(a - b - 2 * pi * turns) < 1e-6;
}

void expect_all_solutions(const CraneKind& kind, std::uint64_t seed) {
  Random random(seed);
  const Chain chain = random_crane(kind, random);
  const Kinematics kinematics = kinematics_of(chain.joints());
  const OracleTree oracle(chain.joints());
  const std::vector<double> drawn = random.angles(chain.coordinates(), 3);
  const OraclePose wanted = oracle.pose(chain.last(), drawn);
  // Straight up there is no level, and a head without roll is seen by its own.
  if (std::fabs(wanted.columns[0][2]) > 0.999) return;
  TipTarget target = target_of(wanted, random.between(0.5, 5));
  if (!kind.has_roll) target.roll.reset();
  if (!kind.has_crane) target.position.reset();
  const auto crane = CraneSolutions::find(kinematics, chain.last() + 1, all_axes(chain.coordinates(), drawn));
  RC_ASSERT(crane.has_value());
  RC_ASSERT(crane->is_for(target));
  bool found_drawn = false;
  const auto solutions = crane->of(target);
  RC_ASSERT(solutions.size() <= (kind.has_crane ? 8U : 2U));
  for (const std::vector<double>& positions : solutions) {
    RC_ASSERT(difference(oracle.pose(chain.last(), positions), wanted, kind.has_roll) <= 1e-9);
    bool is_drawn = true;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      is_drawn = is_drawn && is_same_place(positions[i], drawn[i], kind.has_crane && i == 0);
    }
    found_drawn = found_drawn || is_drawn;
  }
  RC_ASSERT(found_drawn);
}

TEST(InverseProperty, ACraneHasAllItsSolutionsInClosedForm) {
  check_property(10'000, [](std::uint64_t seed, bool is_level, bool has_roll) {
    expect_all_solutions({.has_crane = true, .is_level = is_level, .has_roll = has_roll}, seed);
  });
}

TEST(InverseProperty, AHeadHasBothSolutionsInClosedForm) {
  check_property(10'000, [](std::uint64_t seed, bool has_roll) {
    expect_all_solutions({.has_crane = false, .is_level = false, .has_roll = has_roll}, seed);
  });
}

/// An arm of seven joints, one of which follows another, and turned fixed links between them.
Chain random_arm(Random& random) {
  Chain chain;
  for (int i = 0; i < 6; ++i) {
    if (random.between(0, 1) < 0.3)
      chain.add(Kind::fixed, random.numbers(0.3), {1, 0, 0}).rpy = random.numbers(pi);
    const bool slides = random.between(0, 1) < 0.2;
    Numbers axis = random.numbers(1);
    axis[static_cast<std::size_t>(i) % 3] += 2;
    chain.add(slides ? Kind::prismatic : Kind::revolute, random.numbers(1), axis).rpy = random.numbers(pi);
    if (i == 3) chain.add_mimic(1, random.between(-1, 1), random.numbers(1), random.numbers(1));
  }
  chain.add(Kind::fixed, random.numbers(0.3), {1, 0, 0}).rpy = random.numbers(pi);
  return chain;
}

TEST(InverseProperty, DampedLeastSquaresFindsThePoseThatItBeganBesideAndGoesOnWithIt) {
  int found = 0;
  int tried = 0;
  check_property(10'000, [&](std::uint64_t seed) {
    Random random(seed);
    const Chain chain = random_arm(random);
    const Kinematics kinematics = kinematics_of(chain.joints());
    const OracleTree oracle(chain.joints());
    const std::vector<double> drawn = random.angles(chain.coordinates(), 2);
    const OraclePose wanted = oracle.pose(chain.last(), drawn);
    if (std::fabs(wanted.columns[0][2]) > 0.99) return;
    const TipTarget target = target_of(wanted, random.between(0.5, 5));
    const TipSolver solver(kinematics, chain.last() + 1, all_axes(chain.coordinates(), drawn));
    std::vector<double> seeded = drawn;
    for (double& position : seeded) position += random.between(-0.05, 0.05);
    const TipSolution solution = solver.solve(target, seeded);
    ++tried;
    if (!solution.is_exact()) return;  // beside a singular place it may end elsewhere
    ++found;
    RC_ASSERT(difference(oracle.pose(chain.last(), solution.positions), wanted, true) <= 1e-9);
    // The link moves as its target does.
    const TipTargetRate rate{
        .position = Vector3{0.3, -0.2, 0.1}, .aim = Vector3{0.1, 0.2, -0.4}, .roll = 0.7};
    if (solver.freedom(target, solution.positions, 6).smallest < 1e-3) return;
    const std::vector<double> rates = solver.rates(target, rate, solution.positions);
    std::vector<double> next = solution.positions;
    constexpr double step = 1e-6;
    for (std::size_t i = 0; i < next.size(); ++i) next[i] += step * rates[i];
    const TipTarget moved = target_of(oracle.pose(chain.last(), next), 1);
    const auto along = [&](const Vector3& from, const Vector3& by) { return from + by * step; };
    const Vector3 gap = *moved.position - along(*target.position, *rate.position);
    RC_ASSERT(std::sqrt(dot(gap, gap)) <= 1e-7);
    const Vector3 sight = along(*target.aim, *rate.aim) - *moved.position;
    const Vector3 off = cross(sight, *moved.aim - *moved.position);
    RC_ASSERT(std::sqrt(dot(off, off) / dot(sight, sight)) <= 1e-7);
    RC_ASSERT(std::fabs(std::remainder(*moved.roll - *target.roll - *rate.roll * step, 2 * pi)) <= 1e-7);
  });
  if (!counts_mean_something()) return;
  EXPECT_GT(found, tried * 9 / 10);
}

}  // namespace inverse_property_test
}  // namespace inbetween
