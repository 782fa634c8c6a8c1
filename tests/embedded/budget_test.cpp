#include "host_tools/cli/budget.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <set>
#include <span>
#include <sstream>
#include <string>

#include "tests/support/places.hpp"

/// What scripts/measure-budget has measured against the limits that `inbetween budget` prints.

namespace inbetween {
namespace {

using Measured = std::map<std::string, double>;

/// Returns what was measured of one kind ("instructions", "stack", "program") on one target, by name.
Measured measured(const std::string& kind, const std::string& target) {
  std::ifstream file(in_build("tests/embedded/budget.txt"));
  Measured result;
  std::string line;
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::string line_kind;
    std::string line_target;
    std::string name;
    double number = 0;
    if (words >> line_kind >> line_target >> name >> number && line_kind == kind && line_target == target) {
      result[name] = number;
    }
  }
  return result;
}

void expect_kept(const Measured& numbers, const std::string& name, std::int32_t limit) {
  const auto found = numbers.find(name);
  ASSERT_NE(found, numbers.end()) << name << " has a limit, but is not measured";
  EXPECT_LE(found->second, limit) << name;
}

/// And whatever is measured has a limit.
void expect_all_kept(const std::string& kind, std::span<const FunctionBudget> limits) {
  for (const std::string target : {"cortex-m7", "cortex-m4f"}) {
    const Measured numbers = measured(kind, target);
    std::set<std::string> limited;
    for (const FunctionBudget& function : limits) {
      SCOPED_TRACE(kind + " on " + target);
      limited.insert(std::string(function.name));
      expect_kept(numbers, std::string(function.name),
                  target == "cortex-m7" ? function.cortex_m7 : function.cortex_m4f);
    }
    for (const auto& [name, number] : numbers) {
      EXPECT_EQ(limited.count(name), 1U) << name << " takes " << number << " and has no limit";
    }
  }
}

TEST(Budget, EveryFunctionKeepsToItsInstructions) {
  expect_all_kept("instructions", instruction_limits());
}

TEST(Budget, EveryFunctionKeepsToItsStack) {
  expect_all_kept("stack", stack_limits());
}

TEST(Budget, EveryProgramKeepsToItsBytes) {
  expect_all_kept("program", program_limits());
}

TEST(Budget, TheTickOfADriveIsAsQuickAsWasAskedFor) {
  EXPECT_LE(measured("instructions", "cortex-m4f").at("CountTrajectory::counts"), 130);
  EXPECT_LE(measured("instructions", "cortex-m7").at("CountTrajectory::counts"), 140);
}

}  // namespace
}  // namespace inbetween
