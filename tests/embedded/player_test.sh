#!/usr/bin/env bash
# A controller that plays a table of `inbetween plan --trajectory` sends, tick by tick, the counts that `inbetween run` sends to
# the drives: those of `inbetween plan --per tick`, rounded. Where its button is pressed it stops early, with the same bits as
# on this machine.
#
#   player_test.sh TARGET PROGRAMS HOST_PROGRAMS INBETWEEN
set -euo pipefail
here=$(dirname "${BASH_SOURCE[0]}")
target=$1 programs=$2 host_programs=$3 inbetween=$4

fail() {
  printf 'FAILED: %s\n' "$*"
  exit 1
}
played=$("$here/on_target.sh" "$target" "$programs/examples/firmware/play_table") ||
  fail "the player ended with status $?: $played"
pressed=$("$here/on_target.sh" "$target" "$programs/tests/embedded/target/play_table_pressed") ||
  fail "the stopped player ended with status $?: $pressed"
[[ $played == "$("$host_programs/play_table")" ]] || fail 'the counts are others than on this machine'
[[ $pressed == "$("$host_programs/play_table_pressed")" ]] || fail 'the counts of a stop are others than on this machine'

mapfile -t scales < <(sed --quiet 's/.*counts_per_unit = \([0-9.]*\).*/\1/p' examples/camera_rig.toml)
planned=$("$inbetween" plan examples/reveal.toml --rig examples/camera_rig.toml --per tick --csv - 2>/dev/null |
  awk -F, -v scales="${scales[*]}" '
    function floor(x) { return int(x) > x ? int(x) - 1 : int(x) }
    BEGIN { axes = split(scales, scale, " ") }
    NR > 1 {
      printf "%d", $1
      for (i = 1; i <= axes; ++i) printf " %d", floor($(2 + i) * scale[i] + 0.5)
      print ""
    }')
ticks=$(wc --lines <<<"$planned")
((ticks > 2000)) || fail "only $ticks ticks are planned"
[[ $played == "$planned" ]] || fail "$(diff <(printf '%s\n' "$planned") <(printf '%s\n' "$played") | head --lines=6)"

stopped=$(wc --lines <<<"$pressed")
((stopped > 710 && stopped < ticks)) || fail "a move of $ticks ticks that is stopped on tick 700 ends on tick $stopped"
[[ $(head --lines=701 <<<"$pressed") == "$(head --lines=701 <<<"$played")" ]] || fail 'the move is another before it is stopped'
printf '%d ticks of %d axes are as run on %s, and a stop takes %d ticks\n' \
  "$ticks" ${#scales[@]} "$target" $((stopped - 701))
