#!/usr/bin/awk -f
# Lets the output of ctest pass, and puts before its last lines the slowest tests and why tests were skipped.
#
#   ctest ... | test-summary.awk log=BUILD/Testing/Temporary/LastTest.log -

# "12/1100 Test  #34: Suite.Name ........   Passed    1.23 sec"
/^ *[0-9]+\/[0-9]+ +Test +#[0-9]+: .* sec *$/ {
  name = $0
  sub(/^[^:]*: */, "", name)
  sub(/ .*/, "", name)
  seconds[name] = $(NF - 1)
}

/% tests passed/ { closing = 1 }
closing { last[++lines] = $0; next }
{ print; fflush() }

END {
  print "The slowest tests:"
  for (i = 1; i <= 10; ++i) {
    slowest = ""
    for (name in seconds) if (slowest == "" || seconds[name] > seconds[slowest]) slowest = name
    if (slowest == "") break
    printf "%8.1f s  %s\n", seconds[slowest], slowest
    delete seconds[slowest]
  }
  # GoogleTest: "FILE:LINE: Skipped", and the reason in the line after it.
  while (log != "" && (getline line < log) > 0) {
    if (line ~ /^[0-9]+\/[0-9]+ Test: /) { name = line; sub(/^[^:]*: /, "", name) }
    if (skipped) { printf "Skipped: %s: %s\n", name, line; skipped = 0 }
    if (line ~ /: Skipped$/) skipped = 1
  }
  print ""
  for (i = 1; i <= lines; ++i) print last[i]
}
