// Random rows of points in space, on arms of two joints and on slides: where their tips are, against Coons'
// formula in long double.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/joints/urdf_file.hpp"
#include "host_tools/plan/plan.hpp"
#include "tests/support/oracle_network.hpp"
#include "tests/support/property.hpp"

namespace inbetween {
namespace row_of_points_property_test {

constexpr double reach_m = 0.3;
constexpr std::size_t xyz = 3;

/// A point on an arm of two parallel joints that turn in the plane of x and z, or on three slides.
struct RandomPoint {
  bool is_arm = false;
  std::array<double, 3> root_m{};
  double upper_m = 0;
  double place = 0;
  std::vector<std::array<double, 3>> keys;
  std::vector<std::int32_t> drawn_frames;  // empty: it is not drawn
  std::vector<std::array<double, 3>> drawn;
};

struct RandomRow {
  std::vector<std::int32_t> key_frames;
  std::vector<RandomPoint> points;
  bool rests_at_start = true;
  bool rests_at_end = true;
};

double number_from(double least, double most) {
  return least + (most - least) * *rc::gen::inRange(0, 1001) / 1000.0;
}

/// Well within reach of an arm. Beside an arm nothing leaves the plane of x and z: what is drawn there would
/// lead the arm out of it.
std::array<double, 3> place_for(const RandomPoint& point, bool is_plane) {
  const auto [x, y, z] = point.root_m;
  if (!point.is_arm)
    return {x + number_from(-0.2, 0.2), is_plane ? y : y + number_from(-0.2, 0.2),
            z + number_from(-0.2, 0.2)};
  const double distance = reach_m * number_from(0.6, 0.85);
  const double angle = number_from(-0.8, 0.8);
  return {x + distance * std::cos(angle), y, z + distance * std::sin(angle)};
}

std::vector<std::int32_t> frames_to(std::int32_t last, int most) {
  std::vector<std::int32_t> frames = {0};
  for (int i = *rc::gen::inRange(0, most); i > 0; --i) {
    const std::int32_t next = frames.back() + *rc::gen::inRange(6, 20);
    if (next + 6 > last) break;
    frames.push_back(next);
  }
  frames.push_back(last);
  return frames;
}

RandomRow random_row() {
  RandomRow row;
  row.rests_at_start = *rc::gen::arbitrary<bool>();
  row.rests_at_end = *rc::gen::arbitrary<bool>();
  const std::int32_t last = *rc::gen::inRange(12, 73);
  row.key_frames = frames_to(last, 4);
  const int count = *rc::gen::inRange(1, 5);
  const bool is_plane = *rc::gen::inRange(0, 3) > 0;
  for (int p = 0; p < count; ++p) {
    RandomPoint& point = row.points.emplace_back();
    point.is_arm = is_plane && *rc::gen::inRange(0, 3) > 0;
    point.root_m = {0.5 * p, number_from(-0.1, 0.1), number_from(-0.1, 0.1)};
    point.upper_m = reach_m * number_from(0.4, 0.6);
    point.place = (p > 0 ? row.points[static_cast<std::size_t>(p) - 1].place : 0) + *rc::gen::inRange(0, 3);
    if (p == 0 || *rc::gen::inRange(0, 2) == 0) point.drawn_frames = frames_to(last, 5);
    for (std::size_t i = 0; i < point.drawn_frames.size(); ++i)
      point.drawn.push_back(place_for(point, is_plane));
    for (std::size_t k = 0; k < row.key_frames.size(); ++k) point.keys.push_back(place_for(point, is_plane));
  }
  return row;
}

std::string rig_of(const RandomRow& row) {
  std::string tips;
  std::string axes;
  for (std::size_t p = 0; p < row.points.size(); ++p) {
    tips += fmt::format("\"p{}\",", p);
    for (const char* joint : row.points[p].is_arm ? std::vector{"a", "b"} : std::vector{"x", "y", "z"}) {
      axes += fmt::format(
          "[[axis]]\nname = \"{}{}\"\nunit = \"{}\"\nmin = -3\nmax = 3\nmax_velocity = 1000\n"
          "max_acceleration = 100000\ndrive = {{ type = \"pipe\", path = \"/dev/null\", counts_per_unit = 1 "
          "}}\n",
          joint, p, row.points[p].is_arm ? "rad" : "m");
    }
  }
  return fmt::format(
      "name = \"rows\"\nrate_hz = 100\n[kinematics]\nurdf = \"r.urdf\"\ntip = [{}]\nlimits = \"rig\"\n{}",
      tips, axes);
}

std::string joint_of(const std::string& name, const std::string& kind, const std::string& parent,
                     const std::string& child, const std::array<double, 3>& at, const std::string& axis) {
  return fmt::format(
      "<link name=\"{3}\"/><joint name=\"{0}\" type=\"{1}\"><parent link=\"{2}\"/><child link=\"{3}\"/>"
      "<origin xyz=\"{4:.17g} {5:.17g} {6:.17g}\"/><axis xyz=\"{7}\"/>"
      "<limit lower=\"-3\" upper=\"3\" effort=\"1\" velocity=\"9\"/></joint>\n",
      name, kind, parent, child, at[0], at[1], at[2], axis);
}

std::string urdf_of(const RandomRow& row) {
  std::string text = "<robot name=\"rows\"><link name=\"base\"/>\n";
  for (std::size_t p = 0; p < row.points.size(); ++p) {
    const RandomPoint& point = row.points[p];
    const auto named = [&](const char* word) { return fmt::format("{}{}", word, p); };
    if (point.is_arm) {
      text += joint_of(named("a"), "revolute", "base", named("u"), point.root_m, "0 -1 0");
      text += joint_of(named("b"), "revolute", named("u"), named("v"), {point.upper_m, 0, 0}, "0 -1 0");
      text += joint_of(named("c"), "fixed", named("v"), named("p"), {reach_m - point.upper_m, 0, 0}, "1 0 0");
    } else {
      text += joint_of(named("x"), "prismatic", "base", named("u"), point.root_m, "1 0 0");
      text += joint_of(named("y"), "prismatic", named("u"), named("v"), {}, "0 1 0");
      text += joint_of(named("z"), "prismatic", named("v"), named("p"), {}, "0 0 1");
    }
  }
  return text + "</robot>\n";
}

std::string listed(const std::array<double, 3>& at) {
  return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", at[0], at[1], at[2]);
}

std::string move_of(const RandomRow& row) {
  std::string axes, tips, places, drawn, keys;
  for (std::size_t p = 0; p < row.points.size(); ++p) {
    const RandomPoint& point = row.points[p];
    for (const char* joint : point.is_arm ? std::vector{"a", "b"} : std::vector{"x", "y", "z"})
      axes += fmt::format("\"{}{}\",", joint, p);
    tips += fmt::format("\"p{}\",", p);
    places += fmt::format("{},", point.place);
    if (point.drawn.empty()) continue;
    drawn += fmt::format("p{} = [", p);
    for (std::size_t i = 0; i < point.drawn.size(); ++i)
      drawn += fmt::format("{{ frame = {}, at = {} }},", point.drawn_frames[i], listed(point.drawn[i]));
    drawn += "]\n";
  }
  for (std::size_t k = 0; k < row.key_frames.size(); ++k) {
    keys += fmt::format("{{ frame = {}, at = {{", row.key_frames[k]);
    std::string comma;
    for (std::size_t p = 0; p < row.points.size(); ++p) {
      if (!row.points[p].drawn.empty()) continue;
      keys += fmt::format("{}p{} = {}", std::exchange(comma, ","), p, listed(row.points[p].keys[k]));
    }
    keys += "} },\n";
  }
  const bool has_arm = std::ranges::any_of(row.points, &RandomPoint::is_arm);
  const char* const rest =
      row.rests_at_start ? (row.rests_at_end ? "both" : "start") : (row.rests_at_end ? "end" : "none");
  return fmt::format(
      "name = \"row\"\nfps = 24\nframes = {}\n[[track]]\naxes = [{}]\nspace = [{}]\nnetwork = true\n"
      "timing = \"frames\"\nrest = \"{}\"\nplaces = [{}]\n{}keys = [{}]\n[track.drawn]\n{}",
      row.key_frames.back(), axes, tips, rest, places, has_arm ? "elbow = \"down\"\n" : "", keys, drawn);
}

/// Coordinate c of the row by Coons' formula. A drawn point has no keys: it is on its curve at each of them.
oracle::NetworkOracle formula_of(const RandomRow& row, std::size_t c) {
  std::vector<oracle::NetworkAxis> axes;
  for (const RandomPoint& point : row.points) {
    oracle::NetworkAxis& axis = axes.emplace_back();
    axis.place = point.place;
    axis.keys.frames.assign(row.key_frames.begin(), row.key_frames.end());
    axis.keys.rests_at_start = row.rests_at_start;
    axis.keys.rests_at_end = row.rests_at_end;
    if (point.drawn.empty()) {
      for (const std::array<double, 3>& key : point.keys) axis.keys.at.push_back(key.at(c));
      continue;
    }
    oracle::TimedKeys& drawn = axis.drawn.emplace(axis.keys);
    drawn.at.clear();
    for (const std::array<double, 3>& at : point.drawn) drawn.at.push_back(at.at(c));
    drawn.frames.assign(point.drawn_frames.begin(), point.drawn_frames.end());
    const std::vector<oracle::TimedPiece> curve = oracle::smooth_curve(drawn);
    for (const std::int32_t frame : row.key_frames) axis.keys.at.push_back(oracle::curve_at(curve, frame, 0));
  }
  return oracle::NetworkOracle(std::move(axes));
}

std::array<double, 3> tip_of(const RandomPoint& point, const double* joints) {
  const auto [x, y, z] = point.root_m;
  if (!point.is_arm) return {x + joints[0], y + joints[1], z + joints[2]};
  const double lower_m = reach_m - point.upper_m;
  const double angle = joints[0] + joints[1];
  return {x + point.upper_m * std::cos(joints[0]) + lower_m * std::cos(angle), y,
          z + point.upper_m * std::sin(joints[0]) + lower_m * std::sin(angle)};
}

/// What the formula asks of every point, in fractions of a frame.
class WantedPath {
 public:
  explicit WantedPath(const RandomRow& row) {
    for (std::size_t c = 0; c < xyz; ++c) coordinates_.push_back(formula_of(row, c));
  }
  [[nodiscard]] std::array<double, 3> at(std::size_t point, long double frame) const {
    std::array<double, 3> place{};
    for (std::size_t c = 0; c < xyz; ++c)
      place.at(c) = static_cast<double>(coordinates_[c].at(point, frame, 0));
    return place;
  }

