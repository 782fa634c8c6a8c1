#!/usr/bin/env bash
# A document is true: its commands run and write the files that they name, its links lead somewhere.
#
#   readme_test.sh ROOT PROGRAM [DOCUMENT]      README.md if no other is named
#
# In a scratch folder that looks like the checkout after scripts/demo: a toml block whose first line is a
# comment with a file name is saved under it, every line of an sh block that calls build/demo/inbetween is run.
# A script of the project is not run (it would run this test), but it must be there and be a script.
set -euo pipefail
root=$1 program=$2 document=${3:-README.md}
readme=$root/$document

scratch=$(mktemp --directory)
trap 'rm --recursive --force "$scratch"' EXIT
mkdir --parents "$scratch/build/demo"
ln --symbolic "$program" "$scratch/build/demo/inbetween"
ln --symbolic "$root/examples" "$scratch/examples"
PATH=$scratch/build/demo:$PATH
cd "$scratch"

failures=0
failed() {
  printf '%s: error: %s\n' "$document" "$*"
  failures=$((failures + 1))
}

blocks_of() { # blocks_of LANGUAGE: the lines of its fenced blocks
  awk -v fence="\`\`\`$1" '$0 == "```" { inside = 0 } inside; $0 == fence { inside = 1 }' "$readme"
}

save_files() {
  local line file=''
  while IFS= read -r line; do
    [[ ! $line =~ ^#\ ([a-z_]+\.toml)$ ]] || file=${BASH_REMATCH[1]}
    [[ -n $file ]] || { failed "a toml block begins with a comment that names its file, not with: $line"; return; }
    printf '%s\n' "$line" >>"$file"
  done < <(blocks_of toml)
}

run_line() {
  local words option
  read -r -a words <<<"${1%%#*}"
  if [[ ${words[0]} == scripts/* ]]; then
    if [[ ! -x $root/${words[0]} ]] || ! bash -n "$root/${words[0]}"; then
      failed "not a script that can be run: ${words[0]}"
    fi
    return
  fi
  [[ ${words[0]} =~ ^(build/demo/)?inbetween$ ]] || { failed "no way to check this command: $1"; return; }
  local status=0
  bash -c "$1" >output 2>&1 </dev/null || status=$?
  # A page may show how a move is refused.
  if ((status == 3)) && [[ ${words[1]} == check ]] && grep --quiet ' would do' output; then return; fi
  ((status == 0)) || { failed "status $status of: $1"; cat output; return; }
  for ((option = 1; option < ${#words[@]} - 1; ++option)); do
    [[ ! ${words[option]} =~ ^--(plot|csv|json|to)$ || ${words[option + 1]} == - || -s ${words[option + 1]} ]] ||
      failed "wrote no ${words[option + 1]}: $1"
  done
}

save_files
commands=0
while IFS= read -r line; do
  [[ -n $line ]] || continue
  commands=$((commands + 1))
  run_line "$line"
done < <(blocks_of sh)
((commands > 0)) || failed "shows no command in an sh block"

links=0
while IFS= read -r link; do
  links=$((links + 1))
  [[ -e ${readme%/*}/$link ]] || failed "links to $link, which is not there"
done < <(grep --only-matching --perl-regexp '\]\(\K[^)#:]+(?=\))' "$readme")
((links > 0)) || failed "has no link and no picture"

((failures == 0)) || exit 1
printf '%s: %d commands and %d links are true\n' "$document" "$commands" "$links"
