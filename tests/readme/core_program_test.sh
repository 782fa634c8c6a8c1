#!/usr/bin/env bash
# The program in firmware_core/README.md compiles as it stands there, and prints what stands behind it.
#
#   core_program_test.sh ROOT CXX ARCHIVE...
set -euo pipefail
readme=$1/firmware_core/README.md cxx=$2
include=$1/firmware_core/include
shift 2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# The first block of a language.
block() {
  awk -v begin="\`\`\`$1" '$0 == begin && !done { inside = 1; next } /^```$/ && inside { inside = 0; done = 1 } inside' "$readme"
}

block cpp >"$scratch/program.cpp"
block text >"$scratch/expected"
[[ -s $scratch/program.cpp && -s $scratch/expected ]] || { printf '%s has no program, or not what it prints\n' "$readme"; exit 1; }
"$cxx" -std=c++20 -Wall -Wextra -Wshadow -Wconversion -Werror -I"$include" "$scratch/program.cpp" \
  -Wl,--start-group "$@" -Wl,--end-group -o "$scratch/program"
"$scratch/program" >"$scratch/printed"
diff "$scratch/expected" "$scratch/printed"
