#pragma once

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

namespace inbetween {

#ifdef INBETWEEN_SANITIZED
inline constexpr bool sanitized = true;
#else
inline constexpr bool sanitized = false;
#endif

/// All cases are run where the environment says INBETWEEN_CASES=all, as `scripts/test --long` does, a third
/// of them where it says `third`, as `--deep` does, else a tenth; under a sanitizer always a tenth.
inline bool runs_cases(std::string_view share) {
  const char* const cases = std::getenv("INBETWEEN_CASES");
  return !sanitized && cases != nullptr && cases == share;
}
inline bool runs_all_cases() {
  return runs_cases("all");
}

/// How many of `cases` are run.
inline int cases_to_run(int cases) {
  if (runs_all_cases()) return cases;
  return runs_cases("third") ? (cases + 2) / 3 : (cases + 9) / 10;
}

/// Whether a test may also count in how many of its cases something happened. Not in a share of them nor in a
/// replay: among so few, chance alone decides.
inline bool counts_mean_something() {
  return runs_all_cases() && std::getenv("RC_PARAMS") == nullptr;
}

/// The seed of a test is made of its name, so that a commit always gives the same answer. Where the
/// environment says INBETWEEN_SEEDS=new, as `scripts/test --search` does, it is a new one.
inline std::uint64_t seed_of(std::string_view name, std::uint64_t new_seed) {
  const char* const seeds = std::getenv("INBETWEEN_SEEDS");
  if (seeds != nullptr && std::string_view(seeds) == "new") return new_seed;
  std::uint64_t hash = 14'695'981'039'346'656'037U;  // FNV-1a
  for (const char letter : name) hash = (hash ^ static_cast<unsigned char>(letter)) * 1'099'511'628'211U;
  return hash;
}

/// Runs a RapidCheck property on `cases` random inputs, or on a tenth of them, and prints the seed, pass or
/// fail; RC_PARAMS in the environment ("seed=... max_success=...") replays a run. A
/// counterexample fails the test.
template <class Property>
void check_property(int cases, Property&& property) {
  const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
  rc::detail::TestMetadata metadata;
  metadata.id = std::string(test->test_suite_name()) + "/" + test->name();
  metadata.description = metadata.id;
  rc::detail::TestParams params = rc::detail::configuration().testParams;
  const char* replay = std::getenv("RC_PARAMS");
  if (replay == nullptr) params.seed = seed_of(metadata.id, params.seed);
  if (replay == nullptr || std::string_view(replay).find("max_success") == std::string_view::npos) {
    params.maxSuccess = cases_to_run(cases);
  }
  params.maxSize = 100;
  std::cout << metadata.id << ": seed=" << params.seed << ", cases: " << params.maxSuccess
            << (params.maxSuccess < cases ? " of " + std::to_string(cases) : "") << "\n";
  const rc::detail::TestResult result =
      rc::detail::checkTestable(std::forward<Property>(property), metadata, params);
  if (result.template is<rc::detail::SuccessResult>()) return;
  std::ostringstream message;
  rc::detail::printResultMessage(result, message);
  FAIL() << message.str() << "\nreplay with RC_PARAMS=\"seed=" << params.seed << "\"";
}

}  // namespace inbetween
