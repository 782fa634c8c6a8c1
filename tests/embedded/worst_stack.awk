#!/usr/bin/awk -f
# The worst stack of functions, from the call graphs that the compiler wrote beside the objects
# (-fcallgraph-info=su, a .ci file each, through c++filt): its own frame and the deepest sum of those it calls.
#
#   cat *.ci | c++filt | awk -v library=BYTES -f worst_stack.awk ROOTS -
#
# ROOTS has a line per function, "name<TAB>how its demangled signature begins (after its return type)"; for each that is there
# a line "name bytes" is printed. A function that is not in the call graphs is the C library's: `library` bytes.
# Recursion, calls through pointers and frames of unknown size have no bound, and are errors.

function fail(why) {
  print "worst_stack.awk: error: " why > "/dev/stderr"
  failed = 1
}

# "file.cpp:symbol" for what is local to a file, else "symbol".
function symbol_of(title) {
  sub(/^[^ :]*\/[^ :]*:/, "", title)
  return title
}

function worst(name,    callees, count, i, deepest, bytes) {
  if (name in known) return known[name]
  if (!(name in frame)) {
    if (name == "__indirect_call") fail("a call through a pointer, which has no bound")
    return library
  }
  if (name in open) {
    fail("recursion through " name ", which has no bound")
    return 0
  }
  open[name] = 1
  count = split(calls[name], callees, "\n")
  for (i = 1; i <= count; ++i) {
    bytes = worst(callees[i])
    if (bytes > deepest) deepest = bytes
  }
  delete open[name]
  return known[name] = frame[name] + deepest
}

FNR == NR {
  tab = index($0, "\t")
  if (tab) {
    root_name[++root_count] = substr($0, 1, tab - 1)
    root_begins[root_count] = substr($0, tab + 1)
  }
  next
}

/^node: / {
  split($0, part, "\"")
  if (!match(part[4], /\\n[0-9]+ bytes \([a-z,]+\)/)) next
  size = substr(part[4], RSTART + 2, RLENGTH - 2)
  name = symbol_of(part[2])
  if (size !~ /\(static\)|bounded/) fail("the frame of " name " has no bound: " size)
  bytes = size + 0
  # An inline function is in several files, and may have been compiled differently in each.
  if (!(name in frame) || bytes > frame[name]) frame[name] = bytes
}

/^edge: / {
  split($0, part, "\"")
  from = symbol_of(part[2])
  to = symbol_of(part[4])
  if ((from, to) in edge) next
  edge[from, to] = 1
  calls[from] = calls[from] (calls[from] == "" ? "" : "\n") to
}

END {
  for (name in frame) names[++name_count] = name
  for (i = 1; i <= root_count; ++i) {
    found = -1
    for (j = 1; j <= name_count; ++j) {
      at = index(names[j], root_begins[i])
      if (at == 0 || (at > 1 && substr(names[j], at - 1, 1) != " ")) continue
      bytes = worst(names[j])
      if (bytes > found) found = bytes
    }
    if (found >= 0) print root_name[i], found
  }
  exit failed
}
