#!/usr/bin/awk -f
# Turns what the core takes of a microcontroller into the tables of docs/performance.md.
#
#   budget-table.awk MEMORY MEASURED      what `inbetween budget` and what scripts/measure-budget printed

function cell(kind, target, name,    key) {
  key = kind SUBSEP target SUBSEP name
  if (!(key in measured)) return "-"
  return measured[key] < 1e4 ? measured[key] : thousands(measured[key] / 1e3) " 000"
}

# Rounded, in groups of three digits.
function thousands(number) {
  number = int(number + 0.5)
  if (number < 1e3) return number
  return thousands(int(number / 1e3)) sprintf(" %03d", number % 1e3)
}

function table_of(kind, title,    i, name) {
  printf "\n| %s | Cortex-M7 | Cortex-M4F |\n|---|---:|---:|\n", title
  for (i = 1; i <= count[kind]; ++i) {
    name = names[kind, i]
    printf "| `%s` | %s | %s |\n", name, cell(kind, "cortex-m7", name), cell(kind, "cortex-m4f", name)
  }
}

# The first block of `inbetween budget`: a heading, and rows that end in a number.
FNR == NR {
  if ($0 == "") past_memory = 1
  if (past_memory) next
  if (FNR == 1) {
    heading = $0
    sub(/:$/, "", heading)
    next
  }
  if ($NF == "-") next
  what = $0
  sub(/^  /, "", what)
  sub(/ +[^ ]+$/, "", what)
  gsub(/^ +/, "\\&emsp;", what)
  memory[++rows] = sprintf("| %s | %s |", what, $NF)
  next
}

{
  if (!(($1, $3) in seen)) {
    seen[$1, $3] = 1
    names[$1, ++count[$1]] = $3
  }
  measured[$1, $2, $3] = $4
}

END {
  if (!rows || !count["instructions"] || !count["stack"]) {
    print "budget-table.awk: error: no memory, instructions or stack in the files" > "/dev/stderr"
    exit 1
  }
  table_of("instructions", "instructions, three axes")
  table_of("stack", "worst stack in bytes, with all that is called")
  printf "\n%s:\n\n| object | bytes |\n|---|---:|\n", heading
  for (i = 1; i <= rows; ++i) print memory[i]
}
