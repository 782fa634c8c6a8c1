#!/usr/bin/env bash
# scripts/bootstrap against a made-up machine: its own apt sources, and stand-ins for apt-get, dpkg, dpkg-query and
# sudo that write down how they were called. Nothing is installed and no server is asked.
#
#   bootstrap_test.sh BOOTSTRAP
set -euo pipefail
# shellcheck source=tests/support/expect.sh
source "${BASH_SOURCE[0]%/*}/../support/expect.sh"
scratch=$(mktemp --directory)
trap 'rm --recursive --force "$scratch"' EXIT
# A machine of today, unless a test says otherwise.
export OS_RELEASE=$scratch/os-release
printf 'VERSION_CODENAME=trixie\n' >"$OS_RELEASE"
# shellcheck source=scripts/bootstrap
source "$1"

# --- where backports come from -------------------------------------------------------------------------------
new_apt_machine() {
  local root=$scratch/apt
  rm --recursive --force "$root"
  mkdir --parents "$root"/etc/{apt.conf.d,preferences.d,sources.list.d} "$root/state/lists/partial" "$root/cache"
  printf 'Dir::Etc "%s/etc/";\nDir::State "%s/state/";\nDir::State::status "/dev/null";\nDir::Cache "%s/cache/";\n' \
    "$root" "$root" "$root" >"$root/apt.conf"
  export APT_CONFIG=$root/apt.conf
}

# As apt-get update leaves it: the release file, which names the origin, and the package list.
downloaded() { # downloaded ESCAPED_URI SUITE ORIGIN
  local lists=$scratch/apt/state/lists/$1_dists_$2
  printf 'Origin: %s\nCodename: %s\nComponents: main\nDate: Sat, 17 May 2025 10:00:00 UTC\nSHA256:\n' "$3" "$2" \
    >"${lists}_InRelease"
  : >"${lists}_main_binary-$(dpkg --print-architecture)_Packages"
}

# The functions under test write as root on a real machine; here the folder is ours.
as_root() { "$@"; }

added() { cat "$scratch/apt/etc/sources.list.d/inbetween-backports.list" 2>/dev/null || true; }
signed='signed-by=/usr/share/keyrings/debian-archive-keyring.gpg'

new_apt_machine
cat >"$scratch/apt/etc/sources.list" <<'END'
# deb http://old.example/debian bookworm main
deb http://other.example/debian bookworm main
deb [arch=amd64,arm64] http://mirror.example/debian bookworm main contrib
deb http://mirror.example/debian-security bookworm-security main
END
downloaded other.example_debian bookworm "Other"
downloaded mirror.example_debian bookworm "Debian"
downloaded mirror.example_debian-security bookworm-security "Debian"
add_backports >/dev/null
expect "the mirror of a one-line source, and neither a comment, nor security, nor another vendor" \
  "deb [$signed] http://mirror.example/debian/ bookworm-backports main" "$(added)"

new_apt_machine
cat >"$scratch/apt/etc/sources.list.d/debian.sources" <<'END'
Types: deb
URIs: http://off.example/debian
Suites: bookworm
Components: main
Enabled: no

Types: deb deb-src
# The site's own copy.
URIs: https://mirror.example/pub/debian
Suites: bookworm
 bookworm-updates
Components: main
END
downloaded off.example_debian bookworm "Debian"
downloaded mirror.example_pub_debian bookworm "Debian"
add_backports >/dev/null
expect "the mirror of a deb822 source, and none that is switched off" \
  "deb [$signed] https://mirror.example/pub/debian/ bookworm-backports main" "$(added)"

new_apt_machine
printf 'deb http://mirror.example/debian bookworm main\ndeb http://mirror.example/debian bookworm-backports main\n' \
  >"$scratch/apt/etc/sources.list"
downloaded mirror.example_debian bookworm "Debian"
downloaded mirror.example_debian bookworm-backports "Debian Backports"
add_backports >/dev/null
expect "nothing is added where backports are there already" "" "$(added)"

