#!/usr/bin/env bash
# Holds rooms.sh, walk.sh and constants.sh to their word: a copy of the tree passes, and each wrong change alone is
# refused with the right reason.
#
#   rooms_test.sh ROOT
set -euo pipefail
root=$1
scripts=$root/tests/architecture
tree=$(mktemp --directory)
trap 'rm --recursive --force "$tree"' EXIT
failures=0

fresh_tree() {
  rm --recursive --force "${tree:?}"/*
  cp --recursive "$root"/{firmware_core,host_tools,drivers,sim,docs,examples} "$tree"
  mkdir --parents "$tree/editor/page"
  cp --recursive "$root/editor/solver" "$tree/editor"
  cp --recursive "$root/editor/page/src" "$tree/editor/page"
}

# refuses SCRIPT REASON COMMAND...: COMMAND makes the change, from the root of the copy.
refuses() {
  local script=$1 reason=$2 verdict
  shift 2
  fresh_tree
  (cd "$tree" && "$@")
  if verdict=$(bash "$scripts/$script" "$tree" 2>&1); then
    printf 'FAILED: %s passes after: %s\n' "$script" "$*"
  elif [[ $verdict != *"$reason"* ]]; then
    printf 'FAILED: %s refuses "%s" for another reason: %s\n' "$script" "$*" "$verdict"
  else
    return 0
  fi
  failures=$((failures + 1))
}

fresh_tree
bash "$scripts/rooms.sh" "$tree" || failures=$((failures + 1))
bash "$scripts/walk.sh" "$tree" || failures=$((failures + 1))
bash "$scripts/constants.sh" "$tree" || failures=$((failures + 1))

core=firmware_core/include/inbetween
refuses rooms.sh "$core/path/README.md: error: there is none" rm $core/path/README.md
refuses rooms.sh 'no line "May look into: base."' sed -i 's/into: base/into: base, timing/' $core/path/README.md
refuses rooms.sh 'no line "May look into: plot, joints, numerics, move_model, rig_model, text."' sed -i '/^May look/d' host_tools/plan/README.md
refuses rooms.sh 'no line "May look into: nothing."' sed -i 's/into: nothing/into: path/' $core/base/README.md
refuses rooms.sh 'no line "Begin with ..."' sed -i 's/^Begin with/See/' host_tools/cli/README.md
refuses rooms.sh 'no line "May look into: path, timing, base."' \
  sed -i 's/^add_core_room(timing path base)/add_core_room(timing path timing base)/' firmware_core/CMakeLists.txt
refuses rooms.sh 'no line add_core_room(path ...)' sed -i '/^add_core_room(path /d' firmware_core/CMakeLists.txt
refuses rooms.sh 'no line add_host_room(attic ...)' mkdir host_tools/attic
refuses rooms.sh 'no line add_core_room(attic ...)' mkdir firmware_core/src/attic
refuses rooms.sh 'it does not name the room fit' sed -i '/(fit)/d' host_tools/README.md
refuses rooms.sh 'no line add_host_room(ROOM ...)' sed -i '/^add_host_room/d' host_tools/CMakeLists.txt

refuses walk.sh 'there is no host_tools/plan/plan.hpp' rm host_tools/plan/plan.hpp
refuses walk.sh 'arc_length.hpp and firmware_core/include/inbetween/timing/speed_profile.hpp do not include' \
  sed -i '/meet in \[/d' docs/walk.md
refuses walk.sh 'cia402.hpp and firmware_core/include/inbetween/can/frame.hpp do not include' \
  sed -i '/can\/frame.hpp/d' $core/can/cia402.hpp
# shellcheck disable=SC2016  # $d is sed's last line
refuses walk.sh 'a walk from a file to the wire has more' sed -i '/^9\./,$d' docs/walk.md

refuses constants.sh 'error: first_margin has no comment' \
  sed -i 's/^constexpr double first_margin/\n&/' host_tools/fit/speed_fit.cpp
refuses constants.sh 'plan/near_keys.hpp:1: error: limit has no comment' \
  sed -i '1iinline constexpr std::int32_t limit{7};' host_tools/plan/near_keys.hpp
refuses constants.sh 'no constant was found' \
  sed -i 's/^\(inline \)\?constexpr //' host_tools/{fit,plan,joints,numerics}/*.[ch]pp

((failures == 0)) || exit 1
printf 'rooms.sh, walk.sh, constants.sh: every sample judged rightly\n'
