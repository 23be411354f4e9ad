# A hand presses on a floor through the whole host program; each fault comes while there is force. What counts is what
# the device's motors did, in control periods.
. /bench/lib.sh
start_device /bench/press.toml || exit
socket=/tmp/faults.sock
start_host /bench/press.toml --rearm --control $socket

last_lines() { tail -n 3 "$host_log" | tr '\r\n' '  ' | cut -c1-300; }
# in_words NAME WORDS: the fault's line says what it is and what to do.
in_words() {
  wait_for grep -q "FAULT at.*$2" "$host_log"
  verdict "$1: in words" "$(last_lines)"
}

# brakes NAME FADE: since the mark the device faded (FADE, or - where it brakes at once) and braked at 10 missed.
brakes() {
  await '^state FORCE BRAKE' || { not_ok "$1" "it never braked"; return 1; }
  brake=$(value missed)
  said '^fade' && fade=$(value missed) || fade=
  said '^zero' && zero=$(value missed) || zero=
  figure "$1" fade "${fade:--1}" && figure "$1" brake "$brake" && figure "$1" zero "${zero:--1}"
  [ "$fade" = 3 ] && [ "$brake" = 10 ] && [ "${zero:-99}" -le 10 ]
  verdict "$1: fades at 3 missed frames, brakes at 10" "fade ${fade:-never}, zero ${zero:-never}, brake $brake"
}

under_force force && ok "the hand feels the floor"

if presses; then
  before=$(value share)
  mark
  answer=$(tactus control rearm --socket $socket 2>&1)
  sleep 0.2
  ! said '^zero' && ! said '^fade' && ! said '^state FORCE' && report &&
    awk -v now="$(value share)" -v before="$before" 'BEGIN { exit !(now >= 0.5 * before) }'
  verdict "re-arm with nothing latched: the force stays" "share $before before; $line"
  [ "$answer" = 'nothing is latched: nothing was done' ]
  verdict "re-arm with nothing latched: is told" "$answer"
else
  not_ok 're-arm with nothing latched' "no force before: $(last_lines)"
fi

if under_force e-stop; then
  mark
  e_stop on
  await '^stop'
  periods=$(value periods)
  figure e-stop zero "${periods:--1}"
  [ "${periods:-99}" -le 2 ]
  verdict "e-stop: zero force within 2 ticks of the edge" "${periods:-never} periods"
  sleep 1.5
  report
  [ "$(value state)" = 3 ]
  verdict "e-stop: stays braked while it is pressed" "state $(value state)"
  e_stop off
fi

if under_force motor-bus; then
  mark
  tell 'motor-bus 0'
  await '^state FORCE BRAKE' && figure motor-bus zero 1
  verdict "motor supply fails: brakes" "it never braked"
  in_words "motor supply fails" "device fault 5: the motors' supply failed; restore it"
  tell 'motor-bus 1'
fi

if under_force overspeed; then
  mark
  tell 'jump 100000'
  await '^state FORCE BRAKE fault=3'
  verdict "an encoder that jumps: brakes" "$(last_lines)"
  in_words overspeed "device fault 3: an axis moved faster than its max_speed.*re-arm"
fi

if under_force unknown; then
  mark
  tell 'told_fault 63'
  await '^state FORCE BRAKE'
  verdict "a fault number that nobody knows: braked by the host" "$(last_lines)"
  in_words "an unknown fault" "device fault 63: this program does not know it; see the device's manual"
  tell 'told_fault 0'
fi

if presses; then
  mark
  tell 'lost_commands 5'
  sleep 0.2
  said '^fade'
  fade=$(value missed)
  ! said '^state FORCE BRAKE' && [ "$fade" = 3 ]
  verdict "five commands lost: fades and recovers" "$line"
  report
  awk -v share="$(value share)" -v rise="$(value largest_rise)" 'BEGIN { exit !(share >= 0.04 && rise <= 0.01) }'
  verdict "five commands lost: the force comes in again by the ramp, without a step" "$line"
else
  not_ok few-lost "no force before: $(last_lines)"
fi

# follows COMMAND WHAT: after each good command, in the same period, one that must not be obeyed.
follows() {
  under_force "$1" || return
  report
  refused=$(value refused)
  mark
  tell "$1 500"
  sleep 1
  ! said '^fade' && ! said '^state FORCE' && report && [ "$(value state)" = 2 ] &&
    [ $(($(value refused) - refused)) -ge 500 ]
  verdict "$2 follows each good one: the good one counts" "refused $refused before; $line"
}
follows old_commands 'an old command'
follows broken_followers 'a broken command'
follows nan_followers 'an old command with NaN'

if under_force commands-lost; then mark; tell 'lost_commands 15'; brakes commands-lost; fi
if under_force commands-corrupt; then mark; tell 'corrupt_commands 15'; brakes commands-corrupt; fi
if under_force commands-repeated; then mark; tell 'repeated_commands 15'; brakes commands-repeated; fi

if under_force unplugged; then
  mark
  cable out
  brakes unplugged
  sleep 0.5
  answer=$(tactus control rearm --socket $socket 2>&1)
  sleep 0.2
  tactus control state --socket $socket --json 2>&1 | grep -q '"fault":[1-9]' && echo "$answer" | grep -q 'if the device is the same'
  verdict "unplugged: a re-arm takes no fault back" "$answer"
  cable in
  in_force
  verdict "unplugged: goes on when it is back, after the re-arm" "no force again; $(tail -n 1 "$host_log")"
fi

if [ "$link" = can-fd ] && under_force bus-off; then
  mark
  # What a driver reports; then the bus is silent, which vcan cannot be by itself.
  cansend vcan0 20000040#0000000000000000
  cable out
  # The host, which heard of it, may ask for BRAKE before the watchdog acts.
  await '^state FORCE BRAKE' && brake=$(value missed) || brake=
  figure bus-off brake "${brake:--1}"
  [ "${brake:-99}" -le 10 ]
  verdict "bus-off: brakes at 10 missed frames at the latest" "${brake:-never}"
  cable in
  cansend vcan0 20000100#0000000000000000
  in_force
  verdict "bus-off: goes on after the restart" "no force again"
fi

if under_force host-killed; then
  mark
  kill -9 "$host_process"
  brakes host-killed
fi
stop_device faults
