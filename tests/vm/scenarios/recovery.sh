# What must hold before force is given again, and how it comes in: never as a step, never to another device.
. /bench/lib.sh
start_device /bench/press.toml || exit

last_lines() { tail -n 3 "$host_log" | tr '\r\n' '  ' | cut -c1-300; }
end_host() { kill "$host_process" 2>/dev/null; wait "$host_process" 2>/dev/null; }
log_says() { grep -q "$1" "$host_log"; }
# under_pressure NAME: the precondition of every fault.
under_pressure() { presses || { not_ok "$1" "no force before: $(last_lines)"; return 1; }; }
# comes_in NAME: there is force again, and no step of it above a hundredth of the limit.
comes_in() {
  presses
  verdict "$1: force again" "$(last_lines)"
  awk -v rise="$rise" 'BEGIN { exit !(rise <= 0.01) }'
  verdict "$1: it comes in without a step" "a step of $rise of the limit"
}
is_idle() { report && [ "$(value state)" = 1 ] && [ "$(value fault)" = 0 ]; }

# Registers, before a run has the device.
answers() { grep -Eq "$1" /tmp/answer; }
asks() { tactus device ask --device "$host" "$@" >/tmp/answer 2>&1; }
if [ "$link" != can-fd ]; then
  asks read serial period fade_frames && answers 'serial.0. +0x434e4542' && answers ' 1000 us' && answers 'fade_frames +3 '
  verdict "device ask reads registers" "$(cat /tmp/answer)"
  asks write fade_frames 4 && answers 'fade_frames +4 ' && asks read fade_frames && answers 'fade_frames +4 '
  verdict "device ask writes one" "$(cat /tmp/answer)"
  asks write fade_frames 254
  [ $? = 3 ] && answers 'fade_frames: refused: the value'
  verdict "what does not go with another register is refused in words" "$(cat /tmp/answer)"
  asks execute factory && asks read fade_frames && answers 'fade_frames +3 '
  verdict "device ask executes a command" "$(cat /tmp/answer)"
fi

# The end of a run, and the beginning of the next.
start_host /bench/press.toml
presses
verdict "a run feels the floor" "$(last_lines)"
end_host
sleep 0.5
is_idle
verdict "a run that is stopped leaves the device in IDLE without fault" "$line"
tell 'hand restart'
tactus run /bench/press.toml --device "$host" --duration 1.5 >"/out/recovery-$link.log" 2>&1
grep -q '^faults *none' "/out/recovery-$link.log"
verdict "the next run begins without fault" "$(grep -A 2 '^faults' "/out/recovery-$link.log")"
is_idle
verdict "a run that ends by its duration leaves the device in IDLE without fault" "$line"

# Endpoints that halt.
if [ "$link" = usb ]; then
  ask_device usb halt
  verdict "both endpoints are halted while nobody uses them" "ask_device failed"
fi
tell 'hand restart'
start_host /bench/press.toml --rearm
presses
verdict "force at the start" "$(last_lines)"
if [ "$link" = usb ]; then
  for endpoint in halt_states halt_commands; do
    for again in 1 2 3; do tell $endpoint; sleep 0.1; done
    host_lives && presses
    verdict "$endpoint: cleared, and force" "$(last_lines)"
    ! log_says 'unplugged'
    verdict "$endpoint: not called unplugged" "$(last_lines)"
  done
fi

# Periods that a reset lasts, and registers that change with their new values; with --quick fewer.
resets='1 8'
registers='fade_frames:0x0133:2 max_torque:0x0131:0x3c23d70a max_force:0x0130:0x49742400
  max_effort:0x0110:0x49742400 quantum:0x0100:0x3a83126f'
if [ -n "$QUICK" ]; then resets=8 registers=max_force:0x0130:0x49742400; fi

