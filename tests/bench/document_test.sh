#!/usr/bin/env bash
# Every command that docs/bench.md shows for the bench runs to its end.
#
#   document_test.sh PROGRAM_OF_INBETWEEN
set -euo pipefail

failures=0
commands=0

try() { # try COMMAND
  commands=$((commands + 1))
  bash -c "${1//build\/release\/inbetween/\"$program\"}" >/dev/null && return
  printf 'FAILED: %s\n' "$1"
  failures=$((failures + 1))
}

program=$1
command=
while IFS= read -r line <&3 || [[ -n $line ]]; do
  if [[ $line == "    "* ]]; then
    command+=${line#    }$'\n'
  else
    if [[ $command == *sim/bench/run* ]]; then try "$command"; fi
    command=
  fi
done 3<docs/bench.md

((commands >= 4)) || { printf 'only %d commands were found in docs/bench.md\n' "$commands"; exit 1; }
((failures == 0)) || exit 1
printf 'docs/bench.md: %d commands ran\n' "$commands"
