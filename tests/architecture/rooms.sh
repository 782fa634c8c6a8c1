#!/usr/bin/env bash
# Every room of the core and of the host tools is known: a line of CMakeLists.txt makes it, and its README.md says what
# lives there and, in the same words as CMakeLists.txt, what it may look into. Prints what is wrong, and fails.
#
#   rooms.sh ROOT
set -euo pipefail
cd "$1"
failures=0

fail() {
  printf '%s: error: %s\n' "$1" "$2"
  failures=$((failures + 1))
}

# rooms_of FOLDER MACRO README_FOLDER SOURCE_FOLDER...: checks each room, and each subfolder of SOURCE_FOLDER.
rooms_of() {
  local folder=$1 macro=$2 readmes=$3
  shift 3
  local lines line room seen readme said
  lines=$(sed -nE "s/^$macro\(([a-z_ ]+)\)\$/\1/p" "$folder/CMakeLists.txt")
  [[ -n $lines ]] || fail "$folder/CMakeLists.txt" "no line $macro(ROOM ...)"
  [[ -f $folder/README.md ]] || fail "$folder/README.md" 'there is none; say what the rooms are for'
  while read -r room seen; do
    readme=$readmes/$room/README.md
    seen=${seen// /, }
    if [[ ! -f $readme ]]; then
      fail "$readme" 'there is none; say what lives in the room, what it may look into, and where to begin'
      continue
    fi
    said=$(sed -nE 's/^May look into: (.*)\.$/\1/p' "$readme")
    [[ $said == "${seen:-nothing}" ]] ||
      fail "$readme" "it has no line \"May look into: ${seen:-nothing}.\", which is what $folder/CMakeLists.txt says"
    grep --quiet '^Begin with ' "$readme" || fail "$readme" 'it has no line "Begin with ..."'
    grep --quiet --fixed-strings "]($readmes/$room)" <(sed "s|](|]($folder/|g" "$folder/README.md" 2>/dev/null) ||
      fail "$folder/README.md" "it does not name the room $room"
  done <<<"$lines"
  while read -r line; do
    room=${line##*/}
    grep --quiet --extended-regexp "^$room( |\$)" <<<"$lines" ||
      fail "$line" "no line $macro($room ...) in $folder/CMakeLists.txt makes this folder a room"
  done < <(find "$@" -mindepth 1 -maxdepth 1 -type d | sort)
}

rooms_of firmware_core add_core_room firmware_core/include/inbetween firmware_core/include/inbetween firmware_core/src
rooms_of host_tools add_host_room host_tools host_tools
exit $((failures > 0))
