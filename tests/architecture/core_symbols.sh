#!/usr/bin/env bash
# What the core asks of the system it runs on: whatever its archives need from outside must be on the list
# below, so no heap, no exception, no clock, no output. Prints every other symbol and fails.
#
#   core_symbols.sh NM ARCHIVE...
set -euo pipefail
nm=$1
shift

# Memory that the compiler moves on its own account, the table of addresses of position-independent code, and
# those of <cmath> whose result IEEE 754 fixes to the last bit: sin or pow differ from one C library to the next,
# and the same move must give the same table on every target.
allowed='mem(cpy|move|set|cmp)|_GLOBAL_OFFSET_TABLE_'
allowed+='|(sqrt|fabs|floor|ceil|trunc|round|lround|llround|nearbyint|rint|lrint|llrint|fmod|remainder)[fl]?'
# What a processor has, so that the loader can choose among the clones of a function (processor_clones.hpp).
allowed+='|__cpu_(indicator_init|model|features2)'
allowed+='|(fma|fmin|fmax|copysign|nextafter|ldexp|scalbn|scalbln|frexp|logb|ilogb|modf)[fl]?'

symbols=$("$nm" --format=posix "$@")
[[ -n $symbols ]] || {
  printf '%s: error: no symbols in it; give the archives of the core\n' "$*" >&2
  exit 1
}

# Lines are "name type [value size]"; members of the archive are headed "archive[member.o]:".
outside=$(awk '$2 ~ /^[Uwv]$/ { needed[$1] = 1 } $2 ~ /^[A-TV-Ziu]$/ { defined[$1] = 1 }
               END { for (name in needed) if (!(name in defined)) print name }' <<<"$symbols" | sort)
forbidden=$(grep --invert-match --line-regexp --extended-regexp "$allowed|" <<<"$outside" || true)
[[ -z $forbidden ]] && exit

while read -r name; do
  printf '%s: error: the core needs %s, which is not among the symbols that it may; see %s\n' \
    "$*" "$(c++filt "$name")" "tests/architecture/core_symbols.sh"
done <<<"$forbidden"
exit 1
