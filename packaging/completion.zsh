#compdef inbetween
# Completion for zsh: the commands of inbetween, and the options that the --help of each names.
_inbetween() {
  local -a command
  ((CURRENT > 2)) && command=($words[2])
  if [[ $words[CURRENT] == -* ]]; then
    compadd -- ${${(f)"$($words[1] $command --help 2>/dev/null | grep -oE -- '^  (-h,)?--[a-z-]+')"}//( |-h,)/}
  elif ((CURRENT == 2)); then
    compadd -- ${(f)"$($words[1] --help 2>/dev/null | sed -n '/^Subcommands:/,/^$/s/^  \([a-z-]*\) .*/\1/p')"}
  else
    _files
  fi
}
_inbetween "$@"