new_apt_machine
refusal=$( (add_backports) 2>&1 >/dev/null || true)
expect "a machine without a mirror is told what to do" \
  "scripts/bootstrap: error: no mirror of Debian 12 in the apt sources; add 'bookworm main' to them, run apt-get update, try again" \
  "$refusal"
unset APT_CONFIG

# --- what is installed ---------------------------------------------------------------------------------------
stand_ins=$scratch/bin
mkdir "$stand_ins"
# shellcheck disable=SC2016  # expanded when the stand-in runs
printf '#!/bin/sh\necho "apt-get $*" >>"%s/calls"\n' "$scratch" >"$stand_ins/apt-get"
# shellcheck disable=SC2016
printf '#!/bin/sh\nif [ "$1" = --print-architecture ]; then echo amd64; else echo "dpkg $*" >>"%s/calls"; fi\n' "$scratch" \
  >"$stand_ins/dpkg"
# shellcheck disable=SC2016
printf '#!/bin/sh\nexec "$@"\n' >"$stand_ins/sudo"
chmod +x "$stand_ins"/{apt-get,dpkg,sudo}

# node and npm from wherever they are, and not from a package.
for command in node npm; do ln --symbolic /bin/true "$stand_ins/$command"; done

machine_with() { # machine_with PACKAGE..., as dpkg-query reports them
  {
    printf '#!/bin/sh\n'
    printf 'echo "installed %s"\n' "$@"
    printf 'echo "not-installed ninja-build"\nexit 1\n'
  } >"$stand_ins/dpkg-query"
  chmod +x "$stand_ins/dpkg-query"
  : >"$scratch/calls"
}

run_bootstrap() { PATH=$stand_ins:$PATH bash "$bootstrap" "$@" 2>&1 || true; }
bootstrap=$1

machine_with "${test_packages[@]}"
expect "a machine that has everything is left alone, in silence" "" "$(run_bootstrap test)$(cat "$scratch/calls")"

machine_with "${demo_packages[@]}"
expect "the demo does not install what only the tests need" "" "$(run_bootstrap demo)$(cat "$scratch/calls")"

machine_with "${editor_packages[@]}"
expect "the editor's tests need a browser and no more" "" "$(run_bootstrap editor)$(cat "$scratch/calls")"

machine_with "${blender_packages[@]}"
expect "the tests inside Blender need Blender and no more" "" "$(run_bootstrap blender)$(cat "$scratch/calls")"

machine_with "${demo_packages[@]/#clang-19/cmake}"
expect "the demo installs what its page is built with" "scripts/bootstrap: installing clang-19" "$(run_bootstrap demo)"

machine_with "${arm64_packages[@]}"
expect "a machine that has the libraries of 64-bit Arm is left alone too" "" "$(run_bootstrap arm64)$(cat "$scratch/calls")"

# The libraries of this machine, as dpkg-query writes them, are not those of the other processor.
machine_with "${arm64_packages[@]/%:arm64/:amd64}"
foreign=()
for package in "${arm64_packages[@]}"; do [[ $package != *:arm64 ]] || foreign+=("$package"); done
expect "what is there for this processor is missing for the other" \
  "scripts/bootstrap: installing ${foreign[*]}" "$(run_bootstrap arm64)"
expect "dpkg is told of the processor before apt fetches its lists" \
  "dpkg --add-architecture arm64
apt-get --quiet --quiet update
apt-get --quiet --quiet --option DPkg::Lock::Timeout=300 --option Dpkg::Use-Pty=0 install --yes --no-install-recommends ${foreign[*]}" \
  "$(cat "$scratch/calls")"

machine_with "libfmt-dev:arm64"
expect "and the other way round" "libfmt-dev" "$(PATH=$stand_ins:$PATH missing_of libfmt-dev libfmt-dev:arm64)"

machine_with "${demo_packages[@]}"
expect "the packages that are missing are named" \
  "scripts/bootstrap: installing ${test_packages[*]:${#demo_packages[@]}}" "$(run_bootstrap)"