 private:
  std::vector<oracle::NetworkOracle> coordinates_;
};

double distance(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// An arm that the patch leads to the end of its reach may be refused.
bool leads_out_of_reach(const RandomRow& row, const WantedPath& wanted) {
  for (std::size_t p = 0; p < row.points.size(); ++p) {
    const RandomPoint& point = row.points[p];
    if (!point.is_arm) continue;
    const double least = std::fabs(2 * point.upper_m - reach_m);
    for (int i = 0; i <= 8 * row.key_frames.back(); ++i) {
      const double far = distance(wanted.at(p, i / 8.0L), point.root_m);
      if (far > 0.98 * reach_m || far < least + 0.1 * reach_m) return true;
    }
  }
  return false;
}

TEST(RowOfPointsProperty, EveryTipIsWhereTheFormulaHasItsPoint) {
  int solved = 0;
  int cases = 0;
  double worst = 0;
  check_property(300, [&] {
    const RandomRow row = random_row();
    ++cases;
    RC_LOG() << move_of(row) << rig_of(row) << urdf_of(row);
    const WantedPath wanted(row);
    const RigFile rig = parse_rig(rig_of(row), "rig.toml");
    const auto joints = std::make_shared<const Kinematics>(parse_urdf(urdf_of(row), "r.urdf"), rig);
    std::optional<Plan> plan;
    try {
      plan.emplace(parse_move(move_of(row), "move.toml"), rig, PlanOptions{.kinematics = joints});
    } catch (const InputError& refused) {
      RC_LOG() << refused.what();
      RC_ASSERT(leads_out_of_reach(row, wanted));
      return;
    }
    ++solved;
    const Track& track = plan->tracks().front().track();
    std::vector<double> axes(plan->axes().size());
    for (int i = 0; i <= 7 * row.key_frames.back(); ++i) {
      track.positions({i / 7, i % 7 / 7.0}, axes);
      const double* first = axes.data();
      for (std::size_t p = 0; p < row.points.size(); ++p) {
        const double miss = distance(tip_of(row.points[p], first), wanted.at(p, i / 7 + i % 7 / 7.0));
        worst = std::max(worst, miss);
        RC_ASSERT(miss <= plan->accuracy(0)->off_m + 1e-14);
        RC_ASSERT(miss <= 1e-7);
        first += row.points[p].is_arm ? 2 : 3;
      }
    }
  });
  std::cout << solved << " of " << cases << " rows solved, within " << worst << " m\n";
  if (counts_mean_something()) {
    EXPECT_GT(3 * solved, 2 * cases);
  }
}

}  // namespace row_of_points_property_test
}  // namespace inbetween