# A device that is reset under force.
for periods in $resets; do
  presses
  before=$(grep -c 'FAULT at' "$host_log")
  mark
  tell "restart $periods"
  await '^state RESET IDLE' && began=$(value period)
  await '^state [A-Z]* BRAKE' && braked=$((($(value period)) - began)) || braked=
  figure "reset-$periods" brake "${braked:--1}"
  # One period for the host's answer to the first state, and one because the first command after a reset only starts a
  # sequence and is not obeyed (PROTOCOL.md), where no command reached the device in the period of that state. Over USB
  # the answer to a state comes two periods after it, and every fourth state in one with the next.
  case $link in usb) most=4 ;; *) most=2 ;; esac
  [ "${braked:-99}" -le $most ]
  verdict "reset of $periods periods: the host brakes it $most periods after it is back at the latest" "${braked:-never}"
  sleep 0.5
  [ "$(grep -c 'FAULT at' "$host_log")" -gt "$before" ]
  verdict "reset of $periods periods: a fault in words" "$(last_lines)"
  report
  awk -v rise="$(value largest_rise)" 'BEGIN { exit !(rise <= 0.01) }'
  verdict "reset of $periods periods: no step before the brake" "a step of $(value largest_rise) of the limit"
  comes_in "reset of $periods periods"
done

# A device that leaves FORCE without a reset: another program tells it to idle.
if under_pressure 'told to idle by another'; then
  before=$(grep -c 'FAULT at' "$host_log")
  mark
  tell 'idle_commands 8'
  await '^state FORCE IDLE' && began=$(value period)
  await '^state IDLE BRAKE' && braked=$((($(value period)) - began)) || braked=
  figure left-force brake "${braked:--1}"
  case $link in usb) most=4 ;; *) most=2 ;; esac
  [ "${braked:-99}" -le $most ]
  verdict "told to idle by another: the host brakes it $most periods later at the latest" "${braked:-never}"
  sleep 0.5
  [ "$(grep -c 'FAULT at' "$host_log")" -gt "$before" ] && grep 'FAULT at' "$host_log" | tail -n 1 | grep -q 'left FORCE'
  verdict "told to idle by another: a fault in words" "$(last_lines)"
  comes_in "told to idle by another"
fi

# no_force_and NAME SECONDS PATTERN: the host's log says PATTERN, and SECONDS later there is no force.
no_force_and() {
  wait_for log_says "$3"
  heard=$?
  sleep "$2"
  report
  [ $heard = 0 ] && [ "$(value share)" = 0 ]
  verdict "$1" "share $(value share); $(last_lines)"
}
# is_refused NAME WORDS: a re-arm is refused and says why, and there is no force.
is_refused() { no_force_and "$1: the re-arm is refused and says why" 0.3 "not armed.*$2"; }
# no_escape NAME: what a device calls itself reaches no terminal as it is.
no_escape() {
  ! grep -q "$(printf '\033')" "$host_log"
  verdict "$1: no escape character in what is printed" "$(grep "$(printf '\033')" "$host_log" | head -n 1 | od -c | head -n 3)"
}

# Another device in its place, told by what it says of itself.
if under_pressure 'another device'; then
  tell 'serial BENCH-2'
  tell 'restart 8'
  is_refused "another serial number" "serial number is 'BENCH-2'"
  tell "serial $(printf 'B\033[31m3')"
  tell 'restart 8'
  is_refused "a serial number with an escape character" "serial number is 'B.x1b.31m3'"
  no_escape "a serial number with an escape character"
  tell 'serial BENCH-1'
  if [ -z "$QUICK" ]; then
    tell 'class 1'
    tell 'restart 8'
    is_refused "another class" 'device_class (register 0x0003) is 1, .* with 2'
    tell 'class 2'
  fi
  tell 'period_us 2000'
  tell 'restart 8'
  is_refused "another control period" 'period (register 0x0132) is 2000, .* with 1000'
  tell 'period_us 1000'
  tell 'restart 8'
  report
  comes_in "the same device again"
fi

# Another device in its USB port: not unplugged, but another one.
in_the_port() {
  cable out
  printf %s "$1" >/sys/kernel/config/usb_gadget/tactus/strings/0x409/serialnumber
  cable in
}
if [ "$link" = usb ] && under_pressure 'another device in the port'; then
  in_the_port BENCH-2
  is_refused "another device in the port" 'no USB device with serial BENCH-1; there are: serial BENCH-2'
  in_the_port "$(printf 'B\033[31m3')"
  is_refused "one whose serial number has an escape character" 'there are: serial B.x1b.31m3'
  no_escape "one whose serial number has an escape character"
  in_the_port BENCH-1
  report
  comes_in "the same device in the port again"
