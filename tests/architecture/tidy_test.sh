#!/usr/bin/env bash
# clang-tidy finds what is wrong in a source file that is compiled in a batch, and not only in the batch itself.
#
#   tidy_test.sh PROJECT
set -euo pipefail

project=$1
folder=$(mktemp --directory)
trap 'rm --recursive --force "$folder"' EXIT

for room in firmware_core/src/path drivers sim host_tools/text; do
  mkdir --parents "$folder/$room"
  printf 'int* nowhere() {\n  return 0;\n}\n' >"$folder/$room/wrong.cpp"
  printf '#include "%s"  // NOLINT\n' "$folder/$room/wrong.cpp" >"$folder/batch.cpp"
  findings=$(clang-tidy --config-file="$project/.clang-tidy" --quiet "$folder/batch.cpp" -- -std=c++20 2>/dev/null || true)
  if [[ $findings != *"$room/wrong.cpp:2:10: "*modernize-use-nullptr* ]]; then
    printf 'clang-tidy does not look into source files of %s in a batch: see HeaderFilterRegex in .clang-tidy\n%s\n' \
      "$room" "$findings" >&2
    exit 1
  fi
done
