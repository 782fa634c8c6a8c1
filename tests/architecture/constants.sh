#!/usr/bin/env bash
# Every number that fit, plan, joints and numerics name in a namespace has a comment above or behind it, which says why the number
# has this size. Whether the reason is a good one is for a reader. Prints the names without one, and fails.
#
#   constants.sh ROOT
set -euo pipefail
cd "$1"
mapfile -t files < <(find host_tools/{fit,plan,joints,numerics} -name '*.[ch]pp' | sort)
awk '
  FNR == 1 { has_comment = 0 }
  /^(inline |static )?constexpr (int|float|double|auto|std::size_t|std::u?int[0-9]+_t) [a-z_0-9]+( =|\{)/ {
    count++
    if (!has_comment && $0 !~ /\/\//) {
      name = $0
      sub(/( =|\{).*/, "", name)
      sub(/.* /, "", name)
      printf "%s:%d: error: %s has no comment; say above it why it has this size, and which test holds it\n",
        FILENAME, FNR, name
      missing++
    }
  }
  { has_comment = /^ *\/\// }
  END {
    if (count == 0) print "host_tools: error: no constant was found; does this script still know how they are written?"
    exit missing > 0 || count == 0
  }' "${files[@]}"
