# bash completion of tactus: commands, options and values as the program itself lists them.

# _tactus_values OPTION: its values, by the help on standard input. They are in braces or, for some options, the list
# after the first colon of its text; --device has a line for each kind of device. An address is left out: `can:`.
_tactus_values() {
  awk -v option="$1" '
    function offer(value) {
      sub(/ .*/, "", value)
      sub(/:[A-Z].*/, ":", value)
      if (value ~ /^[a-z]/) print value
    }
    /^ *$/ || /^  -/ { on = 0 }
    $1 == option {
      on = 1
      if (match($2, /:[{].*[}]/)) {
        braces = substr($2, RSTART + 2, RLENGTH - 3)
        gsub(/,/, "\n", braces)
        print braces
        exit
      }
    }
    on && lines && /^ +[a-z]/ {
      split($0, part, /, |: /)
      sub(/^ +/, "", part[1])
      offer(part[1])
    }
    on && !lines { text = text " " $0 }
    on && /one of:$/ { lines = 1 }
    END {
      if (braces || lines) exit
      if (option !~ /^--(accuracy|border|coupling|device|load|order|profile|reach|timing|world-precision)$/) exit
      sub(/^[^:]*: /, "", text)
      sub(/([.] |[.] *$|[;(]).*/, "", text)
      gsub(/,? or /, ", ", text)
      n = split(text, values, ", ")
      for (i = 1; i <= n; ++i) offer(values[i])
    }'
}

_tactus() {
  local word=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} path=() i help commands values=
  for ((i = 1; i <= COMP_CWORD; i++)); do
    help=$(tactus "${path[@]}" --help 2>/dev/null)
    commands=$(sed -n '/^Subcommands:/,/^$/s/^  \([a-z][a-z-]*\) .*/\1/p' <<<"$help")
    grep -qxF -e "${COMP_WORDS[i]}" <<<"$commands" && ((i < COMP_CWORD)) || break
    path+=("${COMP_WORDS[i]}")
  done
  if [[ $previous == --* ]] && grep -qE -e "^  $previous [A-Z]" <<<"$help"; then  # an option that takes a value
    values=$(_tactus_values "$previous" <<<"$help" | sort -u)
  elif [[ $word != -* ]]; then
    values=$(sed -n '/^Positionals:/,/^$/{s/^  [A-Z]* [A-Z]*:{\([^}]*\)}.*/\1/p}' <<<"$help" | tr ',' '\n')
  fi
  if [[ -n $values ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$values" -- "$word")
  elif [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(grep -oE '^ +(-[a-z],)?--[a-z][a-z0-9-]*' <<<"$help" | grep -oE -- '--.*' | sort -u)" -- "$word")
  else
    mapfile -t COMPREPLY < <(compgen -W "$commands" -- "$word")
    if ((${#COMPREPLY[@]} == 0)); then mapfile -t COMPREPLY < <(compgen -f -- "$word"); fi
  fi
}
complete -o filenames -F _tactus tactus
