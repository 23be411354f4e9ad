# What must hold before force is given again, and how it comes in: never as a step, never to another device.
. /bench/lib.sh
start_device /bench/press.toml || exit

last_lines() { tail -n 3 "$host_log" | tr '\r\n' '  ' | cut -c1-300; }
end_host() { kill "$host_process" 2>/dev/null; wait "$host_process" 2>/dev/null; }
log_says() { grep -q "$1" "$host_log"; }
# presses: until the motors give a twentieth of their limit, twenty seconds at the most. The largest step of their
# efforts on the way is in $rise, in shares of the limit.
presses() {
  rise=0 tries=100
  while [ $tries -gt 0 ]; do
    report
    rise=$(awk -v a="$rise" -v b="$(value largest_rise)" 'BEGIN { print (a > b ? a : b) }')
    awk -v share="$(value share)" 'BEGIN { exit !(share >= 0.05) }' && return 0
    host_lives || return 1
    tries=$((tries - 1))
    sleep 0.2
  done
  return 1
}
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

# A device that is reset under force.
for periods in 1 8; do
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

# Another device in its place, which its serial number tells.
if under_pressure 'another serial number'; then
  tell 'serial BENCH-2'
  tell 'restart 8'
  sleep 3
  report
  [ "$(value share)" = 0 ] && log_says "not armed.*serial number is 'BENCH-2'"
  verdict "another serial number: the re-arm is refused and says why" "share $(value share); $(last_lines)"
  tell 'serial BENCH-1'
  tell 'restart 8'
  report
  comes_in "its own serial number again"
fi

# changes NAME REGISTER VALUE: a register that changed while a fault was latched, of which the host may not take notice.
changes() {
  under_pressure "$1 changed" || return
  own=$(ask_device "$host" read "$2" | sed -n 's/value=//p')
  e_stop on
  sleep 0.2
  ask_device "$host" write "$2" "$3" >/dev/null || not_ok "$1 changed" "the device refuses it"
  e_stop off
  sleep 3
  report
  [ "$(value share)" = 0 ] && log_says "not armed.*$1.*(register $2)"
  verdict "$1 changed: the re-arm is refused and says why" "share $(value share); $(last_lines)"
  ask_device "$host" write "$2" "$own" >/dev/null
  report
  comes_in "$1 written back"
}
# Over USB the host alone can ask.
if [ "$link" != usb ]; then
  changes max_force 0x0130 0x49742400     # 1e6 N
  changes max_effort 0x0110 0x49742400    # of axis 0
  changes quantum 0x0100 0x3a83126f       # of axis 0: 1 mm
  changes brake_frames 0x0134 250
fi
end_host

# Homing that is demanded.
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
stop_device recovery
