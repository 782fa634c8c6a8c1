// Runs commands in the bench (sim/bench).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tests/support/run_program.hpp"

namespace inbetween {

/// A bash script in the bench with these options. `until_true COMMAND...` waits for a condition; the time
/// limit of the bench is its bound.
inline ProgramRun script_in_bench(const std::vector<std::string>& options, std::string_view script) {
  std::vector<std::string> words = {INBETWEEN_SOURCE_DIR "/sim/bench/run"};
  words.insert(words.end(), options.begin(), options.end());
  const std::string whole = "until_true() { until \"$@\"; do sleep 0.01; done; }\n" + std::string(script);
  for (const char* word : {"--", "/bin/bash", "-euc"}) words.emplace_back(word);
  words.push_back(whole);
  return run_command(words);
}

}  // namespace inbetween
