# shellcheck shell=bash
# What the tests that are scripts share.
failures=0

expect() { # expect WHAT WANTED GOT
  [[ $2 == "$3" ]] && return
  printf 'FAILED: %s\n  wanted: %s\n  got:    %s\n' "$1" "$2" "$3"
  failures=$((failures + 1))
}

all_was_as_expected() { # all_was_as_expected WHAT_IT_SHOWS: the end of a test
  ((failures == 0)) || exit 1
  printf '%s\n' "$1"
}
