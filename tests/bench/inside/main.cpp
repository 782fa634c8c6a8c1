// Every test of this program runs in the bench: started outside, the program starts itself again inside.
// ctest starts a suite at a time, and its tests share a bench. Tests whose suite is named ...OnVirtualTime
// need its other clock: they run if they alone are asked for, as ctest does.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/places.hpp"

namespace {

bool asks_for_virtual_time(int count, char** arguments) {
  for (int i = 1; i < count; ++i) {
    const std::string_view argument = arguments[i];
    if (argument.starts_with("--gtest_filter=") && argument.find("OnVirtualTime.") != argument.npos)
      return true;
  }
  return false;
}

[[noreturn]] void start_again_in_bench(int count, char** arguments) {
  std::vector<std::string> words = {inbetween::in_checkout("sim/bench/run"),
                                    "--kernel",
                                    "--timeout",
                                    "1000",
                                    "--echo",
                                    "--vcan",
                                    "can0",
                                    "--vcan",
                                    "can1"};
  if (asks_for_virtual_time(count, arguments)) words.emplace_back("--virtual-time");
  words.emplace_back("--");
  words.insert(words.end(), arguments, arguments + count);
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  ::execv(pointers.front(), pointers.data());
  std::perror(pointers.front());
  std::_Exit(125);
}

bool only_lists(int count, char** arguments) {
  for (int i = 1; i < count; ++i) {
    if (std::string_view(arguments[i]).starts_with("--gtest_list_tests")) return true;
  }
  return false;
}

}  // namespace

int main(int count, char** arguments) {
  if (std::getenv("INBETWEEN_IN_BENCH") == nullptr && !only_lists(count, arguments)) {
    start_again_in_bench(count, arguments);
  }
  ::testing::InitGoogleTest(&count, arguments);
  return RUN_ALL_TESTS();
}
