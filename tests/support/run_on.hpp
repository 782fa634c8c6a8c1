// Runs the built program on a move and a rig that a test has as texts.
#pragma once

#include <string>
#include <vector>

#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {

/// COMMAND move.toml --rig rig.toml MORE...
inline ProgramRun run_on(const std::string& rig, const std::string& command, const std::string& move,
                         const std::vector<std::string>& more = {}) {
  const TemporaryFile move_file("move.toml", move);
  const TemporaryFile rig_file("rig.toml", rig);
  std::vector<std::string> words = {command, move_file.path().string(), "--rig", rig_file.path().string()};
  words.insert(words.end(), more.begin(), more.end());
  return run_program(words);
}

}  // namespace inbetween
