#!/usr/bin/env bash
# The example firmware sends, tick by tick, the counts that `inbetween plan` computes for the same move and rig; one
# count may differ where a position is halfway between two.
#
#   firmware_test.sh TARGET FIRMWARE INBETWEEN
set -euo pipefail
here=$(dirname "${BASH_SOURCE[0]}")
target=$1 firmware=$2 inbetween=$3

sent=$("$here/on_target.sh" "$target" "$firmware") || {
  printf '%s\n' "$sent"
  printf 'FAILED: the firmware ended with status %d\n' $?
  exit 1
}
planned=$("$inbetween" plan examples/reveal.toml --rig examples/camera_rig.toml --per tick --csv - 2>/dev/null)
mapfile -t scales < <(sed --quiet 's/.*counts_per_unit = \([0-9.]*\).*/\1/p' examples/camera_rig.toml)

paste --delimiters=, <(tail --lines=+2 <<<"$planned") <(tr ' ' ',' <<<"$sent") |
  awk -F, -v scales="${scales[*]}" -v target="$target" '
    BEGIN { axes = split(scales, scale, " ") }
    NF != 2 + axes + 1 + axes || $1 != $(axes + 3) {
      printf "FAILED: line %d: %s\n", NR, $0
      exit failed = 1
    }
    {
      for (i = 1; i <= axes; ++i) {
        difference = $(axes + 3 + i) - $(2 + i) * scale[i]
        if (difference < 0) difference = -difference
        if (difference > 0.6) {
          printf "FAILED: tick %d, axis %d: %d counts are sent for %.3f\n", $1, i, $(axes + 3 + i), $(2 + i) * scale[i]
          exit failed = 1
        }
      }
    }
    END {
      if (failed) exit 1
      if (NR < 2000) {
        printf "FAILED: %d ticks\n", NR
        exit 1
      }
      printf "%d ticks of %d axes are as planned on %s\n", NR, axes, target
    }'
