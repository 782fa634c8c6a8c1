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
  std::vector<AxisText> axes;
  for (const char* name : {"pan", "tilt"}) {
    axes.push_back({.name = name,
                    .unit = "deg",
                    .min = -90,
                    .max = 90,
                    .max_velocity = 60,
                    .max_acceleration = 120,
                    .more = "unpowered = \"holds\"",
                    .drive = cia402_text(static_cast<int>(axes.size()) + 1)});
  }
  return rig_text(axes, {.name = "head", .rate_hz = 250, .more = bus_can0 + more});
}

/// A stepper drive that somebody has told where it stands.
inline AxisText stepper_track() {
  return {.name = "track",
          .min = 0,
          .max = 500,
          .max_velocity = 250,
          .max_acceleration = 1000,
          .more = "max_jerk = 20000\nreference = \"operator\"",
          .drive = R"(type = "step-dir", chip = "gpio", step = 17, dir = 27, steps_per_unit = 40)"};
}

}  // namespace inbetween