fi

# Registers that changed while a fault was latched - on USB while it was unplugged - or that another program writes
# before the re-arm. The run tells the first one in the order of its record, which is the other way round here.
changes() {
  if [ "$link" = usb ]; then as_another write "$2" "$3"; else ask_device "$host" write "$2" "$3" >/dev/null; fi ||
    not_ok "$1 changed" "the device refuses it"
}
is_told() { is_refused "$1 changed" "$1.*(register $2)"; }
if under_pressure 'registers changed'; then
  case $link in usb) cable out ;; *) e_stop on ;; esac
  sleep 0.2
  changes brake_frames 0x0134 250
  case $link in usb) cable in ;; *) e_stop off ;; esac
  is_told brake_frames 0x0134
  for each in $registers; do
    name=${each%%:*} number=${each#*:}
    number=${number%:*}
    changes "$name" "$number" "${each##*:}"
    is_told "$name" "$number"
  done
  as_another execute 0x0801 0  # as it was built
  report
  comes_in "the registers written back"
fi

# Homing that is demanded while the run has a fault, and done in the run.
if under_pressure 'homing in a run'; then
  e_stop on
  sleep 0.2
  as_another write 0x0252 1
  e_stop off
  no_force_and "homing demanded in a run: no force, and a fault in words" 2 'refuses FORCE.*limit 76'
  as_another execute 0x0802 2
  verdict "homing demanded in a run: the device is homed, its counts jump" "$line"
  report
  comes_in "homed in the run"
fi
end_host

# What a summary cannot list it counts: 16 events, a fault or a re-arm each.
faults=$(sed -n 's/^faults *\([0-9]*\)$/\1/p' "$host_log")
dropped=$(sed -n 's/^ *\([0-9]*\) events\{0,1\}, faults and re-arms, not listed$/\1/p' "$host_log")
[ "${faults:-0}" -gt 8 ] && [ "$((16 + ${dropped:-0}))" -ge "$((2 * faults - 1))" ] && [ "$((16 + dropped))" -le "$((2 * faults))" ]
verdict "more faults than are listed: the summary says how many" "${faults:-no} faults, ${dropped:-none} not listed"

# Homing that is demanded from the start, and forgotten; with --quick only in a run, above.
if [ -z "$QUICK" ]; then
  as_another execute 0x0802 0
  ask_device "$host" write 0x0252 1 >/dev/null
  tell 'hand restart'
  report
  start_host /bench/press.toml
  sleep 2
  report
  [ "$(value share)" = 0 ] && log_says 'refuses FORCE.*limit 76'
  verdict "homing demanded: no force, and a fault in words" "share $(value share); $(last_lines)"
  end_host
  ask_device "$host" write 0x0252 0 >/dev/null
  tell 'hand restart'
  start_host /bench/press.toml
  comes_in "homing no longer demanded"
  end_host
fi

# Stops while the link is not there, or just comes back.
socket=/tmp/recovery.sock
host_is_gone() { ! host_lives; }
asks_to_stop() { case $1 in SIGTERM) kill "$host_process" ;; control) tactus control stop --socket $socket >/dev/null ;; esac; }
# stops_in_reconnect HOW [S]: HOW the run is stopped, so long after the cable came back in; not in without it.
stops_in_reconnect() {
  tell 'hand restart'
  tell 'restart 1'
  start_host /bench/press.toml --control $socket
  under_pressure "stop by $1" || return
  cable out
  wait_for log_says unplugged
  when='while unplugged'
  if [ -n "$2" ]; then
    when="$2 s after the plug"
    cable in
    sleep "$2"
  fi
  asks_to_stop "$1"
  wait_for host_is_gone || kill -9 "$host_process"
  wait "$host_process"
  status=$?
  [ -n "$2" ] || cable in
  [ $status = 1 ] && log_says '^verdict\|^faults'
  verdict "stop by $1 ${when}: it ends in order" "status $status: $(last_lines)"
}
if [ "$link" = usb ]; then
  stops_in_reconnect SIGTERM
  stops_in_reconnect control 0.1
  for after_s in 0 0.2; do stops_in_reconnect SIGTERM $after_s; done
fi
stop_device recovery
