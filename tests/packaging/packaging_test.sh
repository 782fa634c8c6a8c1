#!/usr/bin/env bash
# Installs the program, makes the Debian package, and tries what comes with it.
#
#   packaging_test.sh BUILD
set -euo pipefail
# shellcheck source=tests/support/expect.sh
source "${BASH_SOURCE[0]%/*}/../support/expect.sh"

build=$(realpath "$1")
scratch=$(mktemp --directory)
trap 'rm --recursive --force "$scratch"' EXIT

cmake --install "$build" --prefix "$scratch/usr" >"$scratch/said" || { cat "$scratch/said"; exit 1; }
PATH=$scratch/usr/bin:$PATH
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
(cd "$build" && cpack -G DEB -B "$scratch" >"$scratch/said" 2>&1) || { cat "$scratch/said"; exit 1; }
package=$(echo "$scratch"/inbetween_*.deb)
expect "what it depends on is found out" 1 "$(dpkg-deb --field "$package" Depends | grep --count libgpiod)"
dpkg-deb --contents "$package" >"$scratch/contents"
for file in bin/inbetween share/man/man1/inbetween-run.1 share/doc/inbetween/examples/reveal.toml \
  share/bash-completion/completions/inbetween share/zsh/site-functions/_inbetween; do
  expect "the package has $file" 1 "$(grep --count " ./usr/$file\$" "$scratch/contents")"
done

all_was_as_expected 'what is installed works'
