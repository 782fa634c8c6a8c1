#!/usr/bin/env bash
# Every folder of the fuzz corpus has at most 20 seeds, and each has a name that says what it is: finds of a fuzzer, which
# have a hash for a name, become tests in tests/unit instead.
#
#   seeds_test.sh ROOT
set -euo pipefail
# shellcheck source=tests/support/expect.sh
source "${BASH_SOURCE[0]%/*}/../support/expect.sh"

# complaints_of CORPUS: a line for each folder with too many seeds, and for each seed without a name.
complaints_of() {
  local folder seed seeds
  for folder in "$1"/*/; do
    seeds=("$folder"*)
    ((${#seeds[@]} <= 20)) || printf '%s has %d seeds\n' "$(basename "$folder")" "${#seeds[@]}"
    for seed in "${seeds[@]##*/}"; do
      if [[ $seed =~ ^(crash-|slow-unit-|leak-|timeout-|oom-)?[0-9a-f]{32,}$ ]]; then
        printf '%s/%s has no name\n' "$(basename "$folder")" "$seed"
      fi
    done
  done
}

expect 'the seeds are few and have names' '' "$(complaints_of "$1/tests/fuzz/corpus")"

# And it is seen where it is not so.
scratch=$(mktemp --directory)
trap 'rm --recursive --force "$scratch"' EXIT
mkdir "$scratch/many" "$scratch/found"
touch "$scratch"/many/seed_{1..21} "$scratch/found/0123456789abcdef0123456789abcdef01234567" "$scratch/found/a_name"
expect 'too many seeds and a find are refused' "found/0123456789abcdef0123456789abcdef01234567 has no name
many has 21 seeds" "$(complaints_of "$scratch")"
all_was_as_expected 'every seed has a name, and no folder has more than 20'
