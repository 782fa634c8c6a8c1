// What export writes import brings back with the same words, whatever units, signs and counts are said; and a
// robot of any joints becomes a rig whose axes its joints can follow.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "host_tools/exchange/exchange_format.hpp"
#include "host_tools/exchange/export_choices.hpp"
#include "host_tools/exchange/import_answers.hpp"
#include "host_tools/exchange/rows_move.hpp"
#include "host_tools/exchange/urdf_rig.hpp"
#include "host_tools/joints/kinematics.hpp"
#include "tests/support/property.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace import_property_test {

constexpr std::array formats = {ExchangeFormat::csv, ExchangeFormat::raw_move, ExchangeFormat::kuper,
                                ExchangeFormat::maya_mov, ExchangeFormat::servo_json};

int whole(std::mt19937_64& random, int low, int high) {
  return std::uniform_int_distribution<int>(low, high)(random);
}

double real(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

template <class Choices>
auto one_of(std::mt19937_64& random, const Choices& choices) {
  return choices[static_cast<std::size_t>(whole(random, 0, static_cast<int>(std::size(choices)) - 1))];
}

RigFile random_rig(std::mt19937_64& random) {
  std::vector<AxisText> axes;
  const int count = whole(random, 1, 6);
  for (int a = 0; a < count; ++a) {
    const char* const unit = one_of(random, std::array{"mm", "m", "deg", "rad", "turn"});
    axes.push_back(axis_text(fmt::format("axis {}", a), unit, {-1e6, 1e6}));
  }
  std::string text = rig_text(axes);
  for (std::size_t at = 0; (at = text.find("axis ", at)) != std::string::npos; ++at) text[at + 4] = '_';
  return parse_rig(text, "rig.toml");
}

/// A motion of the rig, and the words for a file of it.
struct Spoken {
  BakedTable table;
  ExportChoices out;
  ImportSaid in;
};

Spoken random_words(const RigFile& rig, ExchangeFormat format, std::mt19937_64& random) {
  Spoken spoken{.table = {.file = "move"}, .out = {}, .in = {}};
  const auto rows = static_cast<std::size_t>(whole(random, 2, 40));
  spoken.table.fps = FrameRate{whole(random, 1, 60), 1};
  spoken.table.first_frame = 0;
  spoken.table.phase = ShutterPhase::frame_boundary;
  int number = 0;
  for (const RigAxis& axis : rig.axes) {
    BakedColumn& column = spoken.table.columns.emplace_back();
    column.name = axis.name;
    column.unit = as_move_unit(axis.unit);
    for (std::size_t row = 0; row < rows; ++row) column.values.push_back(real(random, -900, 900));
    const bool is_length = axis.unit == AxisUnit::mm || axis.unit == AxisUnit::m;
    const MoveUnit unit =
        is_length ? one_of(random,
                           std::array{MoveUnit::mm, MoveUnit::cm, MoveUnit::m, MoveUnit::inch, MoveUnit::ft})
                  : one_of(random, std::array{MoveUnit::deg, MoveUnit::rad, MoveUnit::turn});
    const std::string name = fmt::format("C{}", ++number);
    AxisWord word{.column = name, .axis = axis.name};
    const bool has_names = format != ExchangeFormat::raw_move && format != ExchangeFormat::maya_mov;
    if (format == ExchangeFormat::servo_json) {
      const CountWord count{.column = name,
                            .zero = std::round(real(random, -2000, 2000)),
                            .count = real(random, 0.001, 1),
                            .unit = unit};
      spoken.out.counts.push_back(count);
      spoken.in.counts.push_back(count);
    } else {
      word.is_reversed = whole(random, 0, 1) == 0;
      spoken.out.units.push_back({name, unit});
      if (format != ExchangeFormat::csv)
        spoken.in.units.push_back({has_names ? name : std::to_string(number), unit});
    }
    spoken.out.axes.push_back(word);
    if (!has_names) word.column = std::to_string(number);
    spoken.in.axes.push_back(word);
  }
  if (format != ExchangeFormat::servo_json) spoken.in.fps = spoken.table.fps;
  spoken.in.phase = ShutterPhase::frame_boundary;
  return spoken;
}

/// How far half of the last digit of a file is, in the unit of the axis.
double precision(const Spoken& spoken, std::size_t a, const RigAxis& axis, int decimals) {
  const double digit = 0.5 * std::pow(10.0, -decimals);
  constexpr double rounding = 1e-9;
  if (spoken.out.counts.empty()) {
    return digit * converted(1, spoken.out.units[a].unit, axis.unit).value_or(1) + rounding;
  }
  const CountWord& count = spoken.out.counts[a];
  return 0.5 * std::fabs(count.count) * converted(1, count.unit, axis.unit).value_or(1) + rounding;
}

TEST(ImportProperty, WhatIsExportedIsImportedWithTheSameWords) {
  check_property(4'000, [](std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const RigFile rig = random_rig(random);
    const ExchangeFormat format = *rc::gen::elementOf(formats);
    const Spoken spoken = random_words(rig, format, random);
    const int decimals = whole(random, 2, 12);
    const std::string text = write_baked_table(format, exported_table(spoken.table, spoken.out), decimals);
    RC_LOG() << to_string(format) << "\n" << text;
    const BakedTable read = read_baked_table(format, text, "file");
    RC_ASSERT(open_questions(read, rig, spoken.in).empty());
    const BakedTable back = imported_table(read, rig, spoken.in);
    RC_ASSERT(back.columns.size() == rig.axes.size());
    const RowsMove move = rows_move_of(back, rig, "m");
    for (std::size_t a = 0; a < rig.axes.size(); ++a) {
      const std::vector<double>& values = spoken.table.columns[a].values;
      const auto found = std::ranges::find(move.axes, rig.axes[a].name);
      RC_ASSERT(found != move.axes.end());
      const std::vector<double>& positions =
          move.positions[static_cast<std::size_t>(found - move.axes.begin())];
      RC_ASSERT(positions.size() == values.size());
      for (std::size_t row = 0; row < values.size(); ++row)
        RC_ASSERT(std::fabs(positions[row] - values[row]) <= precision(spoken, a, rig.axes[a], decimals));
    }
  });
}

