#!/usr/bin/env bash
# Holds include_direction.sh to its word: each wrong include alone in a small tree must be refused with the
# right reason, each right one must pass.
set -euo pipefail
check=$(dirname "${BASH_SOURCE[0]}")/include_direction.sh
tree=$(mktemp --directory)
trap 'rm --recursive --force "$tree"' EXIT
failures=0

verdict_on() { # verdict_on FILE LINE
  rm --recursive --force "${tree:?}"/*
  mkdir --parents "$tree/$(dirname "$1")"
  printf 'int beside;\n' >"$tree/$(dirname "$1")/beside.hpp"
  mkdir --parents "$tree/firmware_core/src/path" "$tree/host_tools"
  printf 'int of_path_alone;\n' >"$tree/firmware_core/src/path/private.hpp"
  printf 'add_core_room(%s)\n' base 'path base' 'timing path base' >"$tree/firmware_core/CMakeLists.txt"
  printf 'set(pure_rooms plan fit)\n' >"$tree/host_tools/CMakeLists.txt"
  printf 'add_host_room(%s)\n' move_model 'plan move_model' 'rig move_model' 'motions rig plan move_model' >>"$tree/host_tools/CMakeLists.txt"
  printf '// A file of the tree.\n%s\nint x;\n' "$2" >"$tree/$1"
  bash "$check" "$tree" 2>&1
}

refuses() { # refuses REASON FILE LINE
  local verdict
  if verdict=$(verdict_on "$2" "$3"); then
    printf 'FAILED: %s may include %s\n' "$2" "$3"
  elif [[ $verdict != "$2:2: error: "*"$1"* ]]; then
    printf 'FAILED: %s with %s is refused for another reason: %s\n' "$2" "$3" "$verdict"
  else
    return 0
  fi
  failures=$((failures + 1))
}

allows() { # allows FILE LINE
  local verdict
  verdict=$(verdict_on "$1" "$2") && return
  printf 'FAILED: %s\n' "$verdict"
  failures=$((failures + 1))
}

core=firmware_core/include/inbetween/path/path.hpp
allows "$core" '#include <cmath>'
allows "$core" '#include "inbetween/base/result.hpp"'
allows "$core" '#include "inbetween/path/arc_length.hpp"'
allows "$core" '// #include <iostream>'
allows firmware_core/src/path/path.cpp '#include "beside.hpp"'
allows firmware_core/src/timing/track.cpp '#include "path/private.hpp"'
refuses 'path from the root' "$core" '#include "beside.hpp"'
refuses 'free-standing' "$core" '#include <vector>'
refuses 'free-standing' "$core" '#include <unistd.h>'
refuses 'free-standing' firmware_core/src/path/path.cpp '#  include <cstdio>  // for now'
refuses 'firmware_core may not look into host_tools' "$core" '#include "host_tools/plan/plan.hpp"'
refuses 'firmware_core may not look into sim' firmware_core/src/path/path.cpp '#include "sim/axis.hpp"'
refuses 'public name' firmware_core/src/path/path.cpp '#include "firmware_core/include/inbetween/path/path.hpp"'
refuses 'path from the root' firmware_core/src/path/path.cpp '#include "path.hpp"'
refuses 'path from the root' firmware_core/src/path/path.cpp '#include "inbetween/../../sim/axis.hpp"'
refuses 'in quotes' firmware_core/src/path/path.cpp '#include <inbetween/path/path.hpp>'
refuses 'must name its file' firmware_core/src/path/path.cpp '#include PATH_HEADER'

# Rooms.
refuses 'host_tools/plan computes, and may not look into sim' host_tools/plan/plan.cpp '#include "sim/axis.hpp"'
refuses 'host_tools/plan computes, and may not look into drivers' host_tools/plan/plan.hpp '#include "drivers/can/a.hpp"'
allows host_tools/rig/rig.cpp '#include "sim/axis.hpp"'
refuses 'firmware_core/path may not look into firmware_core/timing' "$core" '#include "inbetween/timing/track.hpp"'
refuses 'firmware_core/base may not look into firmware_core/path' firmware_core/src/base/cube_root.hpp \
  '#include "path/private.hpp"'
refuses 'firmware_core/path may not look into inbetween/path.hpp' "$core" '#include "inbetween/path.hpp"'
refuses 'firmware_core/attic is not in its CMakeLists.txt' firmware_core/include/inbetween/attic/old.hpp \
  '#include "inbetween/base/result.hpp"'
allows host_tools/plan/plan.cpp '#include "host_tools/move_model/move_file.hpp"'
allows host_tools/main.cpp '#include "host_tools/cli/command_line.hpp"'
refuses 'host_tools/move_model may not look into host_tools/plan' host_tools/move_model/move_file.cpp \
  '#include "host_tools/plan/plan.hpp"'
refuses 'host_tools/rig may not look into host_tools/plan' host_tools/rig/rig_drives.hpp \
  '#include "host_tools/plan/plan.hpp"'

allows drivers/linux/clock.cpp '#include <time.h>'
allows drivers/linux/clock.cpp '#include "inbetween/loop/ports.hpp"'
allows drivers/linux/clock.cpp '#include "drivers/linux/clock.hpp"'
refuses 'drivers may not look into sim' drivers/linux/clock.cpp '#include "sim/clock.hpp"'
refuses 'drivers may not look into host_tools' drivers/can/bus.cpp '#include "host_tools/rig_model/rig_file.hpp"'
allows sim/axis.cpp '#include "sim/axis.hpp"'
refuses 'sim may not look into drivers' sim/axis.cpp '#include "drivers/linux/clock.hpp"'
refuses 'sim may not look into tests' sim/axis.cpp '#include "tests/support/moves.hpp"'

allows host_tools/motions/run.cpp '#include "sim/axis.hpp"'
allows host_tools/motions/run.cpp '#include "drivers/linux/clock.hpp"'
allows host_tools/motions/run.cpp '#include <fmt/format.h>'
refuses 'host_tools may not look into tests' host_tools/motions/run.cpp '#include "tests/support/moves.hpp"'
refuses 'path from the root' host_tools/motions/run.cpp '#include "beside.hpp"'
refuses 'path from the root' host_tools/motions/run.cpp '#include "../sim/axis.hpp"'

allows editor/solver/session.cpp '#include "inbetween/path/path.hpp"'
refuses 'editor may not look into host_tools' editor/solver/session.cpp '#include "host_tools/plan/plan.hpp"'

allows tests/unit/run_test.cpp '#include "host_tools/motions/run.hpp"'
allows tests/support/oracle_length.cpp '#include "tests/support/oracle_length.hpp"'
allows tests/support/oracle_length.cpp '#include <vector>'
refuses 'an oracle is independent' tests/support/oracle_length.hpp '#include "inbetween/path/path.hpp"'
refuses 'an oracle is independent' tests/support/oracle_length.cpp '#include "tests/support/moves.hpp"'

rm --recursive --force "${tree:?}"/*
if bash "$check" "$tree" >/dev/null 2>&1; then
  printf 'FAILED: a tree without sources passes\n'
  failures=$((failures + 1))
fi

((failures == 0)) || exit 1
printf 'include_direction.sh: every sample judged rightly\n'
