# Completion for bash: the commands of inbetween, and the options that the --help of each names.
_inbetween() {
  local program=${COMP_WORDS[0]} word=${COMP_WORDS[COMP_CWORD]} words
  local -a command=()
  if ((COMP_CWORD > 1)); then command=("${COMP_WORDS[1]}"); fi
  if [[ $word == -* ]]; then
    words=$("$program" "${command[@]}" --help 2>/dev/null | grep --only-matching --extended-regexp -- '^  (-h,)?--[a-z-]+')
    words=${words//-h,/}
  elif ((COMP_CWORD == 1)); then
    words=$("$program" --help 2>/dev/null | sed --quiet '/^Subcommands:/,/^$/s/^  \([a-z-]*\) .*/\1/p')
  else
    compopt -o default
    return
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
}
complete -F _inbetween inbetween
