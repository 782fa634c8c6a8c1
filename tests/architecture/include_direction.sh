#!/usr/bin/env bash
# Data flows one way: every #include line of the tree must point along the arrows of the README's map.
# Prints each line that does not, with the remedy, and fails.
#
#   include_direction.sh ROOT
set -euo pipefail
cd "$1"

folders=(firmware_core drivers sim host_tools editor tests)
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

  # Which folders a folder may look into, besides itself.
  sees["firmware_core"] = ""
  sees["drivers"] = " firmware_core "
  sees["sim"] = " firmware_core "
  sees["host_tools"] = " firmware_core drivers sim "
  sees["editor"] = " firmware_core "
  sees["tests"] = " firmware_core drivers sim host_tools editor "

  # Which rooms of the same folder a room may look into, besides itself: the lists of CMakeLists.txt.
  read_rooms("firmware_core")
  read_rooms("host_tools")
  read_pure_rooms()
}

# Reads the line "set(pure_rooms ROOM...)".
function read_pure_rooms(    line, names, i) {
  while ((getline line < "host_tools/CMakeLists.txt") > 0) {
    if (line !~ /^set\(pure_rooms [a-z_ ]+\)$/) continue
    gsub(/^set\(pure_rooms |\)$/, "", line)
    split(line, names, " ")
    for (i in names) pure["host_tools/" names[i]] = 1
  }
  close("host_tools/CMakeLists.txt")
}

# Reads the lines "add_core_room(ROOM ROOM...)" and "add_host_room(ROOM ROOM...)".
function read_rooms(folder,    line, room) {
  while ((getline line < (folder "/CMakeLists.txt")) > 0) {
    if (line !~ /^add_(core|host)_room\([a-z_ ]+\)$/) continue
    gsub(/^[^(]*\(|\)$/, "", line)
    room = line
    sub(/ .*/, "", room)
    sub(/^[^ ]* ?/, "", line)
    rooms[folder "/" room] = " " line " "
  }
  close(folder "/CMakeLists.txt")
}

function refuse(why) {
  printf "%s:%d: error: %s: %s\n", FILENAME, FNR, $0, why
  refused = 1
}

function exists(path,    ignored, there) {
  there = (getline ignored < path) >= 0
  close(path)
  return there
}

function beside(name,    path) {
  path = FILENAME
  sub(/[^\/]*$/, name, path)
  return exists(path)
}

# The room of a file or of a quoted include, such as "firmware_core/path"; empty where there is none.
function room_in(path) {
  sub(/^firmware_core\/(include\/inbetween|src)\//, "firmware_core/", path)
  sub(/^inbetween\//, "firmware_core/", path)
  if (path !~ /^(firmware_core|host_tools)\/[^\/]+\//) return ""
  match(path, /^[^\/]+\/[^\/]+/)
  return substr(path, 1, RLENGTH)
}

# The folder that a quoted include looks into; the core goes by its public name.
function folder_of(path) {
  if (path ~ /(^|\/)\.\.?\//) return ""
  if (path ~ /^inbetween\//) return "firmware_core"
  sub(/\/.*/, "", path)
  return path
}

/^[ \t]*#[ \t]*include/ {
  folder = FILENAME
  sub(/\/.*/, "", folder)
  oracle = FILENAME ~ /^tests\/support\/oracle_/
  line = $0
  sub(/^[ \t]*#[ \t]*include(_next)?[ \t]*/, "", line)

  if (match(line, /^<[^>]+>/)) {
    name = substr(line, 2, RLENGTH - 2)
    first = name
    sub(/\/.*/, "", first)
    if (first == "inbetween" || first in sees)
      refuse("a header of the project is included in quotes")
    else if (folder == "firmware_core" && !(name in free_standing))
      refuse("the core depends on nothing but the free-standing headers listed in include_direction.sh")
    next
  }
  if (!match(line, /^"[^"]+"/)) {
    refuse("an include must name its file, so that its direction can be seen")
    next
  }
  name = substr(line, 2, RLENGTH - 2)
  spelled = name
  target = folder_of(name)
  # What is private to the core lies beside its sources. It goes by its bare name in its own room and by "ROOM/NAME" in
  # another, so that the core compiles without the rest of the checkout.
  if (FILENAME ~ /^firmware_core\/src\//) {
    if (name !~ /\// && beside(name)) next
    if (("firmware_core/" name) ~ /^firmware_core\/[a-z]+\/[^\/]+$/ && exists("firmware_core/src/" name)) {
      name = "firmware_core/" name
      target = "firmware_core"
    }
  }
  # Tests see everything, the private parts of the core and the example firmware too.
  if (FILENAME ~ /^tests\// && FILENAME !~ /oracle_/ && name ~ /^(firmware_core\/src|examples\/firmware)\//) next
  if (spelled ~ /^firmware_core\//)
    refuse("the core is included by its public name, \"inbetween/...\"")
  else if (!(target in sees))
    refuse("a header of the project is included by its path from the root, e.g. \"host_tools/plan/plan.hpp\"; " \
           "any other in angle brackets")
  else if (oracle && name !~ /^tests\/support\/oracle_/)
    refuse("an oracle is independent: it may include oracle_* and the standard library only")
  else if (target != folder && index(sees[folder], " " target " ") == 0)
    refuse(folder " may not look into " target)
  else if (room_in(FILENAME) in pure && (target == "drivers" || target == "sim"))
    refuse(room_in(FILENAME) " computes, and may not look into " target)
  else {
    here = room_in(FILENAME)
    there = room_in(name)
    if (here == "" || target != folder || here == there) next
    name_there = there
    sub(/.*\//, "", name_there)
    if (!(here in rooms))
      refuse("the room " here " is not in its CMakeLists.txt; add it with what it may look into")
    else if (there == "" || index(rooms[here], " " name_there " ") == 0)
      refuse(here " may not look into " (there == "" ? name : there))
  }
}

END { exit refused }
' "${sources[@]}"
