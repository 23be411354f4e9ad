# An arm of CAN drives over the kernel's sockets: three MIT drives on one classic bus, or six moteus on two CAN FD buses.
# Each drive is a process of its own on its bus, beside one for the mechanics. The card house at 1 kHz, the hardware-in-the-loop suite, then each fault of a drive while a hand presses on a floor.
# What counts is what the drives were told to push, in periods of 1 ms.
. /bench/lib.sh
case $link in
  can) file=/bench/point_arm_drives.toml at_host=can0 at_drives=can1 drives=3 ;;
  can-fd) file=/bench/wristed_arm_moteus.toml at_host=vcan0,vcan1 at_drives=vcan0,vcan1 drives=6 ;;
esac
if [ "$link" = can-fd ] && [ ! -e /sys/class/net/vcan1 ]; then
  ip link add vcan1 type vcan
  ip link set vcan1 mtu 72 up
fi
host=drives:$at_host
arm="--device-file $file"

# start_drives SCENE [OPTION...]: back when they answer; in $processes, one or each.
processes=each
start_drives() {
  [ -p $BENCH_CONTROL ] || mkfifo $BENCH_CONTROL
  scene=$1
  shift
  : >$BENCH_LOG
  bench_drives $file $at_drives --scene "$scene" --processes $processes "$@" --control $BENCH_CONTROL >$BENCH_LOG 2>&1 &
  device=$!
  mark=0
  await '^ready' || { not_ok drives "they did not start: $(tail -n 1 $BENCH_LOG)"; return 1; }
}
stop_drives() { stop_device "drives-$1"; }

pushes_now() { [ "$(value share)" != 0 ] && [ "$(value enabled)" != 0 ]; }
# a_fault NAME KIND AXIS PERIODS LIMIT
a_fault() { fault_under_force drives "$1" "$5" "fault $2 $3 $4"; }

# --- the card house
start_drives /bench/card_house.toml || exit
[ "$(pidof bench_drives | wc -w)" = $((drives + 1)) ]
verdict "drives: each of $drives has a process of its own, beside the mechanics" "$(pidof bench_drives)"
for each in $(echo $at_host | tr , ' '); do candump -x -t z "$each" >"/tmp/candump-$each" 2>&1 & done
tactus run /bench/card_house.toml --device "$host" $arm --duration "${HOUSE_S:-1.2}" >"/out/arm-house-$link.log" 2>&1
verdict "drives: card house runs at 1000 Hz" "exit status $?; $(tail -n 1 "/out/arm-house-$link.log")"
killall -q candump
# How the arm is opened, and frames under force, to be read.
for each in $(echo $at_host | tr , ' '); do sed -n '1,60p;4001,4060p' "/tmp/candump-$each" >"/out/candump-$each.txt"; done
contact=$(sed -n 's/^ *in contact *\([0-9.]*\) %.*/\1/p' "/out/arm-house-$link.log")
awk -v share="${contact:-0}" 'BEGIN { exit !(share >= 30) }'
verdict "drives: card house is touched (${contact:-0} % of the ticks)" "less than 30 %"
report
awk -v share="$(value largest_share)" 'BEGIN { exit !(share > 0 && share <= 1) }'
verdict "drives: its force reaches the drives, within their range" "$line"
[ "$(value enabled)" = 0 ]
verdict "drives: they are disabled when the run has ended" "$line"
stop_drives house

# --- the suite
start_drives /bench/press.toml --hand still || exit
tactus hil --device "$host" $arm --yes --force 1 --timing report \
  --junit "/out/hil-drives-$link.xml" >"/out/hil-drives-$link.log" 2>&1
[ $? -le 1 ]
verdict "drives: hil runs" "$(tail -n 1 "/out/hil-drives-$link.log")"
hil_verdicts "/out/hil-drives-$link.log" drives
stop_drives hil

# --- faults
start_drives /bench/press.toml || exit
start_host /bench/press.toml $arm --rearm
under_force force && ok "drives: the hand feels the floor"
a_fault fault-flag fault-flag 1 1 3
a_fault disabled disabled 1 1 3
wait_for grep -q 'axis 1 is not enabled any more: it has restarted, or another program stopped it' "$host_log"
verdict "drives: disabled: in words" "$(tail -n 3 "$host_log")"
a_fault no-answer no-answer 1 30 11
a_fault no-answer-all no-answer all 30 11
a_fault no-command no-command all 30 11
if [ -z "$QUICK" ]; then
  a_fault foreign-id foreign-id 1 30 11
  a_fault undefined-id undefined-id 1 30 11
fi
a_fault short-frame short 1 30 11
# The field of an MIT frame wraps: the answer of the next period, and ten samples that are refused.
if [ "$link" = can ]; then
  a_fault wrapped wrapped 1 30 12
  wait_for grep -q 'FAULT at.*\(moved faster than it can\|outside its workspace\)' "$host_log"
  verdict "drives: wrapped: in words" "$(tail -n 3 "$host_log")"