expect "apt is updated once, then asked for those packages only" \
  "apt-get --quiet --quiet update
apt-get --quiet --quiet --option DPkg::Lock::Timeout=300 --option Dpkg::Use-Pty=0 install --yes --no-install-recommends ${test_packages[*]:${#demo_packages[@]}}" \
  "$(cat "$scratch/calls")"

machine_with bash
expect "a package that was removed again counts as missing" \
  "ninja-build" "$(PATH=$stand_ins:$PATH missing_of bash ninja-build)"

machine_with "libgpiod-dev 1.6.3-1+b3" "gpiod 2.1.3-1~bpo12+1"
expect "version 1 of libgpiod is another library" \
  "libgpiod-dev" "$(PATH=$stand_ins:$PATH missing_of libgpiod-dev gpiod)"

printf 'VERSION_CODENAME=bookworm\n' >"$OS_RELEASE"
new_apt_machine
printf 'deb http://mirror.example/debian bookworm main\n' >"$scratch/apt/etc/sources.list"
downloaded mirror.example_debian bookworm "Debian"
without=("${test_packages[@]/linux-source-6.12/linux-source-6.1}")
for i in "${!without[@]}"; do [[ ${without[i]} != libgpiod-dev ]] || unset 'without[i]'; done
machine_with "${without[@]}"
# The stand-in is asked where packages come from, too: the real one answers that.
# shellcheck disable=SC2016
printf '#!/bin/sh\nif [ "$1" = indextargets ]; then exec %s "$@"; fi\necho "apt-get $*" >>"%s/calls"\n' \
  "$(type -P apt-get)" "$scratch" >"$stand_ins/apt-get"
run_bootstrap test >/dev/null
expect "on Debian 12 it comes from the backports, whose list is fetched once they are added" \
  "apt-get --quiet --quiet update
apt-get --quiet --quiet update
apt-get --quiet --quiet --option DPkg::Lock::Timeout=300 --option Dpkg::Use-Pty=0 install --yes --no-install-recommends libgpiod-dev/bookworm-backports" \
  "$(cat "$scratch/calls")"
expect "which are added once" \
  "deb [$signed] http://mirror.example/debian/ bookworm-backports main" "$(added)"

without=("${arm64_packages[@]}")
for i in "${!without[@]}"; do [[ ${without[i]} != libgpiod-dev:arm64 ]] || without[i]="libgpiod-dev:arm64 1.6.3-1+b3"; done
machine_with "${without[@]}"
run_bootstrap arm64 >/dev/null
expect "and for the other processor from there as well" \
  "libgpiod-dev:arm64/bookworm-backports" "$(sed --quiet 's/.*--no-install-recommends //p' "$scratch/calls")"
unset APT_CONFIG

machine_with "${demo_packages[@]}"
chatty() { # chatty STATUS: an apt-get as in a container
  printf '#!/bin/sh\necho "invoke-rc.d: could not determine current runlevel"\necho "E: told" >&2\nexit %s\n' "$1" \
    >"$stand_ins/apt-get"
}
printf 'VERSION_CODENAME=trixie\n' >"$OS_RELEASE"
chatty 0
expect "what packages warn of in a container is not shown" \
  "scripts/bootstrap: installing ${test_packages[*]:${#demo_packages[@]}}" "$(run_bootstrap)"
chatty 100
expect "but it is where they cannot be installed" \
  "scripts/bootstrap: installing ${test_packages[*]:${#demo_packages[@]}}
invoke-rc.d: could not determine current runlevel
E: told
scripts/bootstrap: error: apt-get update failed; see above" "$(run_bootstrap)"

expect "an unknown set is refused" \
  "scripts/bootstrap: error: unknown set of packages 'dmeo'; say demo, test, editor, blender or arm64" "$(run_bootstrap dmeo)"

all_was_as_expected 'scripts/bootstrap: all as promised'
