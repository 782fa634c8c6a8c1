#!/usr/bin/env bash
# The moves of table_report have the same bits on another processor as on this one, and as in `inbetween plan`.
#
#   same_report_test.sh TARGET PROGRAM HOST_PROGRAM INBETWEEN
set -euo pipefail
here=$(dirname "${BASH_SOURCE[0]}")
target=$1 program=$2 host_program=$3 inbetween=$4

expected=$("$here/on_target.sh" host "$host_program")
got=$("$here/on_target.sh" "$target" "$program") || {
  printf '%s\n' "$got"
  printf 'FAILED: the program ended with status %d on %s\n' $? "$target"
  exit 1
}
diff <(printf '%s\n' "$expected") <(printf '%s\n' "$got") || {
  printf 'FAILED: %s has other bits (>) than this machine (<)\n' "$target"
  exit 1
}

planned=$("$inbetween" plan examples/reveal.toml --json - 2>/dev/null |
  sed --quiet 's/.*"solver":"closed-form".*"hash":"\([0-9a-f]*\)".*/\1/p')
grep --quiet "^double reveal table $planned " <<<"$got" || {
  printf 'FAILED: the table of examples/reveal.toml is %s in the program, but on %s:\n' "$planned" "$target"
  grep '^double reveal' <<<"$got"
  exit 1
}
printf '%d lines are the same on %s\n' "$(wc --lines <<<"$got")" "$target"
