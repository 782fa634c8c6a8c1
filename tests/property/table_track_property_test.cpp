// Random tables of rows, against the spline through them in long double.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "host_tools/plan/fitted_trajectory.hpp"
#include "host_tools/plan/plan.hpp"
#include "tests/support/oracle_curves.hpp"
#include "tests/support/property.hpp"

namespace inbetween {
namespace table_track_property_test {

struct RandomTable {
  std::vector<std::int32_t> frames;
  std::vector<std::vector<double>> axes;  ///< of each a value in every row
  std::optional<RestingEnds> rest;

  [[nodiscard]] std::int32_t last() const { return frames.back(); }
  [[nodiscard]] double range() const {
    double range = 0;
    for (const std::vector<double>& at : axes) {
      const auto [low, high] = std::ranges::minmax(at);
      range = std::max(range, high - low);
    }
    return range;
  }
  [[nodiscard]] std::string csv() const {
    std::string text = "frame";
    for (std::size_t d = 0; d < axes.size(); ++d) text += fmt::format(",a{}", d);
    for (std::size_t row = 0; row < frames.size(); ++row) {
      text += fmt::format("\n{}", frames[row]);
      for (const std::vector<double>& at : axes) text += fmt::format(",{}", at[row]);
    }
    return text;
  }
  [[nodiscard]] std::string move() const {
    std::string names;
    for (std::size_t d = 0; d < axes.size(); ++d) names += fmt::format("{}\"a{}\"", d > 0 ? ", " : "", d);
    std::string text = fmt::format(
        "name = \"t\"\nfps = 24\nframes = {}\n[[track]]\naxes = [{}]\ntable = \"rows.csv\"\n", last(), names);
    if (rest)
      text += fmt::format("rest = \"{}\"\n",
                          rest->start ? (rest->end ? "both" : "start") : (rest->end ? "end" : "none"));
    return text;
  }
  [[nodiscard]] Plan plan() const {
    const auto rows = [&](const std::filesystem::path&, std::size_t) { return csv(); };
    return {parse_move_beside(rows, move(), "move.toml"), std::nullopt, {}};
  }
  [[nodiscard]] std::vector<oracle::TimedPiece> curve(std::size_t axis) const {
    const std::vector<double>& at = axes[axis];
    oracle::TimedKeys keys;
    keys.at.assign(at.begin(), at.end());
    keys.frames.assign(frames.begin(), frames.end());
    keys.rests_between_equals = false;
    keys.rests_at_start = rest ? rest->start : at[0] == at[1];
    keys.rests_at_end = rest ? rest->end : at[at.size() - 2] == at.back();
    return smooth_curve(keys);
  }
};

void showValue(const RandomTable& table, std::ostream& out) {
  out << table.move() << table.csv();
}

RandomTable random_table() {
  RandomTable table;
  table.frames = {0};
  const bool is_dense = *rc::gen::arbitrary<bool>();
  for (int rows = *rc::gen::inRange(1, 12); rows > 0; --rows)
    table.frames.push_back(table.frames.back() + (is_dense ? 1 : *rc::gen::inRange(1, 9)));
  for (int axes = *rc::gen::inRange(1, 4); axes > 0; --axes) {
    std::vector<double>& at = table.axes.emplace_back();
    for (std::size_t row = 0; row < table.frames.size(); ++row) {
      const bool stays = row > 0 && *rc::gen::inRange(0, 3) == 0;
      at.push_back(stays ? at.back() : *rc::gen::inRange(-100'000, 100'001) / 1000.0);
    }
  }
  if (*rc::gen::inRange(0, 3) == 0)
    table.rest = RestingEnds{*rc::gen::arbitrary<bool>(), *rc::gen::arbitrary<bool>()};
  return table;
}

TEST(TableTrackProperty, EveryAxisIsTheSplineThroughItsRows) {
  double worst = 0;
  check_property(2000, [&] {
    const RandomTable table = random_table();
    RC_LOG() << rc::toString(table);
    const Plan plan = table.plan();
    const FittedTrajectory played(plan.tracks().front().track());
    const double range = table.range();
    for (std::size_t d = 0; d < table.axes.size(); ++d) {
      const std::vector<oracle::TimedPiece> curve = table.curve(d);
      for (std::int32_t eighth = 0; eighth < 8 * table.last(); ++eighth) {
        const AxisMotion motion = played->motion_of(d, {eighth / 8, eighth % 8 / 8.0});
        const std::vector<double> found = {motion.position, motion.velocity / 24,
                                           motion.acceleration / 24 / 24};
        for (int order = 0; order < 3; ++order) {
          const auto wanted = static_cast<double>(oracle::curve_at(curve, eighth / 8.0L, order));
          const double off = std::fabs(found[static_cast<std::size_t>(order)] - wanted);
          RC_ASSERT(off <= 1e-9 * range + 1e-12);
          if (range > 0) worst = std::max(worst, off / range);
        }
      }
    }
  });
  std::cout << "largest difference: " << worst << " of the range\n";
}

TEST(TableTrackProperty, EveryRowIsMetAndNothingStepsBetweenThem) {
  check_property(2000, [&] {
    const RandomTable table = random_table();
    RC_LOG() << rc::toString(table);
    const Plan plan = table.plan();
    const FittedTrajectory played(plan.tracks().front().track());
    const double range = table.range();
    for (std::size_t d = 0; d < table.axes.size(); ++d) {
      for (std::size_t row = 0; row < table.frames.size(); ++row) {
        const double at = played->motion_of(d, {table.frames[row], 0}).position;
        RC_ASSERT(std::fabs(at - table.axes[d][row]) <= 1e-12 * (range + 100));
      }
      for (std::size_t piece = 1; piece < played->pieces().size(); ++piece) {
        for (std::size_t order = 0; order < 3; ++order) {
          const double before = at_end_of_piece(*played, played->pieces()[piece - 1], d, order, true);
          const double behind = at_end_of_piece(*played, played->pieces()[piece], d, order, false);
          RC_ASSERT(std::fabs(before - behind) <= (1e-9 * range + 1e-12) * std::pow(24.0, order));
        }
      }
    }
  });
}

}  // namespace table_track_property_test
}  // namespace inbetween
