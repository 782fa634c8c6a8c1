#!/usr/bin/env bash
# docs/faults.md is true as far as a script can tell: every fault has one row or is said not to exist here, every test
# that it names is in a program that ctest runs, and every number that the sources cite is there.
#
#   faults_document_test.sh ROOT BUILD
set -euo pipefail
# shellcheck source=tests/support/expect.sh
source "${BASH_SOURCE[0]%/*}/../support/expect.sh"
root=$1 build=$2
document=$root/docs/faults.md

scratch=$(mktemp --directory)
trap 'rm --recursive --force "$scratch"' EXIT

{
  # Not from `ctest --show-only`, which writes its own log over that of the ctest that runs this.
  find "$build/tests" -name CTestTestfile.cmake -exec sed --quiet 's/^add_test(\[*=*\[*\([A-Za-z0-9._]*\).*/\1/p' {} +
  # ctest has parts and suites of these programs, and they have the tests.
  for program in inbetween_{unit,property,golden,realtime} bench/inbetween_bench{,_inside}; do
    "$build/tests/${program}_tests" --gtest_list_tests | awk '/^[^ ]/ { suite = $1 } /^ / { print suite $1 }'
  done
} | sort >"$scratch/registered"

# missing_tests DOCUMENT: a line for each test that it names and that is not there.
# shellcheck disable=SC2016  # the backticks are those of the document
missing_tests() {
  comm -13 "$scratch/registered" <(grep --only-matching --extended-regexp '`[A-Za-z0-9]+\.[A-Za-z0-9]+`' "$1" |
    grep --invert-match '\.md`' | tr --delete '`' | sort --unique) | sed 's/^/no such test: /'
}

# complaints_of DOCUMENT: a line for each thing that is wrong with it.
# shellcheck disable=SC2016  # the backticks are those of the document
complaints_of() {
  local number
  for number in {1..62}; do
    grep --quiet --extended-regexp "^\| $number \||^$number \(|and $number \(" "$1" || printf 'no row of fault %d\n' "$number"
  done
  grep --extended-regexp '^\| [0-9]+ \|' "$1" | grep --invert-match '`[A-Za-z0-9]*\.[A-Za-z0-9]*`' | sed 's/^/no test in /'
  missing_tests "$1"
  return 0
}

complaints=$(complaints_of "$document")
expect "docs/faults.md names a test of every fault" "" "$complaints"
expect "docs/drives.md names tests that there are" "" "$(missing_tests "$root/docs/drives.md")"

# A number as in "docs/faults.md 13, 20".
for cited in $(grep --recursive --no-filename --only-matching --extended-regexp 'docs/faults\.md [0-9]+(, [0-9]+)*' \
  "$root/firmware_core" "$root/drivers" "$root/sim" "$root/host_tools" "$root/tests" | tr --complement --delete '0-9\n ' | sort --unique); do
  ((cited >= 1 && cited <= 62)) || expect "the sources cite faults that there are" "1 to 62" "$cited"
done

# And it is seen where it is not.
sed 's/BadInput\.ACoordinateIsNotANumber/BadInput.NoSuchTest/; /^| 12 |/d' "$document" >"$scratch/spoiled.md"
expect "a wrong name and a missing row are found" "no row of fault 12
no such test: BadInput.NoSuchTest" "$(complaints_of "$scratch/spoiled.md")"
all_was_as_expected 'docs/faults.md: every test is there'
