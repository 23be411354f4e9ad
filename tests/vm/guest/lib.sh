# What the scenarios are written with: verdicts, the device of the bench, the host program, faults. Sourced in the guest.
# shellcheck shell=sh
#
# Verdicts are lines on standard output: `ok NAME`, `not ok NAME: why`, `skip NAME: why`. Figures go to /out/figures,
# a line each: LINK FAULT WHAT NUMBER.

bench=/bench
export BENCH_CONTROL=/tmp/control BENCH_LOG=/tmp/device.log
gpio=/sys/devices/platform/gpio-sim.0/gpiochip0

ok() { echo "ok $link: $1"; }
not_ok() { echo "not ok $link: $1: $2"; }
skip() { echo "skip $link: $1: $2"; }
# verdict NAME WHY: after a command; WHY says what was wrong.
verdict() { if [ $? = 0 ]; then ok "$1"; else not_ok "$1" "$2"; fi; }
figure() { echo "$link $1 $2 $3" >>/out/figures; }

# The names of LINK (usb, can, can-fd) at the device and at the host.
device_of() { case $1 in usb) echo usb ;; can) echo can:can1 ;; can-fd) echo can-fd:vcan0 ;; esac; }
host_of() { case $1 in usb) echo usb ;; can) echo can:can0 ;; can-fd) echo can:vcan0 ;; esac; }

# start_device SCENE [OPTION...]: the device on $link; back when the host can find it.
start_device() {
  export BENCH_LINK=$link
  host=$(host_of "$link")
  [ -p $BENCH_CONTROL ] || mkfifo $BENCH_CONTROL
  scene=$1
  shift
  : >$BENCH_LOG
  for pull in $gpio/sim_gpio*/pull; do echo pull-down >"$pull"; done  # as nobody's hand left them
  bench_device "$(device_of "$link")" --scene "$scene" "$@" --control $BENCH_CONTROL --stop-line 3 --priority 90 >$BENCH_LOG 2>&1 &
  device=$!
  mark=0
  await '^ready' || { not_ok device "did not start: $(tail -n 1 $BENCH_LOG)"; return 1; }
  [ "$link" != usb ] || wait_for usb_is_there
}

usb_is_there() { grep -qs BENCH-1 /sys/bus/usb/devices/*/serial; }

stop_device() {
  kill "$device" 2>/dev/null
  wait "$device" 2>/dev/null
  cp $BENCH_LOG "/out/device-$link-$1.log"
}

# wait_for COMMAND...: until it is true, $patience tenths of a second at the most, three seconds if that is not set. Looks
# seldom: an emulated process costs as much as a device's period.
wait_for() {
  tries=${patience:-30}
  until "$@"; do
    tries=$((tries - 1))
    [ $tries -gt 0 ] || return 1
    sleep 0.1
  done
}

# What the device tells from now on is what await looks at.
mark() { mark=$(wc -l <$BENCH_LOG); }
said() {
  line=$(awk -v mark="$mark" -v pattern="$1" 'NR > mark && $0 ~ pattern { print; exit }' $BENCH_LOG)
  [ -n "$line" ]
}
# await PATTERN: the first such line since the mark, into $line.
await() { wait_for said "$1"; }
# value KEY: of KEY=NUMBER in $line; nothing if it is not there.
value() { echo "$line" | sed -n "s/.* $1=\([^ ]*\).*/\1/p"; }

# tell COMMAND: to the device; back when it is done.
tell() {
  done_before=$(grep -c '^done' $BENCH_LOG)
  echo "$1" >$BENCH_CONTROL
  wait_for told
}
told() { [ "$(grep -c '^done' $BENCH_LOG)" -gt "$done_before" ]; }

# The device's truth now, into $line.
report() { tell report && line=$(awk '/^report/ { last = $0 } END { print last }' $BENCH_LOG); }

# as_another read|write|execute REGISTER [VALUE]: the device's answer, as another program would have it, into $line.
as_another() {
  tell "$*" && line=$(awk '/^answered/ { last = $0 } END { print last }' $BENCH_LOG) && [ "$(value status)" = 0 ]
}

e_stop() { case $1 in on) echo pull-up ;; off) echo pull-down ;; esac >$gpio/sim_gpio3/pull; }

# The cable of $link: out or in.
cable() {
  interface=${host#can:}
  case $link:$1 in
    usb:out) tell unplug ;;
    usb:in) tell plug ;;
    *:out) ip link set "$interface" down ;;
    *:in) ip link set "$interface" up ;;
  esac
}

# start_host ARGUMENT...: the real-time run, in the background, into $host_log.
start_host() {
  host_log=/out/host-$link.log
  tactus run "$@" --device "$host" >"$host_log" 2>&1 &
  host_process=$!
}
host_lives() { kill -0 "$host_process" 2>/dev/null; }

# Until the hand feels a force, ten seconds at the most: a latched fault is taken back a second after it came.
in_force() {
  mark
  report
  pushes_now && return 0
  patience=100
  wait_for force_or_death
  patience=
  said '^force'
}
force_or_death() { said '^force' || ! host_lives; }
# Do the motors push, by the report in $line? A scenario with a bench of its own has its own.
pushes_now() { [ "$(value state)" = 2 ] && [ "$(value share)" != 0 ]; }
# under_force NAME: the precondition of every fault.
under_force() { in_force || { not_ok "$1" "no force before the fault: $(tail -n 1 "$host_log")"; return 1; }; }

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

# zero_within BENCH NAME KEY LIMIT: since the mark the bench's motors got no force any more, KEY (after, silent) periods
# later.
zero_within() {
  await '^zero' && periods=$(value "$3") || periods=
  figure "$1-$2" zero "${periods:--1}"
  [ "${periods:-99999}" -le "$4" ]
  verdict "$1: $2: no force after ${periods:-no} periods" "more than $4"
}
# fault_under_force BENCH NAME LIMIT COMMAND: what the bench is told under force takes the force in LIMIT periods.
fault_under_force() {
  under_force "$2" || return
  mark
  tell "$4"
  zero_within "$1" "$2" after "$3"
}

# hil_verdicts LOG [WHAT]: a line per check of `tactus hil`: its name, good, bad or skipped, what was measured.
hil_verdicts() {
  sed -n 's/^ *\([a-z-]*\) *\(good\|bad\|skipped\) */\1 \2 /p' "$1" >/tmp/checks
  while read -r name word text; do
    case $word in
      good) ok "${2:+$2: }hil $name ($text)" ;;
      bad) not_ok "${2:+$2: }hil $name" "$text" ;;
      skipped) skip "${2:+$2: }hil $name" "$text" ;;
    esac
  done </tmp/checks
}
