#!/usr/bin/awk -f
# The slowest tests of a run of ctest, why tests were skipped, and what those that failed said first.
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

function begin(name) {
  running = name
  lines = from = 0
}

# What is told of a failure: from GoogleTest's "FILE:LINE: Failure" on, or else the end of what the test said.
function tell(i) {
  ++failures
  failed[failures] = "Failed: " running "\n"
  if (!from) from = lines > kept ? lines - kept + 1 : 1
  for (i = from; i <= lines && i < from + kept; ++i) failed[failures] = failed[failures] "    " line[i] "\n"
}

# The log: "12/1100 Test: Suite.Name" or, of a program of many tests, "[ RUN      ] Suite.Name" and
# "[       OK ] Suite.Name (34 ms)"; GoogleTest's "FILE:LINE: Skipped", and the reason in the line after it.
/^[0-9]+\/[0-9]+ Test: / { begin($3); part = $3; has_told = 0; next }
/^\[ RUN +\] / { begin($4); next }
!from && /: Failure$/ { from = lines + 1 }
/^\[ +(OK|FAILED|SKIPPED) +\] .* \([0-9]+ ms\)$/ {
  seconds[running] = substr($(NF - 1), 2) / 1000
  if (part != running) delete seconds[part]
  if (/FAILED/) { tell(); has_told = 1 }
}
/^Test Failed\.$/ && !has_told { tell() }
!/^<end of output>$/ { line[++lines] = $0 }
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