fi
# No drive echoes a number: answers that all come two periods late look like others after a gap of two. The speed comes
# from the positions, so that a speed field at its end changes nothing.
steady='twice late speed'
if [ -n "$QUICK" ]; then steady=late; fi
for fault in $steady; do
  if under_force $fault; then
    mark
    tell "fault $fault all 100"
    sleep 0.2
    ! said '^zero' && host_lives
    verdict "drives: $fault: the force stays" "$line"
  fi
done
if under_force bus-off; then
  mark
  # What a driver reports of bus-off comes on vcan alone; on both the bus is then silent.
  [ "$link" = can ] || cansend vcan0 20000040#0000000000000000
  ip link set "${at_host%%,*}" down
  zero_within drives bus-off silent 11
  sleep 0.3
  ip link set "${at_host%%,*}" up
  in_force
  verdict "drives: bus-off: force again after the re-arm" "$(tail -n 1 "$host_log")"
fi
if under_force host-stopped; then
  mark
  kill -STOP "$host_process"
  zero_within drives host-stopped silent 10
  kill -CONT "$host_process"
  in_force
  verdict "drives: host stopped: force again after the re-arm" "$(tail -n 1 "$host_log")"
fi
if under_force host-killed; then
  mark
  kill -9 "$host_process"
  zero_within drives host-killed silent 10
fi
stop_drives killed
start_drives /bench/press.toml || exit
start_host /bench/press.toml $arm --rearm
[ "$link" = can ] || a_fault restarted-soon restarted 1 5 8
a_fault restarted restarted 1 30 11
if [ "$link" = can ]; then  # a Damiao loses what was written into it
  sleep 3
  mark
  ! said '^force'
  verdict "drives: a drive that restarted gets no force again" "$line"
  grep -q 'the drive has restarted' "$host_log"
  verdict "drives: and the host says why" "$(tail -n 3 "$host_log")"
fi
kill -INT "$host_process"
wait "$host_process"
report
[ "$(value enabled)" = 0 ]
verdict "drives: SIGINT leaves them disabled" "$line"
cp "$host_log" "/out/host-drives-$link.log"
stop_drives faults

# --- point arms of the families whose frames are neither MIT's nor moteus': described by the program, then the ways in
# which force ends
[ "$link" = can ] || exit 0
processes=one
# The coupling that these carry without damping in the drive, and contacts that 800 Hz resolve.
awk '/^\[coupling\]/ { here = 1 } /^\[/ && !/^\[coupling\]/ { here = 0 }
  here && /^stiffness_N_per_m/ { $0 = "stiffness_N_per_m = 200" } here && /^damping_Ns_per_m/ { $0 = "damping_Ns_per_m = 0.22" }
  { print } /^\[simulation\]/ { print "contact_hertz_Hz = 200" }' /bench/press.toml >/tmp/soft.toml
# arm_of FAMILY BUSES RATE TOLD [OPTION...]: BUSES at host and drives; RATE in Hz, as far as one bus goes; TOLD: periods
# until a drive has told that it is out; OPTION of the description.
arm_of() {
  family=$1 rate=$3 told=$4 host=drives:${2%:*} at_drives=${2#*:}
  shift 4
  file=/tmp/$family.toml
  tactus device new --kind point_arm --family "$family" --rate "$rate" "$@" --overwrite --out "$file" >/tmp/new 2>&1
  verdict "$family: the description is written" "$(tail -n 1 /tmp/new)"
  start_drives /tmp/soft.toml --rate "$rate" || return
  start_host /tmp/soft.toml --device-file "$file" --rate "$rate" --rearm
  under_force force && ok "$family: the hand feels the floor"
  for fault in fault-flag:1:$told disabled:1:$told no-answer:1:11 no-command:all:11 short:1:11; do
    kind=${fault%%:*} most=${fault##*:} axis=${fault#*:}
    fault_under_force "$family" "$kind" "$most" "fault $kind ${axis%:*} 30"
  done
  if under_force host-killed; then
    mark
    kill -9 "$host_process"
    zero_within "$family" host-killed silent 10
  fi
  cp "$host_log" "/out/host-$family.log"
  stop_drives "$family"
}
arm_of robstride can0:can1 800 3 --buses can0
# Three ODrives send their positions and heartbeats in the same moment; the emulated bus takes no time, so that a
# controller's few buffers are full before the kernel looks. vcan has no such buffers. An ODrive tells
# that it is out in its heartbeat alone, every 100 ms.
if [ -z "$QUICK" ]; then arm_of odrive vcan0:vcan0 1000 102 --peak-force 5; fi
