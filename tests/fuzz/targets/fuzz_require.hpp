#pragma once

#include <cstdio>
#include <cstdlib>

/// What a fuzz target demands. A broken demand ends the program, which libFuzzer takes for a crash.
inline void fuzz_require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "fuzz: broken: %s\n", what);
  std::abort();
}
