#!/usr/bin/env bash
# A bench kernel that panics is one clear error at once. Stand-ins say what kernels have said and then hang, as a kernel
# does; a real one loses its first process.
#
#   panic_test.sh RUN_SCRIPT
set -euo pipefail
# shellcheck source=tests/support/expect.sh
source "${BASH_SOURCE[0]%/*}/../support/expect.sh"

run_script=$(realpath "$1")
scratch=$(mktemp --directory)
trap 'rm --recursive --force "$scratch"' EXIT

# Its own time limit is a week: what ends it is the panic, or timeout(1) with another status.
run() { # run OPTION... -- COMMAND...
  status=0
  timeout 100 "$run_script" --kernel --timeout 604800 "$@" >"$scratch/out" 2>"$scratch/err" || status=$?
}

# --- stand-ins, on any processor ---------------------------------------------------------------------------------
run_stand_in() { # run_stand_in, with what the kernel says at standard input
  local kernel
  export INBETWEEN_BENCH_CACHE=$scratch/cache
  kernel=$("${run_script%/*}/kernel" --path)
  mkdir --parents "${kernel%/*}"
  cat >"$scratch/said"
  # Like the kernel it ignores the request to end.
  printf '#!/usr/bin/env bash\ntrap "" ABRT HUP INT TERM\ncat "%s"\nexec sleep infinity\n' "$scratch/said" >"$kernel"
  chmod +x "$kernel"
  run --memory 223 --kernel-log "$scratch/log" -- true
  unset INBETWEEN_BENCH_CACHE
}

run_stand_in <<'END_OF_CONSOLE'
Run /init as init process
userspace - ptrace set fp regs failed, errno = 14
Kernel panic - not syncing: Attempted to kill init! exitcode=0x0000000b
CPU: 0 PID: 1 Comm: guest Not tainted 6.1.192 #1
END_OF_CONSOLE
expect "a processor with more registers than the kernel has room for is named, and what to do" \
  "sim/bench/run: error: the bench kernel panicked: userspace - ptrace set fp regs failed, errno = 14; the registers of this processor need a larger register_buffer_bytes in sim/bench/kernel" \
  "$(<"$scratch/err")"
expect "a bench that cannot be made has its exit status" 125 "$status"
expect "the log is what the kernel said" "$(<"$scratch/said")" "$(<"$scratch/log")"
while grep --quiet --no-messages 'mem=[2]23M' /proc/[0-9]*/cmdline; do sleep 0.01; done

run_stand_in <<<'Kernel panic - not syncing: Out of memory: compulsory panic_on_oom is enabled'
expect "a kernel without memory is told to have more" \
  "sim/bench/run: error: the bench kernel panicked: Out of memory: compulsory panic_on_oom is enabled; give it more than 223 MB with --memory" \
  "$(<"$scratch/err")"
expect "with the same exit status" 125 "$status"

# --- one that ends before the command begins, and says nothing, is started again -----------------------------------
export INBETWEEN_BENCH_CACHE=$scratch/cache
kernel=$("${run_script%/*}/kernel" --path)
cat >"$kernel" <<END_OF_KERNEL
#!/usr/bin/env bash
echo started >>"$scratch/starts"
((\$(wc --lines <"$scratch/starts") >= \$(<"$scratch/needed"))) || exit 1
for word; do [[ \$word != inbetween_bench=* ]] || folder=\${word#*=}; done
: >"\$folder/begun"
echo 7 >"\$folder/status"
END_OF_KERNEL
for needed in 2 3 9; do
  echo "$needed" >"$scratch/needed"
  : >"$scratch/starts"
  run -- true
  expect "a kernel that begins at start $needed: exit status, starts" "$((needed < 9 ? 7 : 125)) $((needed < 9 ? needed : 3))" \
    "$status $(wc --lines <"$scratch/starts")"
done
unset INBETWEEN_BENCH_CACHE

# --- a kernel that panics ----------------------------------------------------------------------------------------
# The first process of the bench ends, for what should switch the kernel off does nothing.
for clock in '' --virtual-time; do
  # shellcheck disable=SC2086,SC2016  # the clock is no word or one; the script is for the bench
  run $clock -- bash -c 'echo begun; mount --bind "$(type -P true)" "$(type -P perl)"'
  expect "a kernel that panics says why ($clock)" \
    "sim/bench/run: error: the bench kernel panicked: Attempted to kill init! exitcode=0x00000000; keep all that it says with --kernel-log FILE" \
    "$(<"$scratch/err")"
  expect "its exit status is not that of the command ($clock)" 125 "$status"
  expect "what the command said before has arrived ($clock)" begun "$(<"$scratch/out")"
done

# --- a kernel that does not --------------------------------------------------------------------------------------
run -- echo 'Kernel panic - not syncing: told by the command'
expect "what the command says is not what the kernel says" \
  "0 Kernel panic - not syncing: told by the command" "$status $(<"$scratch/out")"

all_was_as_expected 'sim/bench/run: a panic is one error at once'
