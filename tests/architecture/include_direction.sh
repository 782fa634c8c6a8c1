#!/usr/bin/env bash
# Data flows one way: every #include line of the tree must point along the arrows of the README's map.
# Prints each line that does not, with the remedy, and fails.
#
#   include_direction.sh ROOT
set -euo pipefail
cd "$1"

folders=(firmware_core drivers sim host_tools tests)
mapfile -t sources < <(find "${folders[@]}" -type f \( -name '*.[ch]pp' -o -name '*.[chS]' \) 2>/dev/null | sort)
((${#sources[@]})) || {
  printf '%s: error: no sources in %s; name the root of the checkout\n' "$0" "$1" >&2
  exit 1
}

awk '
BEGIN {
  # The part of the standard library that needs no operating system and no heap.
  split("algorithm array bit cmath compare concepts cstddef cstdint initializer_list limits new numbers" \
        " numeric optional span tuple type_traits utility", names)
  for (i in names) free_standing[names[i]] = 1

  # Which rooms a room may look into, besides itself.
  sees["firmware_core"] = ""
  sees["drivers"] = " firmware_core "
  sees["sim"] = " firmware_core "
  sees["host_tools"] = " firmware_core drivers sim "
  sees["tests"] = " firmware_core drivers sim host_tools "
}

function refuse(why) {
  printf "%s:%d: error: %s: %s\n", FILENAME, FNR, $0, why
  refused = 1
}

function beside(name,    path, ignored, there) {
  path = FILENAME
  sub(/[^\/]*$/, name, path)
  there = (getline ignored < path) >= 0
  close(path)
  return there
}

# The room that a quoted include looks into; the core goes by its public name.
function room_of(path) {
  if (path ~ /(^|\/)\.\.?\//) return ""
  if (path ~ /^inbetween\//) return "firmware_core"
  sub(/\/.*/, "", path)
  return path
}

/^[ \t]*#[ \t]*include/ {
  room = FILENAME
  sub(/\/.*/, "", room)
  oracle = FILENAME ~ /^tests\/support\/oracle_/
  line = $0
  sub(/^[ \t]*#[ \t]*include(_next)?[ \t]*/, "", line)

  if (match(line, /^<[^>]+>/)) {
    name = substr(line, 2, RLENGTH - 2)
    first = name
    sub(/\/.*/, "", first)
    if (first == "inbetween" || first in sees)
      refuse("a header of the project is included in quotes")
    else if (room == "firmware_core" && !(name in free_standing))
      refuse("the core depends on nothing but the free-standing headers listed in include_direction.sh")
    next
  }
  if (!match(line, /^"[^"]+"/)) {
    refuse("an include must name its file, so that its direction can be seen")
    next
  }
  name = substr(line, 2, RLENGTH - 2)
  target = room_of(name)
  # What is private to the core lies beside its sources and goes by its bare name, so that the core compiles
  # without the rest of the checkout.
  if (FILENAME ~ /^firmware_core\/src\// && name !~ /\// && beside(name)) next
  # Tests see everything, the private parts of the core and the example firmware too.
  if (FILENAME ~ /^tests\// && FILENAME !~ /oracle_/ && name ~ /^(firmware_core\/src|examples\/firmware)\//) next
  if (name ~ /^firmware_core\//)
    refuse("the core is included by its public name, \"inbetween/...\"")
  else if (!(target in sees))
    refuse("a header of the project is included by its path from the root, e.g. \"host_tools/plan.hpp\"; " \
           "any other in angle brackets")
  else if (oracle && name !~ /^tests\/support\/oracle_/)
    refuse("an oracle is independent: it may include oracle_* and the standard library only")
  else if (target != room && index(sees[room], " " target " ") == 0)
    refuse(room " may not look into " target)
}

END { exit refused }
' "${sources[@]}"
