#!/usr/bin/env bash
# Holds core_symbols.sh to its word: compiles one small sample after the other into an archive of its own; each
# that asks for an operating system must be refused by the name of the symbol, the others must pass.
#
#   core_symbols_test.sh CXX AR NM
set -euo pipefail
check=$(dirname "${BASH_SOURCE[0]}")/core_symbols.sh
cxx=$1 ar=$2 nm=$3
scratch=$(mktemp --directory)
trap 'rm --recursive --force "$scratch"' EXIT
failures=0

verdict_on() { # verdict_on CODE...: one member of the archive for each
  local code members=()
  rm --force "$scratch"/*
  for code in "$@"; do
    printf '%s\n' "$code" |
      "$cxx" -std=c++20 -O1 -x c++ -c - -o "$scratch/member_${#members[@]}.o"
    members+=("$scratch/member_${#members[@]}.o")
  done
  "$ar" rcs "$scratch/sample.a" "${members[@]}"
  bash "$check" "$nm" "$scratch/sample.a" 2>&1
}

refuses() { # refuses SYMBOL CODE
  local verdict
  if verdict=$(verdict_on "$2"); then
    printf 'FAILED: passes, although it needs %s: %s\n' "$1" "$2"
  elif [[ $verdict != *"the core needs $1"* ]]; then
    printf 'FAILED: %s is not named for %s, but: %s\n' "$1" "$2" "$verdict"
  else
    return 0
  fi
  failures=$((failures + 1))
}

allows() { # allows CODE...
  local verdict
  verdict=$(verdict_on "$@") && return
  printf 'FAILED: %s\n' "$verdict"
  failures=$((failures + 1))
}

allows 'int twice(int x) { return 2 * x; }'
allows '#include <cmath>
double f(double x) { return std::sqrt(x) + std::floor(x) + std::ldexp(x, 3) + std::fmod(x, 2.0); }' \
  '#include <cstring>
void copy(void* to, const void* from, unsigned long n) { std::memcpy(to, from, n); }'
allows 'int twice(int); int four_times(int x) { return twice(twice(x)); }' 'int twice(int x) { return 2 * x; }'

allows '#ifdef __x86_64__
__attribute__((target_clones("avx2", "default")))
#endif
int twice(int x) { return 2 * x; }' 'int twice(int); int four_times(int x) { return twice(twice(x)); }'

refuses malloc '#include <cstdlib>
void* f(unsigned long n) { return std::malloc(n); }'
refuses 'operator new' 'int* f() { return new int(1); }'
refuses 'operator delete' 'void f(int* p) { delete p; }'
refuses '__cxa_throw' 'void f() { throw 1; }'
refuses '__cxa_guard_acquire' 'int g(); int f() { static int x = g(); return x; }'
refuses '__cxa_pure_virtual' 'struct A { virtual void f() = 0; A(); }; A::A() {}'
refuses '__gxx_personality_v0' 'struct A { ~A(); }; void g(); void f() { A a; g(); }'
refuses 'std::terminate' '#include <exception>
void f() { std::terminate(); }'
refuses 'std::__throw_' '#include <array>
int f(const std::array<int, 3>& x, unsigned long i) { return x.at(i); }'
refuses printf '#include <cstdio>
void f(int x) { std::printf("%d", x); }'
refuses clock_gettime '#include <time.h>
long f() { timespec t; clock_gettime(CLOCK_MONOTONIC, &t); return t.tv_nsec; }'
refuses pthread '#include <pthread.h>
void f(pthread_mutex_t* m) { pthread_mutex_lock(m); }'
refuses abort '#include <cstdlib>
void f() { std::abort(); }'
refuses sin '#include <cmath>
double f(double x) { return std::sin(x); }'
refuses elsewhere 'int elsewhere(int) __attribute__((weak)); int f() { return elsewhere(1); }'
refuses elsewhere 'int elsewhere(int); int f() { return elsewhere(1); }'

"$ar" rcs "$scratch/empty.a"
for nothing in "$scratch/empty.a" "$scratch/absent.a"; do
  if bash "$check" "$nm" "$nothing" >/dev/null 2>&1; then
    printf 'FAILED: %s passes\n' "$nothing"
    failures=$((failures + 1))
  fi
done

((failures == 0)) || exit 1
printf 'core_symbols.sh: every sample judged rightly\n'
