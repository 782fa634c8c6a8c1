#!/usr/bin/awk -f
# Turns what Google Benchmark wrote as JSON (aggregates only) into the tables of docs/performance.md.
# It writes one member a line, so a line is a name and a value.
function value_of(line) {
  sub(/^[^:]*: */, "", line)
  gsub(/[",]/, "", line)
  return line
}

function time_text(ns) {
  if (ns < 1e3) return sprintf("%.1f ns", ns)
  if (ns < 1e6) return sprintf("%.1f us", ns / 1e3)
  return sprintf("%.1f ms", ns / 1e6)
}

function ratio_row(what, slow, fast, form) {
  if (!((slow in time) && (fast in time))) return
  printf "| %s | " (form ? form : "%.0f") " |\n", what, time[slow] / time[fast]
}

BEGIN {
  ns["ns"] = 1
  ns["us"] = 1e3
  ns["ms"] = 1e6
  ns["s"] = 1e9
  # What Google Benchmark says of itself; any other number is a counter of ours.
  split("family_index per_family_instance_index repetitions threads iterations real_time cpu_time", own)
  for (i in own) not_ours[own[i]] = 1
}

/^ *"name":/ {
  name = value_of($0)
  kept = sub(/_median$/, "", name)
  if (kept) order[++count] = name
}
kept && /^ *"cpu_time":/ { cpu = value_of($0) }
kept && /^ *"time_unit":/ { time[name] = cpu * ns[value_of($0)] }
kept && /^ *"[A-Za-z0-9_]+": [-+0-9.e]+,?$/ {
  key = $1
  gsub(/[":]/, "", key)
  if (!(key in not_ours)) counters[name] = counters[name] sprintf("%s %.2g; ", key, value_of($0))
}

END {
  if (!count) {
    print "performance-table.awk: error: no medians in " FILENAME > "/dev/stderr"
    exit 1
  }
  print "| benchmark | time | counters |\n|---|---:|---|"
  for (i = 1; i <= count; ++i) {
    sub(/; $/, "", counters[order[i]])
    printf "| `%s` | %s | %s |\n", order[i], time_text(time[order[i]]), counters[order[i]]
  }
  print "\n| the paper's solver over the closed form | times |\n|---|---:|"
  ratio_row("240 frames, 8 keys, 3 axes", "runge_kutta/240", "closed_form/240")
  ratio_row("100 000 frames, 100 keys, 3 axes", "runge_kutta/100000", "closed_form/100000")
  print "\n| frames looked up one by one over frames in runs | times |\n|---|---:|"
  ratio_row("240 frames", "frames_one_by_one/240", "frames_in_runs/240", "%.1f")
  ratio_row("100 000 frames", "frames_one_by_one/100000", "frames_in_runs/100000", "%.1f")
  print "\n| a tick between rest and the drawn speed over one at it | times |\n|---|---:|"
  ratio_row("8 keys, 3 axes", "playhead_ramp/3", "playhead_tick/3", "%.1f")
  ratio_row("100 keys, 16 axes", "playhead_ramp/16", "playhead_tick/16", "%.1f")
  print "\n| three axes in seven phases of constant jerk over the drawn speed, at random times | times |\n|---|---:|"
  ratio_row("position", "jerk_profiles", "tick/3", "%.1f")
  ratio_row("position, velocity, acceleration and jerk", "jerk_profiles", "motion/3", "%.2f")
  print "\n| a tick of the loop of 16 axes that are where they were told to be, with a take over one without | times |\n|---|---:|"
  ratio_row("1 kHz", "take_tick_with", "take_tick_without", "%.2f")
  print "\n| the certificate with bounds of every stop over the certificate alone | times |\n|---|---:|"
  ratio_row("240 frames, 8 keys, 3 axes", "certificate_and_stops/example", "certificate/example", "%.1f")
  ratio_row("2400 frames, 100 keys, 16 axes", "certificate_and_stops/100x16", "certificate/100x16", "%.1f")
}
