#!/usr/bin/env bash
# sim/bench/kernel with stand-ins for dpkg-query, uname, tar, make and strip: when it builds, where, and what is
# left of it. No kernel is built.
#
#   kernel_test.sh KERNEL_SCRIPT
set -euo pipefail
# shellcheck source=tests/support/expect.sh
source "${BASH_SOURCE[0]%/*}/../support/expect.sh"

scratch=$(mktemp --directory)
trap 'rm --recursive --force "$scratch"' EXIT

# The script looks for kernel.config beside itself. Its folder has a space in its name, as a user's may.
bench="$scratch/the bench"
mkdir "$bench" "$scratch/bin" "$scratch/cache"
cp "$1" "$bench/kernel"
: >"$scratch/archive"
sed --in-place "s|^source_archive=.*|source_archive=$scratch/archive|" "$bench/kernel"
printf 'CONFIG_NET=y\nCONFIG_MODULES=n\n' >"$bench/kernel.config"

stand_in() { # stand_in NAME, its text from standard input
  { printf '#!/usr/bin/env bash\n'; cat; } >"$scratch/bin/$1"
  chmod +x "$scratch/bin/$1"
}
# shellcheck disable=SC2016  # expanded when the stand-in runs
stand_in dpkg-query <<<'printf "%s" "${PACKAGE_VERSION:-6.1.1}"'
stand_in uname <<<'echo x86_64'
stand_in tar <<'END_OF_TAR'
[[ ${!#} == */source ]] && mkdir --parents "${!#}/scripts/kconfig"
# As the kernel's own: a path with a space is two.
printf '#!/bin/sh\nset -- $*\ngrep -v =n "$3" >.config\n' >"${!#}/scripts/kconfig/merge_config.sh"
chmod +x "${!#}/scripts/kconfig/merge_config.sh"
mkdir --parents "${!#}/arch/x86/um"
printf '\tDEFINE_LONGS(HOST_FP_SIZE, %s);\n' "${SOURCE_HAS:-2696}" >"${!#}/arch/x86/um/user-offsets.c"
END_OF_TAR
stand_in make <<END_OF_MAKE
case \$* in
  *olddefconfig) [[ -z \${REFUSE:-} ]] || sed --in-place '/CONFIG_NET/d' .config ;;
  *linux)
    echo built >>"$scratch/built"
    if [[ -n \${WAIT_FOR:-} ]]; then until [[ -e \$WAIT_FOR ]]; do sleep 0.01; done; fi
    [[ -z \${BREAK:-} ]] || { echo "the disk is full"; exit 2; }
    bytes=\${COMPILED:-\$(tr --delete --complement 0-9 <arch/x86/um/user-offsets.c)}
    mkdir --parents include/generated
    echo "#define HOST_FP_SIZE \$((bytes / 8)) /* \$bytes / sizeof(unsigned long) */" >include/generated/user_constants.h
    printf kernel >linux
    chmod +x linux
    ;;
esac
END_OF_MAKE
# shellcheck disable=SC2016
stand_in strip <<<'cp "$2" "${1#--output-file=}"'
for tool in flex bison bc; do stand_in "$tool" </dev/null; done

kernel() { PATH=$scratch/bin:$PATH INBETWEEN_BENCH_CACHE=$scratch/cache bash "$bench/kernel" "$@"; }
times_built() { wc --lines <"$scratch/built"; }
: >"$scratch/built"

# --- one build, then none ------------------------------------------------------------------------------------
path=$(kernel --path)
expect "to ask for the path builds nothing" 0 "$(times_built)"
expect "the first start builds, and says so in one line" \
  "sim/bench/kernel: building the bench kernel in ${path%/linux} (about 3 minutes, once)
$path" "$(kernel 2>&1)"
expect "the second start has it, in silence" "$path" "$(kernel 2>&1)"
expect "it was built once" 1 "$(times_built)"
expect "what is kept is the kernel, its configuration and the size of its register buffer" \
  "config linux register_buffer_bytes" "$(cd "${path%/linux}" && echo *)"
expect "the size is the one that was compiled" 16384 "$(cat "${path%/linux}/register_buffer_bytes")"
expect "nothing else is left" "$(printf '%s\n' "${path%/linux}" "${path%/linux}.lock")" \
  "$(find "$scratch/cache" -mindepth 1 -maxdepth 1 | sort)"

# --- another configuration or another source is another kernel ------------------------------------------------
printf 'CONFIG_CAN=y\n' >>"$bench/kernel.config"
[[ $(kernel --path) != "$path" ]] || expect "another configuration has another path" "another path" "$path"
path=$(kernel --path)
expect "another version of the source has another path" different \
  "$([[ $(PACKAGE_VERSION=6.1.2 kernel --path) == "$path" ]] || echo different)"

# The path that a script has which differs in one line.
changed_path=
change() { # change SED_COMMAND
  local whole
  whole=$(<"$bench/kernel")
  sed --in-place "$1" "$bench/kernel"
  expect "the script has the line of $1" changed \
    "$([[ $whole == "$(<"$bench/kernel")" ]] || echo changed)"
  changed_path=$(kernel --path)
  printf '%s\n' "$whole" >"$bench/kernel"
}
change 's/^register_buffer_bytes=.*/register_buffer_bytes=32768/'
expect "another register buffer has another path" different "$([[ $changed_path == "$path" ]] || echo different)"
change 's/^  sed --in-place/  sed --quiet --in-place/'
expect "another edit of the source has another path" different "$([[ $changed_path == "$path" ]] || echo different)"
change 's/^# Everything goes to/# All of it goes to/'
expect "another comment has the same path" "$path" "$changed_path"

# --- two at once -----------------------------------------------------------------------------------------------
: >"$scratch/built"
WAIT_FOR=$scratch/go kernel >"$scratch/first" 2>/dev/null &
first=$!
until [[ -s $scratch/built ]]; do sleep 0.01; done
kernel >"$scratch/second" 2>"$scratch/second.err" &
second=$!
until [[ -s $scratch/second.err ]]; do sleep 0.01; done
: >"$scratch/go"
wait $first $second
expect "the second waits for the first" \
  "sim/bench/kernel: waiting for another process that builds the bench kernel" "$(<"$scratch/second.err")"
expect "both have the same kernel" "$path $path" "$(<"$scratch/first") $(<"$scratch/second")"
expect "and it was built once" 1 "$(times_built)"

# --- a build that fails ------------------------------------------------------------------------------------------
rm --recursive "$scratch/cache"
status=0
refusal=$(BREAK=1 kernel 2>&1 >/dev/null) || status=$?
expect "a build that fails is one line, with the log's last and its place" \
  "sim/bench/kernel: error: the bench kernel does not build (the disk is full); see ${path%/linux}.log" \
  "$(tail --lines=1 <<<"$refusal")"
expect "with its own exit status" 125 "$status"
expect "and leaves the log, but no half kernel" "$(printf '%s\n' "${path%/linux}.lock" "${path%/linux}.log")" \
  "$(find "$scratch/cache" -mindepth 1 -maxdepth 1 | sort)"
expect "an option that the kernel refuses is named" \
  "sim/bench/kernel: error: the bench kernel does not build (sim/bench/kernel.config asks for what this kernel does not have: CONFIG_NET=y); see ${path%/linux}.log" \
  "$(REFUSE=1 kernel 2>&1 >/dev/null | tail --lines=1)"

expect "a source that the edit does not fit is named" \
  "sim/bench/kernel: error: the bench kernel does not build (sim/bench/kernel edits 'DEFINE_LONGS(HOST_FP_SIZE, 2696)', which is not in arch/x86/um/user-offsets.c any more); see ${path%/linux}.log" \
  "$(SOURCE_HAS=4096 kernel 2>&1 >/dev/null | tail --lines=1)"
expect "an edit without effect is not kept" \
  "sim/bench/kernel: error: the bench kernel does not build (its register buffer has 2696 bytes instead of 16384); see ${path%/linux}.log" \
  "$(COMPILED=2696 kernel 2>&1 >/dev/null | tail --lines=1)"
expect "nor is its kernel" "" "$(find "$scratch/cache" -name linux)"

# --- a build that was killed -------------------------------------------------------------------------------------
rm --recursive "$scratch/cache"
: >"$scratch/built"
rm --force "$scratch/go"
WAIT_FOR=$scratch/go kernel >/dev/null 2>&1 &
killed=$!
until [[ -s $scratch/built ]]; do sleep 0.01; done
kill -KILL $killed
wait $killed 2>/dev/null || true
: >"$scratch/go"
expect "a build that was killed does not lock out the next" "$path" "$(kernel 2>/dev/null)"

expect "a user without a home is told what to set" \
  "sim/bench/kernel: error: there is no HOME to keep the kernel in; set INBETWEEN_BENCH_CACHE" \
  "$(PATH=$scratch/bin:$PATH env --unset=HOME --unset=XDG_CACHE_HOME --unset=INBETWEEN_BENCH_CACHE bash "$bench/kernel" 2>&1 || true)"
expect "a folder that the kernel's makefiles do not take is refused before anything is built" \
  "sim/bench/kernel: error: the kernel cannot be built in '$scratch/a cache', because of a space or colon; set INBETWEEN_BENCH_CACHE to another folder" \
  "$(PATH=$scratch/bin:$PATH INBETWEEN_BENCH_CACHE="$scratch/a cache" bash "$bench/kernel" 2>&1 || true)"
expect "an unknown argument is refused" \
  "sim/bench/kernel: error: unknown argument 'now'; see --help" "$(kernel now 2>&1 || true)"

all_was_as_expected 'sim/bench/kernel: all as promised'