/// A tree of joints of all kinds; limits with any digits.
std::string random_robot(std::mt19937_64& random) {
  std::string text = "<robot name=\"r\">\n<link name=\"l0\"/>\n";
  const int joints = whole(random, 1, 12);
  std::vector<int> turning;
  for (int j = 1; j <= joints; ++j) {
    const char* const type = one_of(random, std::array{"fixed", "revolute", "prismatic", "revolute"});
    const double lower = real(random, -4, 1);
    const int digits = whole(random, 0, 12);
    text += fmt::format(
        "<link name=\"l{0}\"/><joint name=\"j{0}\" type=\"{1}\"><parent link=\"l{2}\"/><child link=\"l{0}\"/>"
        "<axis xyz=\"0 0 1\"/>",
        j, type, whole(random, 0, j - 1));
    if (std::string(type) != "fixed") {
      text +=
          fmt::format("<limit lower=\"{0:.{3}f}\" upper=\"{1:.{3}f}\" effort=\"1\" velocity=\"{2:.4f}\"/>",
                      lower, lower + real(random, 1.5, 5), real(random, 0.01, 20), digits);
      const bool mimics = std::string(type) == "revolute" && !turning.empty() && whole(random, 0, 3) == 0;
      if (mimics)
        text += fmt::format("<mimic joint=\"j{}\" multiplier=\"{:.2f}\"/>", one_of(random, turning),
                            real(random, -2, 2));
      if (!mimics && std::string(type) == "revolute") turning.push_back(j);
    }
    text += "</joint>\n";
  }
  return text + "</robot>\n";
}

TEST(ImportProperty, ARobotIsARigWhoseJointsCanFollow) {
  check_property(2'000, [](std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const std::string text = random_robot(random);
    RC_LOG() << text;
    const UrdfFile file = parse_urdf(text, "robot.urdf");
    UrdfRigChoices choices{.rate_hz = 250, .reach_s = real(random, 0.01, 10)};
    choices.angle = one_of(random, std::array{MoveUnit::deg, MoveUnit::rad, MoveUnit::turn});
    choices.length = one_of(random, std::array{MoveUnit::mm, MoveUnit::m});
    std::size_t axes = 0;
    for (const UrdfJoint& joint : file.joints)
      axes += joint.kind != UrdfJointKind::fixed && !joint.mimic ? 1U : 0U;
    if (axes == 0) return;
    const UrdfRig made = rig_of_urdf(file, "robot.urdf", choices);
    RC_LOG() << made.text;
    RC_ASSERT(made.open.empty());
    const RigFile rig = parse_rig(made.text, "rig.toml");
    RC_ASSERT(rig.axes.size() == axes);
    static_cast<void>(Kinematics(file, rig));  // refuses an axis that goes farther or faster than its joint
    // And none is left out of what it may do by more than the last digit that is written.
    for (const RigAxis& axis : rig.axes) {
      const auto joint = std::ranges::find(file.joints, axis.name, &UrdfJoint::name);
      const AxisUnit base = joint->kind == UrdfJointKind::prismatic ? AxisUnit::m : AxisUnit::rad;
      const double size = converted(1, as_move_unit(axis.unit), base).value_or(0);
      RC_ASSERT(std::fabs(axis.min * size - joint->limit->lower) <= 1.1e-6 * size + 1e-12);
      RC_ASSERT(std::fabs(axis.max * size - joint->limit->upper) <= 1.1e-6 * size + 1e-12);
      RC_ASSERT(std::fabs(axis.max_velocity * size - joint->limit->velocity) <= 1.1e-6 * size + 1e-12);
    }
  });
}

}  // namespace import_property_test
}  // namespace inbetween
