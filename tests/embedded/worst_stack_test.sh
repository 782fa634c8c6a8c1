#!/usr/bin/env bash
# worst_stack.awk adds frames up along the deepest path, and refuses what has no bound.
set -euo pipefail
here=$(dirname "${BASH_SOURCE[0]}")
scratch=$(mktemp --directory)
trap 'rm --recursive --force "$scratch"' EXIT
printf 'outer\tns::outer(\n' >"$scratch/roots"

frame() { # frame FUNCTION SIZE, as the compiler writes it
  printf 'node: { title: "%s" label: "%s\\nfile.cpp:1:1\\n%s\\n0 dynamic objects" }\n' "$1" "$1" "$2"
}
call() { # call FROM TO
  printf 'edge: { sourcename: "%s" targetname: "%s" label: "file.cpp:2:2" }\n' "$1" "$2"
}

check() { # check WHAT EXPECTED, the call graph on standard input; EXPECTED is the output, or a part of the error
  local said status=0
  said=$(awk -v library=96 -f "$here/worst_stack.awk" "$scratch/roots" - 2>&1) || status=$?
  if { ((status == 0)) && [[ $said == "$2" ]]; } || { ((status != 0)) && [[ $2 != outer* && $said == *"$2"* ]]; }; then
    return
  fi
  printf 'FAILED: %s: status %d, %s instead of %s\n' "$1" "$status" "$said" "$2"
  exit 1
}

simple() {
  frame 'ns::outer()' '8 bytes (static)'
  frame 'ns::inner()' '24 bytes (static)'
  frame 'ns::other()' '16 bytes (dynamic,bounded)'
  call 'ns::outer()' 'ns::inner()'
  call 'ns::outer()' 'ns::other()'
}

simple | check 'the deeper of two calls' 'outer 32'
{ simple; call 'ns::other()' memcpy; } | check 'a function of the C library' 'outer 120'
{ simple; frame 'ns::inner()' '40 bytes (static)'; } | check 'an inline function of two files' 'outer 48'
{ simple; call 'ns::inner()' 'ns::outer()'; } | check 'recursion' 'recursion through ns::outer()'
{ simple; call 'ns::inner()' __indirect_call; } | check 'a pointer' 'a call through a pointer'
{ simple; frame 'ns::third()' '8 bytes (dynamic)'; } | check 'a frame of any size' 'the frame of ns::third() has no bound'
printf 'stacks are added up\n'
