# bash completion of tactus: commands and options as the program itself lists them.
_tactus() {
  local word=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} path=() i help commands values=
  for ((i = 1; i <= COMP_CWORD; i++)); do
    help=$(tactus "${path[@]}" --help 2>/dev/null)
    commands=$(sed -n '/^Subcommands:/,/^$/s/^  \([a-z][a-z-]*\) .*/\1/p' <<<"$help")
    grep -qxF -e "${COMP_WORDS[i]}" <<<"$commands" && ((i < COMP_CWORD)) || break
    path+=("${COMP_WORDS[i]}")
  done
  case $previous in
    --accuracy) values='fast balanced accurate' ;;
    --against) values=cyclictest ;;
    --border) values='ghost capped replay filtered frozen' ;;
    --coupling) values='sub-world direct interpolation static plane planes linearised' ;;
    --device) values='sim usb can:' ;;
    --load) values='none cpu memory stress-ng' ;;
    --order) values='best-first breadth-first' ;;
    --profile) values='virtuose6d desk3d' ;;
    --reach) values='two-cycles paper' ;;
    --world-precision) values='double mixed' ;;
  esac
  if [[ -n $values ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$values" -- "$word")
  elif [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(grep -oE '^ +(-[a-z],)?--[a-z][a-z0-9-]*' <<<"$help" | grep -oE -- '--.*' | sort -u)" -- "$word")
  elif [[ ${path[*]} == control ]]; then
    mapfile -t COMPREPLY < <(compgen -W 'state arm rearm disarm reset reload stop' -- "$word")
  else
    mapfile -t COMPREPLY < <(compgen -W "$commands" -- "$word")
    if ((${#COMPREPLY[@]} == 0)); then mapfile -t COMPREPLY < <(compgen -f -- "$word"); fi
  fi
}
complete -o filenames -F _tactus tactus
