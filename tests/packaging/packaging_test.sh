#!/usr/bin/env bash
# Installs the program, makes the Debian package, and tries what comes with it.
#
#   packaging_test.sh BUILD [ARCHITECTURE EMULATOR]      of another processor, as Debian calls it, and what runs its programs
set -euo pipefail
# shellcheck source=tests/support/expect.sh
source "${BASH_SOURCE[0]%/*}/../support/expect.sh"

build=$(realpath "$1")
architecture=${2:-$(dpkg --print-architecture)}
emulator=${3:-}
root=$PWD
scratch=$(mktemp --directory)
trap 'rm --recursive --force "$scratch"' EXIT

cmake --install "$build" --prefix "$scratch/usr" >"$scratch/said" || { cat "$scratch/said"; exit 1; }
if [[ -n $emulator ]]; then
  mkdir "$scratch/run"
  printf '#!/bin/sh\nexec %s %s "$@"\n' "$emulator" "$scratch/usr/bin/inbetween" >"$scratch/run/inbetween"
  chmod +x "$scratch/run/inbetween"
  PATH=$scratch/run:$PATH
else
  PATH=$scratch/usr/bin:$PATH
fi
commands=$(inbetween --help | sed --quiet '/^Subcommands:/,/^$/s/^  \([a-z-]*\) .*/\1/p')

# --- the start ---
expect "no shared library of C++ is loaded, which takes longer than the whole start" '' \
  "$(readelf --dynamic "$scratch/usr/bin/inbetween" | grep --only-matching --extended-regexp 'lib(stdc|fmt|toml)[^]]*' || true)"

# --- the manual ---
pages=$(cd "$scratch/usr/share/man/man1" && ls)
expect "a page for the program and for each command" \
  "$(printf '%s\n' inbetween "$commands" | sort)" "$(sed 's/^inbetween-//; s/\.1$//' <<<"$pages" | sort)"
grep --quiet '\\-\\-shutter' "$scratch/usr/share/man/man1/inbetween-run.1" || expect "a page names the options" yes no
for page in $pages; do
  expect "$page has a line for whatis" 1 \
    "$(grep --count '^inbetween.* \\- [A-Za-z]' "$scratch/usr/share/man/man1/$page")"
done
for command in $commands; do
  expect "each example of $command is a line of its page" \
    "$(inbetween "$command" --help | sed --quiet '/^Examples:$/,$s/^  //p')" \
    "$(sed --quiet '/^\.nf$/,/^\.fi$/{//d; s/\\-/-/g; s/\\e/\\/g; p}' "$scratch/usr/share/man/man1/inbetween-$command.1")"
done

# --- completion ---
in_bash() { # in_bash WORD...: what the last word is completed to
  bash -c 'source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _inbetween; printf "%s\n" "${COMPREPLY[@]}"' \
    bash "$scratch/usr/share/bash-completion/completions/inbetween" "$@"
}
in_zsh() {
  zsh -f -c 'file=$1; shift; words=("$@"); CURRENT=$#; PREFIX=$words[$#]
    compadd() { shift; print -l -- ${(M)@:#$PREFIX*} }; source "$file"' \
    zsh "$scratch/usr/share/zsh/site-functions/_inbetween" "$@"
}
for shell in in_bash in_zsh; do
  expect "$shell: commands" "$(sort <<<"$commands")" "$("$shell" inbetween '' | sort)"
  expect "$shell: a command" check "$("$shell" inbetween ch)"
  expect "$shell: an option" --shutter "$("$shell" inbetween run examples/nod.toml --shu)"
  expect "$shell: the one with a short name" --help "$("$shell" inbetween run --he)"
  expect "$shell: an option of another command" '' "$("$shell" inbetween jog --shu)"
done

# --- the Debian package ---
umask 077  # of somebody who shares nothing
time=$(git log -1 --format=%ct 2>/dev/null) || export SOURCE_DATE_EPOCH=1700000000  # these are no sources of git
make_package() { # make_package FOLDER
  (cd "$build" && cpack -G DEB -B "$1" >"$scratch/said" 2>&1) || { cat "$scratch/said"; exit 1; }
}
make_package "$scratch/first"
package=$(echo "$scratch"/first/inbetween_*.deb)
expect "it is for the processor that the program was built for" "$architecture" "$(dpkg-deb --field "$package" Architecture)"
expect "what it depends on is found out" 1 "$(dpkg-deb --field "$package" Depends | grep --count libgpiod)"
dpkg-deb --contents "$package" >"$scratch/contents"
for file in bin/inbetween share/man/man1/inbetween-run.1 share/doc/inbetween/examples/reveal.toml \
  share/bash-completion/completions/inbetween share/zsh/site-functions/_inbetween \
  share/inbetween/blender/inbetween_blender.py \
  share/inbetween/editor/index.html share/inbetween/editor/solver.wasm share/doc/inbetween/licences/three; do
  expect "the package has $file" 1 "$(grep --count " ./usr/$file\$" "$scratch/contents")"
done

expect "everybody may look into its folders and files" '' "$(grep --invert-match '^.r..r..r.. \|^drwxr-xr-x ' "$scratch/contents" || true)"

# --- the same bytes at another time and place ---
(
  export TZ=Asia/Tokyo LC_ALL=C
  export SOURCE_DATE_EPOCH=${time:-$SOURCE_DATE_EPOCH}
  make_package "$scratch/second"
)
expect "its files carry the time of the commit" \
  "$(sha256sum <"$package")" "$(sha256sum <"$scratch/second/${package##*/}")"
for program in inbetween inbetween-edit; do
  expect "$program does not say where it was built" 0 \
    "$(grep --count --text --fixed-strings "$root" "$scratch/usr/bin/$program")"
done

all_was_as_expected 'what is installed works'
