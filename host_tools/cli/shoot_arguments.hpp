// The options of a command that shoots a move frame by frame.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/motions/shooting.hpp"

namespace inbetween {

struct ShootArguments {
  bool step = false;
  std::optional<double> settle;
  std::optional<double> exposure;
  std::optional<std::string> shutter;
  std::vector<std::string> still;
  std::optional<std::string> frames;  ///< --frames, which every run has
  std::optional<std::string> shoot_log;
  bool resume = false;

  [[nodiscard]] bool is_shot() const { return step || shutter; }
};

void add_shoot_options(CLI::App& command, ShootArguments& arguments);

/// What the arguments ask for; nothing without --step or --shutter. Throws UsageError where they contradict
/// each other.
std::optional<ShootOptions> shoot_options(const ShootArguments& arguments);

}  // namespace inbetween
