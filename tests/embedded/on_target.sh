#!/usr/bin/env bash
# Runs a program for another processor in QEMU, or of WebAssembly under node; its output and exit status are those of the program.
#
#   on_target.sh cortex-m7|cortex-m4f|aarch64-linux|riscv64-linux|wasm32|host PROGRAM
#
# With -icount a nanosecond passes with every instruction, and a wait passes at once: every run is the same run.
set -euo pipefail
target=$1 program=$2

cortex_m() { # cortex_m MACHINE
  exec qemu-system-arm -machine "$1" -display none -monitor none -serial stdio \
    -semihosting-config enable=on,target=native -icount shift=0,sleep=off -kernel "$program" </dev/null
}

case $target in
  cortex-m7) cortex_m mps2-an500 ;;
  cortex-m4f) cortex_m mps2-an386 ;;
  aarch64-linux | riscv64-linux) exec "qemu-${target%-linux}" "$program" ;;
  wasm32) exec node --no-warnings "$(dirname "${BASH_SOURCE[0]}")/run_wasm.mjs" "$program" ;;
  host) exec "$program" ;;
  *)
    printf 'on_target.sh: error: unknown target %s\n' "$target" >&2
    exit 2
    ;;
esac
