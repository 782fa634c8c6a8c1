#include "host_tools/exchange/urdf_rig.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <string_view>

#include "host_tools/exchange/toml_text.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/text/spelling.hpp"
#include "inbetween/joints/joint_tree.hpp"

namespace inbetween {
namespace {

/// A thousandth of a degree and a micrometre, or about that: what a simulated drive counts in.
struct SimulatedUnit {
  std::string_view word;
  double per_base = 1;  // how many of it a radian or a metre has
  int decimals = 6;     // of limits
  double counts_per_unit = 1'000;
};

SimulatedUnit unit_for(const UrdfJoint& joint, const UrdfRigChoices& choices) {
  const MoveUnit unit = joint.kind == UrdfJointKind::prismatic ? choices.length : choices.angle;
  const AxisUnit base = joint.kind == UrdfJointKind::prismatic ? AxisUnit::m : AxisUnit::rad;
  SimulatedUnit made{.word = to_string(unit), .per_base = 1 / converted(1, unit, base).value_or(1)};
  constexpr int more_decimals = 9;
  if (unit == MoveUnit::m) made.counts_per_unit = 1'000'000;
  if (unit == MoveUnit::rad) made.counts_per_unit = 100'000;
  if (unit == MoveUnit::turn) made.counts_per_unit = 360'000;
  if (unit != MoveUnit::deg && unit != MoveUnit::mm) made.decimals = more_decimals;
  return made;
}

enum class Rounding { down, up };

/// In `decimals` decimals and without zeros behind them; a number that is one of those stays what it is.
std::string rounded_word(double value, int decimals, Rounding rounding) {
  const double scale = std::pow(10.0, decimals);
  const double nearest = std::round(value * scale);
  constexpr double rounding_share = 1e-12;  // of a conversion, in last bits
  const bool is_one = std::fabs(value * scale - nearest) <= rounding_share * (1 + std::fabs(nearest));
  const double whole = is_one                       ? nearest
                       : rounding == Rounding::down ? std::floor(value * scale)
                                                    : std::ceil(value * scale);
  std::string word = fmt::format("{:.{}f}", whole / scale, decimals);
  word.erase(word.find_last_not_of('0') + 1);
  if (word.ends_with('.')) word += '0';
  return word == "-0.0" ? "0.0" : word;
}

std::vector<std::size_t> joints_that_are_axes(const UrdfFile& file, const UrdfRigChoices& choices,
                                              UrdfRig& rig) {
  const auto may_be_axis = [](const UrdfJoint& joint) {
    return joint.kind != UrdfJointKind::fixed && !joint.mimic;
  };
  std::vector<std::string_view> names;
  for (const UrdfJoint& joint : file.joints) {
    if (may_be_axis(joint)) names.push_back(joint.name);
  }
  for (const std::string& wanted : choices.joints) {
    if (std::ranges::find(names, wanted) != names.end()) continue;
    const auto meant = probably_meant(wanted, names);
    throw InputError({file.path},
                     meant ? fmt::format("no joint {} may be an axis; did you mean {}?", in_quotes(wanted),
                                         in_quotes(*meant))
                           : fmt::format("no joint {} may be an axis: one that moves and mimics no other; "
                                         "name one of those",
                                         in_quotes(wanted)));
  }
  std::vector<std::size_t> axes;
  for (std::size_t j = 0; j < file.joints.size(); ++j) {
    const UrdfJoint& joint = file.joints[j];
    if (!may_be_axis(joint)) continue;
    const bool is_wanted =
        choices.joints.empty() || std::ranges::find(choices.joints, joint.name) != choices.joints.end();
    if (!is_wanted) {
      rig.held.push_back(joint.name);
      continue;
    }
    if (axes.size() == max_rig_axes) {
      throw InputError(joint.place, fmt::format("{} joints move, and a rig has {} axes at most; name those "
                                                "that are axes with --axis JOINT, the others stay at rest",
                                                names.size(), max_rig_axes));
    }
    axes.push_back(j);
  }
  if (axes.empty()) throw InputError({file.path}, "no joint moves; name a file with one that does");
  return axes;
}

/// A line that is to be filled in.
std::string open_line(std::string_view field, std::string_view why, const UrdfJoint& joint, UrdfRig& rig) {
  rig.open.push_back(fmt::format("{}: {}", joint.name, field));
  return fmt::format("# {} = ?  {}\n", field, why);
}

std::string range_lines(const UrdfJoint& joint, const SimulatedUnit& unit, UrdfRig& rig) {
  if (!joint.limit) {
    const std::string min =
        open_line("min", "the joint turns without end; how far may this axis go?", joint, rig);
    return min + open_line("max", "as above", joint, rig);
  }
  const UrdfLimit& limit = *joint.limit;
  std::string text;
  if (!(limit.lower < limit.upper)) {
    const std::string why =
        fmt::format("the file has {} for both ends, line {}", limit.lower, limit.place.line);
    const std::string min = open_line("min", why, joint, rig);
    return min + open_line("max", why, joint, rig);
  }
  const auto line = [&](std::string_view field, double end, Rounding rounding) {
    if (std::fabs(end) > max_angle)
      return open_line(field, fmt::format("the file has {:g}, which is no end", end), joint, rig);
    return fmt::format("{} = {}\n", field, rounded_word(end * unit.per_base, unit.decimals, rounding));
  };
  const std::string min = line("min", limit.lower, Rounding::up);
  return min + line("max", limit.upper, Rounding::down);
}

std::string speed_lines(const UrdfJoint& joint, const SimulatedUnit& unit, const UrdfRigChoices& choices,
                        UrdfRig& rig) {
  const double velocity = joint.limit ? joint.limit->velocity * unit.per_base : 0;
  const std::string word = rounded_word(velocity, unit.decimals, Rounding::down);
  const bool is_known = velocity > 0 && velocity <= max_angle * unit.per_base && word != "0.0";
  std::string text;
  if (is_known) {
    text += fmt::format("max_velocity = {}\n", word);
  } else {
    text += open_line("max_velocity",
                      joint.limit ? fmt::format("{}/s; the file has {:g}, line {}", unit.word,
                                                joint.limit->velocity, joint.limit->place.line)
                                  : fmt::format("{}/s; the file does not say", unit.word),
                      joint, rig);
  }
  if (!is_known || !choices.reach_s) {
    text += open_line("max_acceleration", fmt::format("{}/s^2; no URDF file says it", unit.word), joint, rig);
    return text + fmt::format("# max_jerk = ?  {}/s^3, if it matters; no URDF file says it\n", unit.word);
  }
  text += fmt::format("max_acceleration = {}  # max_velocity in {:g} s, as was said when this was written\n",
                      rounded_word(velocity / *choices.reach_s, 3, Rounding::up), *choices.reach_s);
  return text + fmt::format("# max_jerk = ?  {}/s^3, if it matters; no URDF file says it\n", unit.word);
}

std::string axis_text(const UrdfJoint& joint, const UrdfRigChoices& choices, UrdfRig& rig) {
  if (joint.name.find_first_of(" \t") != std::string::npos) {
    throw InputError(joint.place, fmt::format("joint {} has a blank in its name, and a simulated axis has "
                                              "none; rename it in the file",
                                              in_quotes(joint.name)));
  }
  const SimulatedUnit unit = unit_for(joint, choices);
  std::string text = "\n[[axis]]\n";
  text += fmt::format("name = {}\nunit = \"{}\"\n", toml_quoted(joint.name), unit.word);
  text += range_lines(joint, unit, rig);
  text += speed_lines(joint, unit, choices, rig);
  text += fmt::format(R"(drive = {{ type = "pipe", path = "no-drive-yet", counts_per_unit = {:.1f} }})",
                      unit.counts_per_unit);
  rig.axes.push_back(joint.name);
  return text + "\n";
}

/// Whether an axis moves the link, by its own joint or one that it hangs on.
std::vector<bool> links_that_move(const UrdfFile& file, const std::set<std::size_t>& axes) {
  std::vector<bool> moves(file.links.size());
  for (std::size_t j = 0; j < file.joints.size(); ++j) {  // a parent comes before its links
    const UrdfJoint& joint = file.joints[j];
    std::size_t driver = j;
    while (file.joints[driver].mimic) driver = file.joints[driver].mimic->joint;
    moves[joint.child] = moves[joint.parent] || axes.contains(driver);
  }
  return moves;
}

std::string kinematics_text(const UrdfFile& file, const std::string& urdf, const std::set<std::size_t>& axes,
                            UrdfRig& rig) {
  std::vector<bool> is_end(file.links.size(), true);
  for (const UrdfJoint& joint : file.joints) is_end[joint.parent] = false;
  const std::vector<bool> moves = links_that_move(file, axes);
  std::vector<std::string> more;
  for (std::size_t link = 0; link < file.links.size(); ++link) {
    if (!is_end[link] || !moves[link]) continue;
    (rig.tips.size() < max_rig_tips ? rig.tips : more).push_back(file.links[link]);
  }
  std::string text =
      fmt::format("\n[kinematics]\nurdf = {}\ntip = {}\n", toml_quoted(urdf), toml_list(rig.tips));
  if (!more.empty()) {
    text += toml_comment(
        fmt::format("other ends, of which a rig shows {}: {}", max_rig_tips, comma_separated(more)));
  }
  if (!rig.held.empty()) {
    text += toml_comment("these joints are no axis and stay where they are: " + comma_separated(rig.held));
    text += toml_comment("at = { JOINT = VALUE } in rad or m puts them elsewhere");
  }
  return text;
}

}  // namespace

UrdfRig rig_of_urdf(const UrdfFile& file, const std::string& urdf, const UrdfRigChoices& choices) {
  UrdfRig rig;
  const std::vector<std::size_t> joints = joints_that_are_axes(file, choices, rig);
  std::string axes;
  for (const std::size_t j : joints) axes += axis_text(file.joints[j], choices, rig);
  const std::string kinematics = kinematics_text(file, urdf, {joints.begin(), joints.end()}, rig);
  rig.text = toml_comment("Made from " + file.path + ".");
  if (!rig.open.empty()) {
    rig.text += toml_comment(
        "Fill in every line that has = ? and remove its #: the maker's file does not say "
        "it, and without it this is no rig.");
  }
  rig.text +=
      toml_comment("The drives go nowhere, and only --sim runs them: write the real ones in their place.");
  rig.text += fmt::format("name = {}\nrate_hz = {}\n",
                          toml_quoted(std::filesystem::path(file.path).stem().string()), choices.rate_hz);
  rig.text += axes + kinematics;
  return rig;
}

}  // namespace inbetween
