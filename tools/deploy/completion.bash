# bash completion of tactus: commands and options as the program itself lists them.
_tactus() {
  local word=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} path=() i
  for ((i = 1; i < COMP_CWORD; i++)); do
    case ${COMP_WORDS[i]} in
      run | doctor | timing | tune | control | config | scene | hil | replay | experiment | check | accuracy-cost | capacity | \
        couplings | effects | energy-loss | hard-cases | peers | scaling | stability-map)
        path+=("${COMP_WORDS[i]}") ;;
      *) break ;;
    esac
  done
  local help
  help=$(tactus "${path[@]}" --help 2>/dev/null)
  case $previous in
    --against) mapfile -t COMPREPLY < <(compgen -W cyclictest -- "$word"); return ;;
    --load) mapfile -t COMPREPLY < <(compgen -W 'none cpu memory stress-ng' -- "$word"); return ;;
    --coupling) mapfile -t COMPREPLY < <(compgen -W 'sub-world direct interpolation static plane planes linearised' -- "$word"); return ;;
  esac
  if [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(grep -oE -- '--[a-z][a-z-]*' <<<"$help" | sort -u)" -- "$word")
  elif [[ ${path[*]} == control ]]; then
    mapfile -t COMPREPLY < <(compgen -W 'state arm rearm disarm reload stop' -- "$word")
  else
    local commands
    commands=$(sed -n '/^Subcommands:/,/^$/s/^  \([a-z][a-z-]*\) .*/\1/p' <<<"$help")
    mapfile -t COMPREPLY < <(compgen -W "$commands" -- "$word")
    if ((${#COMPREPLY[@]} == 0)); then mapfile -t COMPREPLY < <(compgen -f -- "$word"); fi
  fi
}
complete -o filenames -F _tactus tactus
