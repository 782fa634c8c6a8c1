#!/usr/bin/env bash
# scripts/demo without what it installs and compiles: stand-ins for scripts/bootstrap and cmake, and the program of BUILD.
# The page is one of the things that a build makes, and the last line says how to open it.
#
#   demo_test.sh BUILD
set -euo pipefail
# shellcheck source=tests/support/expect.sh
source "${BASH_SOURCE[0]%/*}/../support/expect.sh"
build=$(realpath "$1")
scratch=$(mktemp --directory)
trap 'rm --recursive --force "$scratch"' EXIT

checkout=$scratch/checkout
mkdir --parents "$checkout/scripts" "$checkout/build/demo" "$scratch/bin"
cp scripts/demo "$checkout/scripts"
cp --recursive examples "$checkout"
ln --symbolic "$build/inbetween" "$checkout/build/demo/inbetween"
for command in "$checkout/scripts/bootstrap" "$scratch/bin/cmake"; do
  # shellcheck disable=SC2016  # expanded when the stand-in runs
  printf '#!/bin/sh\necho "${0##*/} $*" >>"%s/calls"\n' "$scratch" >"$command"
  chmod +x "$command"
done

said=$(PATH=$scratch/bin:$PATH "$checkout/scripts/demo" 2>&1) || { printf '%s\n' "$said"; exit 1; }
expect "it installs, configures and builds, once each" "bootstrap demo
cmake --preset demo
cmake --build --preset demo -- --quiet" "$(cat "$scratch/calls")"
expect "what is built has the page" 1 "$(ninja -C "$build" -t query editor/all | grep --count 'editor/inbetween_editor_page$')"

last=$(tail --lines=1 <<<"$said")
read -r -a opening <<<"${last#*: }"
expect "the last line says how to open it" "The same move in the browser, to be edited: build/demo/inbetween edit" \
  "$(grep --only-matching '^.*build/demo/inbetween edit' <<<"$last")"
# It serves until it is stopped; its second line comes when it does.
cd "$checkout"
exec 3< <(exec env XDG_STATE_HOME="$scratch/state" "${opening[@]}" --no-browser 2>&1)
editor=$!
read -r first <&3
kill "$editor"
expect "that opens it" "editing examples/reveal.toml at http://127.0.0.1" "${first%:*}"

all_was_as_expected 'the demo has the page'
