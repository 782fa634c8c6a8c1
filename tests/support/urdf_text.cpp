#include "tests/support/urdf_text.hpp"

#include <fmt/format.h>

#include <array>
#include <numbers>

namespace inbetween {
namespace {

double between(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

bool one_in(std::mt19937_64& random, int count) {
  return std::uniform_int_distribution<int>(1, count)(random) == 1;
}

std::string triple(std::mt19937_64& random, double reach) {
  return fmt::format("{} {} {}", between(random, -reach, reach), between(random, -reach, reach),
                     between(random, -reach, reach));
}

const char* mass(std::mt19937_64& random) {
  return one_in(random, 2) ? "<inertial><mass value=\"3\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" "
                             "iyz=\"0\" izz=\"1\"/></inertial>"
                           : "<visual><geometry><box size=\"1 2 3\"/></geometry></visual>";
}

}  // namespace

UrdfText random_urdf(std::mt19937_64& random, std::size_t moving) {
  UrdfText urdf;
  std::string links = "  <link name=\"base\"/>\n";
  std::string joints;
  std::string parent = "base";
  std::size_t driven = 0;
  for (int i = 0; driven < moving; ++i) {
    const bool is_fixed = one_in(random, 4);
    const bool mimics = !is_fixed && driven > 0 && one_in(random, 4);
    constexpr std::array types = {"revolute", "prismatic", "continuous"};
    UrdfTextJoint joint{.name = fmt::format("joint_{}", i),
                        .type = types.at(static_cast<std::size_t>(one_in(random, 3)) + one_in(random, 4)),
                        .lower = between(random, -3, -0.5),
                        .upper = between(random, 0.5, 3),
                        .mimics = mimics};
    const std::string link = fmt::format("link_{}", i);
    links += fmt::format("  <link name=\"{}\">{}</link>\n", link, mass(random));
    joints += fmt::format("  <joint name=\"{}\" type=\"{}\">\n", joint.name, is_fixed ? "fixed" : joint.type);
    joints += fmt::format("    <parent link=\"{}\"/>\n    <child link=\"{}\"/>\n", parent, link);
    if (!one_in(random, 5)) {
      joints += fmt::format("    <origin xyz=\"{}\" rpy=\"{}\"/>\n", triple(random, 2),
                            triple(random, std::numbers::pi));
    }
    if (!one_in(random, 4)) joints += fmt::format("    <axis xyz=\"{}\"/>\n", triple(random, 1));
    if (!is_fixed && joint.type != "continuous") {
      const double reach = mimics ? 100 : 1;  // whatever it follows
      joints += fmt::format("    <limit lower=\"{}\" upper=\"{}\" effort=\"10\" velocity=\"{}\"/>\n",
                            reach * joint.lower, reach * joint.upper, 10 * reach);
    }
    if (mimics) {
      joints += fmt::format("    <mimic joint=\"{}\" multiplier=\"{}\" offset=\"{}\"/>\n",
                            urdf.joints[urdf.joints.size() / 2].name, between(random, -2, 2),
                            between(random, -1, 1));
    }
    joints += "    <dynamics damping=\"0.1\" friction=\"0\"/>\n  </joint>\n";
    if (!is_fixed) {
      urdf.joints.push_back(joint);
      if (!mimics) ++driven;
    }
    urdf.tip = link;
    if (!one_in(random, 6)) parent = link;  // else a branch
  }
  urdf.text = "<?xml version=\"1.0\"?>\n<robot name=\"random arm\">\n" + links + joints + "</robot>\n";
  return urdf;
}

}  // namespace inbetween
