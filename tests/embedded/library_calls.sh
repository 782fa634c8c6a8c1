#!/usr/bin/env bash
# What functions of a program call, and what those call in turn: fails where that is anything but the core itself,
# such as the library's arithmetic in double precision on a processor that has none.
#
#   library_calls.sh OBJDUMP PROGRAM ALLOWED FUNCTION...
#
# ALLOWED is a regular expression of names that may be called besides, '' for none.
set -euo pipefail
objdump=$1 program=$2 allowed=$3
shift 3

"$objdump" --disassemble --no-show-raw-insn "$program" | awk -v roots="$*" -v allowed="^($allowed)\$" '
/^[0-9a-f]+ <.*>:$/ {
  function_name = $2
  gsub(/[<>:]/, "", function_name)
  there[function_name] = 1
  next
}
# A branch or call: "  9a4:  bmi.n  a2e <name+0x1e2>"; what has no name is a return or a call through a pointer.
$2 ~ /^(b|bl|blx|bx|b(eq|ne|cs|cc|mi|pl|vs|vc|hi|ls|ge|lt|gt|le)|cbn?z)(\.[nw])?$/ {
  if (match($0, /<[^>+]*/)) {
    to = substr($0, RSTART + 1, RLENGTH - 1)
    if (to != function_name) calls[function_name] = calls[function_name] " " to
  } else if ($2 == "blx" || ($2 == "bx" && $3 != "lr")) {
    calls[function_name] = calls[function_name] " (a-pointer)"
  }
}
END {
  count = split(roots, queue, " ")
  for (i = 1; i <= count; ++i) {
    if (!(queue[i] in there)) {
      print "library_calls.sh: error: there is no function " queue[i] > "/dev/stderr"
      exit 2
    }
    reached[queue[i]] = 1
  }
  for (i = 1; i <= count; ++i) {
    callee_count = split(calls[queue[i]], callees, " ")
    for (j = 1; j <= callee_count; ++j) {
      to = callees[j]
      if (to in reached) continue
      reached[to] = 1
      if (to ~ /^_ZNK?9inbetween/ || to ~ allowed) {
        queue[++count] = to
      } else {
        printf "%s calls %s\n", queue[i], to
        refused = 1
      }
    }
  }
  exit refused
}'
