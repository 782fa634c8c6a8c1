#!/usr/bin/awk -f
# What ctest prints, up to its summary: of a part that failed, what its passed tests say is left out.
#
#   ctest ... | test-failures.awk

function print_held() {
  printf "%s", held
  held = ""
  fflush()
}

/% tests passed/ { print_held(); is_summary = 1 }
is_summary { next }
/^\[ RUN / { print_held(); is_running = 1 }
/^ +(Start +)?[0-9]+(\/|:)/ { is_running = 0 }  # ctest's own
{ held = held $0 "\n" }
/^\[       OK / { held = ""; is_running = 0 }
!is_running { print_held() }
END { print_held() }
