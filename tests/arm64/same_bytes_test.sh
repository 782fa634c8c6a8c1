#!/usr/bin/env bash
# The program for 64-bit Arm, in QEMU, and that of this machine write the same bytes: what they print, what they say of a
# mistake, their files and their exit status.
#
#   same_bytes_test.sh ARM64_PROGRAM PROGRAM RIG      a rig, with every move that lies beside it
#   same_bytes_test.sh ARM64_PROGRAM PROGRAM          every move of the examples by itself
#
# A move that is not for the rig is refused, in the same words.
set -euo pipefail
root=$(cd "${BASH_SOURCE[0]%/*}/../.." && pwd)
arm64=("qemu-aarch64" "$(realpath "$1")")
here=("$(realpath "$2")")
rig=${3:-}

scratch=$(mktemp --directory)
trap 'rm --recursive --force "$scratch"' EXIT
# The program is run in either folder, and what it says and writes is beside the examples, in `written`.
mkdir "$scratch"/{here,arm64}
ln --symbolic "$root/examples" "$scratch/here/examples"
ln --symbolic "$root/examples" "$scratch/arm64/examples"
commands=0
moves=0

run_in() { # run_in FOLDER WORD...
  local status=0
  cd "$scratch/$1"
  rm --recursive --force written
  mkdir written
  "${@:2}" >written/out 2>written/err </dev/null || status=$?
  printf '%d\n' "$status" >written/status
}

# Runs a command of both programs and compares. Fails where this machine's program refuses it.
same() { # same ARGUMENT...
  commands=$((commands + 1))
  run_in here "${here[@]}" "$@"
  run_in arm64 "${arm64[@]}" "$@"
  diff --recursive "$scratch/here/written" "$scratch/arm64/written" >"$scratch/differences" || {
    printf 'FAILED: 64-bit Arm writes other bytes (>) than this machine (<): inbetween %s\n' "$*"
    head --lines=20 "$scratch/differences"
    exit 1
  }
  [[ $(cat "$scratch/here/written/status") == 0 ]]
}

must() { # must ARGUMENT...
  same "$@" || { printf 'FAILED: inbetween %s: %s\n' "$*" "$(head --lines=1 "$scratch/here/written/err")"; exit 1; }
}

moves_in() { # moves_in FOLDER DEPTH
  (cd "$root" && find "$1" -maxdepth "$2" -name '*.toml' -exec grep --files-with-matches --line-regexp '\[\[track\]\]' {} + | sort)
}

with_a_rig() {
  local move
  # The clock of the machine is the same for both; how late each wakes up is not asked.
  same doctor --rig "$rig" --seconds 0 --json written/doctor.json || true
  same home --rig "$rig" --sim --fast || true
  for move in $(moves_in "${rig%/*}" 1); do
    same plan "$move" --rig "$rig" --per tick --csv written/ticks.csv --json written/ticks.json || continue
    must plan "$move" --rig "$rig" --csv written/frames.csv --json written/frames.json
    same plan "$move" --rig "$rig" --trajectory written/table.h || true  # not of an axis that takes up its backlash
    must check "$move" --rig "$rig" --json written/check.json
    must run "$move" --rig "$rig" --sim --fast --record written/record.csv --json written/run.json
    moves=$((moves + 1))
  done
  ((moves > 0)) || { printf 'FAILED: no move was played on %s\n' "$rig"; exit 1; }
}

without_a_rig() {
  local move
  for move in $(moves_in examples 2); do
    # A move whose keys say where the tip of a rig is needs the rig; a timed one is not integrated.
    same plan "$move" --csv written/frames.csv --json written/frames.json || continue
    same plan "$move" --solver runge-kutta --csv written/frames.csv || true
    moves=$((moves + 1))
  done
  must budget
  must budget --keys 100 --axes 16 --control-values 40 --frames 5000
  must budget --delta 1e-4 --locks 3 --axes 8 --rate 500
  same doctor --seconds 0 --json written/doctor.json || true
  same --help
  same plan no_such_move.toml || true
}

if [[ -n $rig ]]; then with_a_rig; else without_a_rig; fi
printf '%d commands write the same bytes, with %d moves\n' "$commands" "$moves"
