#!/usr/bin/awk -f
# The slowest tests of a run of ctest, why tests were skipped, and what those that failed said last.
#
#   test-summary.awk OUTPUT LOG      what ctest printed, and BUILD/Testing/Temporary/LastTest.log

BEGIN { kept = 20 }

# "12/1100 Test  #34: Suite.Name ........   Passed    1.23 sec"
/^ *[0-9]+\/[0-9]+ +Test +#[0-9]+: .* sec *$/ {
  name = $0
  sub(/^[^:]*: */, "", name)
  sub(/ .*/, "", name)
  seconds[name] = $(NF - 1)
}

# The log: "12/1100 Test: Suite.Name"; GoogleTest's "FILE:LINE: Skipped", and the reason in the line after it.
/^[0-9]+\/[0-9]+ Test: / { running = $3; lines = from = 0 }
# GoogleTest's "FILE:LINE: Failure" and what follows it, or else the end of what the test said.
!from && /: Failure$/ { from = lines + 1 }
/^<end of output>$/ {
  if (!from && lines > kept) from = lines - kept + 1
  said = ""
  for (i = from ? from : 1; i <= lines && i < (from ? from : 1) + kept; ++i) said = said "    " line[i] "\n"
}
/^Test Failed\.$/ { failed[++failures] = "Failed: " running "\n" said }
{ line[++lines] = $0 }
is_skipped { skipped[++skips] = running ": " $0 }
{ is_skipped = /: Skipped$/ }

END {
  print "The slowest tests:"
  for (i = 1; i <= 10; ++i) {
    slowest = ""
    for (name in seconds) if (slowest == "" || seconds[name] > seconds[slowest]) slowest = name
    if (slowest == "") break
    printf "%8.1f s  %s\n", seconds[slowest], slowest
    delete seconds[slowest]
  }
  for (i = 1; i <= failures; ++i) printf "%s", failed[i]
  for (i = 1; i <= skips; ++i) print "Skipped: " skipped[i]
  print ""
}
