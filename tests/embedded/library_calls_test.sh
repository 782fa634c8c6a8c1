#!/usr/bin/env bash
# The tick of counts calls nothing of a library, and on a Cortex-M7 the other ticks do not either; and library_calls.sh
# would see it: on a Cortex-M4F double precision is the library's.
#
#   library_calls_test.sh OBJDUMP CORTEX_M4F_PROGRAM CORTEX_M7_PROGRAM
set -euo pipefail
check=$(dirname "${BASH_SOURCE[0]}")/library_calls.sh
objdump=$1 m4f=$2 m7=$3
# Scaling by a power of two, on the way to the distance in a move timed by frames; a few integer instructions.
scaling='(frexp|ldexp|scalbn|copysign|finite)f?|__errno'
# The playhead counts in 64-bit integers, which the library divides and converts (to doubles by adding doubles), and
# copies what it travels with.
integers='__aeabi_([fd]2u?lz|l2[fd]|ldivmod|idiv0)|__udivmoddi4|mem(set|cpy)'

"$check" "$objdump" "$m4f" '' tick_trajectory_counts
"$check" "$objdump" "$m7" '' tick_trajectory_counts
"$check" "$objdump" "$m7" "$scaling" tick_positions
"$check" "$objdump" "$m7" "$scaling|$integers|__adddf3" tick_playhead
for function in tick_positions tick_playhead; do
  calls=$("$check" "$objdump" "$m4f" '' "$function") && {
    printf 'FAILED: %s passes, although the processor cannot add doubles\n' "$function"
    exit 1
  }
  grep --quiet 'calls __aeabi_d' <<<"$calls" || {
    printf 'FAILED: the arithmetic in double is not what is found in %s, but:\n%s\n' "$function" "$calls"
    exit 1
  }
done
if "$check" "$objdump" "$m4f" '' no_such_function 2>/dev/null; then
  printf 'FAILED: a function that is not there passes\n'
  exit 1
fi
printf 'the tick calls nothing outside the core\n'
