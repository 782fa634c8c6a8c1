#!/usr/bin/env bash
# Holds docs/walk.md to the tree. Every file that it links to exists. Of two neighbouring steps one includes the other (a
# header stands for the source of the same name too), or the later step says "meet in [...]" and that file includes
# both. What is no C++ file, such as a move, has no include lines. Prints what is wrong, and fails.
#
#   walk.sh ROOT
set -euo pipefail
cd "$1"
failures=0

fail() {
  printf 'docs/walk.md: error: %s\n' "$1"
  failures=$((failures + 1))
}

# includes FILE OTHER: whether FILE, or the source of the same name, has a line that includes OTHER.
includes() {
  local source=${1%.hpp}.cpp
  source=${source/firmware_core\/include\/inbetween/firmware_core\/src}
  grep --quiet --no-messages --fixed-strings --line-regexp \
    "#include \"${2#firmware_core/include/}\"" "$1" "$source"
}

while read -r file; do
  [[ -e $file ]] || fail "there is no $file; name the file that has taken its place"
done < <(grep --only-matching --extended-regexp '\]\(\.\./[^)]+\)' docs/walk.md | sed -E 's/^.*\.\.\/|\)$//g')

# A step goes from its number to the next number or heading; each becomes "FILE MEETING-PLACE".
steps=$(awk '
  function link(text) { sub(/^[^(]*\(\.\.\//, "", text); sub(/\).*/, "", text); return text }
  function give() { if (file != "") print file, meeting; file = meeting = "" }
  /^[0-9]+\. \[/ { give(); file = link($0) }
  /^$/ { give() }
  file != "" && /meet in \[/ { text = $0; sub(/.*meet in /, "", text); meeting = link(text) }
  END { give() }' docs/walk.md)
count=0
before=
while read -r file meeting; do
  count=$((count + 1))
  if [[ $before == *.?pp ]] && ! includes "$file" "$before" && ! includes "$before" "$file" &&
    ! { [[ -n $meeting ]] && includes "$meeting" "$before" && includes "$meeting" "$file"; }; then
    fail "$before and $file do not include one another; say in which file they meet, or name the file between them"
  fi
  before=$file
done <<<"$steps"
((count >= 10)) || fail "it has $count steps; a walk from a file to the wire has more"
exit $((failures > 0))
