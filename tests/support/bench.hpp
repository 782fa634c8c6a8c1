// Runs commands in the bench (sim/bench).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"

namespace inbetween {

/// The words of a command in the bench with these options.
inline std::vector<std::string> words_in_bench(const std::vector<std::string>& options,
                                               const std::vector<std::string>& command) {
  std::vector<std::string> words = {in_checkout("sim/bench/run")};
  words.insert(words.end(), options.begin(), options.end());
  words.emplace_back("--");
  words.insert(words.end(), command.begin(), command.end());
  return words;
}

inline ProgramRun in_bench(const std::vector<std::string>& options, const std::vector<std::string>& command) {
  return run_command(words_in_bench(options, command));
}

/// The words of a bash script there, which has `inbetween`, the programs of the tests and those of root as
/// commands. `until_true COMMAND...` waits for a condition; the time limit of the bench is its bound.
inline std::vector<std::string> script_words_in_bench(const std::vector<std::string>& options,
                                                      std::string_view script) {
  // It ends what hangs. A machine that is busy with something else takes many times as long as an idle one.
  std::vector<std::string> all{"--timeout", "1000"};
  all.insert(all.end(), options.begin(), options.end());
  const std::string whole = "PATH='" + in_build("") + "':'" + in_build("tests/bench") +
                            "':$PATH:/usr/sbin\nuntil_true() { until \"$@\"; do sleep 0.01; done; }\n" +
                            std::string(script);
  return words_in_bench(all, {"/bin/bash", "-euc", whole});
}

inline ProgramRun script_in_bench(const std::vector<std::string>& options, std::string_view script) {
  return run_command(script_words_in_bench(options, script));
}

}  // namespace inbetween
