// Rigs of tests: what a test does not say about its rig does not matter to it.
#pragma once

#include <fmt/format.h>

#include <string>
#include <vector>

namespace inbetween {

struct AxisText {
  std::string name;
  std::string unit = "mm";
  double min = -100;
  double max = 200;
  double max_velocity = 150;
  double max_acceleration = 400;
  std::string more = "";  ///< further lines
  std::string drive = R"(type = "pipe", path = "/dev/null", counts_per_unit = 1)";
};

/// Where an axis may be, in its unit.
struct RangeText {
  double min = -100, max = 200;
};

/// How it may move, in its unit and seconds. A jerk of 0: none is said.
struct LimitsText {
  double velocity = 150;
  double acceleration = 400;
  double jerk = 0;
};

/// An axis of which the range and the limits matter.
inline AxisText axis_text(const std::string& name, const std::string& unit, RangeText range,
                          LimitsText limits = {}, const std::string& more = "",
                          const std::string& drive = AxisText{}.drive) {
  const std::string jerk = limits.jerk > 0 ? fmt::format("max_jerk = {}", limits.jerk) : "";
  return {.name = name,
          .unit = unit,
          .min = range.min,
          .max = range.max,
          .max_velocity = limits.velocity,
          .max_acceleration = limits.acceleration,
          .more = jerk + (jerk.empty() || more.empty() ? "" : "\n") + more,
          .drive = drive};
}

struct RigText {
  std::string name = "table";
  int rate_hz = 100;
  std::string more = "";  ///< lines before the axes, such as a bus
};

inline const std::string bus_can0 = "[bus.can0]\nbitrate = 1000000\n";

/// A drive on that bus.
inline std::string cia402_text(int node, double counts_per_unit = 1000) {
  return fmt::format(R"(type = "cia402", bus = "can0", node = {}, counts_per_unit = {})", node,
                     counts_per_unit);
}

/// The file of such a rig.
inline std::string rig_text(const std::vector<AxisText>& axes, const RigText& rig = {}) {
  std::string text = fmt::format("name = \"{}\"\nrate_hz = {}\n{}", rig.name, rig.rate_hz, rig.more);
  for (const AxisText& axis : axes) {
    text += fmt::format(
        "[[axis]]\nname = \"{}\"\nunit = \"{}\"\nmin = {}\nmax = {}\nmax_velocity = {}\nmax_acceleration = "
        "{}\n{}\ndrive = {{ {} }}\n",
        axis.name, axis.unit, axis.min, axis.max, axis.max_velocity, axis.max_acceleration, axis.more,
        axis.drive);
  }
  return text;
}

/// A head of two such drives on that bus; `more` are lines before its axes.
inline std::string pan_and_tilt_text(const std::string& more = "") {
  const auto axis = [](const char* name, int node) {
    return axis_text(name, "deg", {-90, 90}, {.velocity = 60, .acceleration = 120}, "unpowered = \"holds\"",
                     cia402_text(node));
  };
  return rig_text({axis("pan", 1), axis("tilt", 2)},
                  {.name = "head", .rate_hz = 250, .more = bus_can0 + more});
}

/// A stepper drive that somebody has told where it stands.
inline AxisText stepper_track() {
  return axis_text("track", "mm", {0, 500}, {.velocity = 250, .acceleration = 1000, .jerk = 20'000},
                   R"(reference = "operator")",
                   R"(type = "step-dir", chip = "gpio", step = 17, dir = 27, steps_per_unit = 40)");
}

}  // namespace inbetween
