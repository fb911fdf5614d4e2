# Completion of tactbench for bash, of what the program's own --help lists: verbs, options, and the words of an option;
# files where a text is free. Names of shipped recipes where a recipe or a suite is wanted.
_tactbench() {
  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]}
  local verb=("${COMP_WORDS[0]}") help words="" files="" i
  for ((i = 1; i < COMP_CWORD; i++)); do
    [[ ${COMP_WORDS[i]} == -* ]] && break
    verb+=("${COMP_WORDS[i]}")
  done
  if [[ $current == = ]]; then
    current=""  # --option=, of which bash makes two words
  elif [[ $previous == = ]]; then
    previous=${COMP_WORDS[COMP_CWORD - 2]}
  fi
  help=$("${verb[@]}" --help-all 2>/dev/null) || return 0
  local option=$'\n  ([^ \n]*,)?'"$previous"$'(,[^ \n]*)? (TEXT|INT|UINT|FLOAT)(:\\{([^}\n]*)\\})?'
  if [[ $previous == -* && $help =~ $option ]]; then
    words=${BASH_REMATCH[5]//,/ }
    [[ ${BASH_REMATCH[3]} == TEXT && -z $words ]] && files=1
  elif [[ $current == -* ]]; then
    words="$(grep -oE '^  -[^ ]+' <<<"$help" | tr ',' ' ') --db --bench --units --json -q --quiet"
  else
    words=$(sed -n 's/^  \([a-z][^ ]*\)  .*/\1/p' <<<"$help")
    if [[ -z $words ]]; then
      files=1
      words=$(grep -oE '^  [a-z][a-z-]* TEXT:\{[^}]*' <<<"$help" | sed 's/.*{//' | tr ',' ' ')
      if [[ $help == *$'\n  recipe TEXT'* || $help == *$'\n  suite TEXT'* ]]; then
        words+=" nightly $("${COMP_WORDS[0]}" plan 2>/dev/null | sed -n '2,$s/^\([a-z-]*\)  .*/\1/p')"
      fi
    fi
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current"; [[ -z $files ]] || compgen -f -- "$current")
  [[ -z $files ]] || compopt -o filenames 2>/dev/null
  return 0
}
complete -F _tactbench tactbench
