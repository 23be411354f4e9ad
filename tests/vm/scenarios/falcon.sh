# A Novint Falcon over libusb: its chip and firmware are a USB device of the guest. The image is loaded, the grip homed,
# the suite and the card house run, each fault and each way out comes while a hand presses on a floor. The device has no
# watchdog: what counts is that its motors get zeros, and after how many of its periods.
. /bench/lib.sh
host=falcon
# The scenes' coupling is too stiff for what is known of a Falcon's damping, and its workspace of 10 cm is put where the
# house has its top.
for scene in press card_house; do
  awk '/^\[coupling\]/ { here = 1 } /^\[/ && !/^\[coupling\]/ { here = 0 }
    here && /^stiffness_N_per_m/ { $0 = "stiffness_N_per_m = 250" } here && /^damping_Ns_per_m/ { $0 = "damping_Ns_per_m = 0.5" }
    /^position_m = \[0, 0, 0.19\]/ { $0 = "position_m = [0, 0, 0.35]" } { print }' /bench/$scene.toml >/tmp/$scene.toml
done
head -c 3000 /bin/busybox >/tmp/image.bin

# start_falcon OPTION...: back when the host can find it.
start_falcon() {
  [ -p $BENCH_CONTROL ] || mkfifo $BENCH_CONTROL
  : >$BENCH_LOG
  bench_falcon "$@" --control $BENCH_CONTROL >$BENCH_LOG 2>&1 &
  device=$!
  mark=0
  await '^ready' || { not_ok falcon "it did not start: $(tail -n 1 $BENCH_LOG)"; return 1; }
  wait_for falcon_is_there || { not_ok falcon "no host sees it"; return 1; }
}
falcon_is_there() { grep -qs FALCON-1 /sys/bus/usb/devices/*/serial; }

pushes_now() { [ "$(value force_N)" != 0 ]; }

# --- from power-on
start_falcon --scene /tmp/card_house.toml || exit
tactus hil --device falcon --yes >"/out/falcon-empty.log" 2>&1
[ $? = 3 ] && grep -q 'no firmware runs in the Falcon' /out/falcon-empty.log
verdict "falcon: without its firmware it says what is wanted" "$(tail -n 1 /out/falcon-empty.log)"
tell 'homed 3'
(sleep 2 && tell 'homed 7') &
tactus hil --device falcon:/tmp/image.bin --yes --force 1 --timing report --junit /out/hil-falcon.xml >/out/hil-falcon.log 2>&1
[ $? -le 1 ]
verdict "falcon: the image is loaded, the grip homed, hil runs" "$(tail -n 1 /out/hil-falcon.log)"
wait $!
report
[ "$(value image)" = 3000 ]
verdict "falcon: it got each byte of the image" "$line"
hil_verdicts /out/hil-falcon.log falcon
stop_device falcon-hil

# --- the USB port that it is chosen by
start_falcon --loaded 1 || exit
port=$(grep -ls FALCON-1 /sys/bus/usb/devices/*/serial | sed 's#.*devices/\([^/]*\)/.*#\1#')
tactus hil --device "falcon:@$port" --yes --only identity >/out/falcon-port.log 2>&1 && grep -q "at USB port $port" /out/falcon-port.log
verdict "falcon: it is opened by its USB port, $port" "$(tail -n 1 /out/falcon-port.log)"
tactus hil --device falcon:@9-9 --yes >/out/falcon-no-port.log 2>&1
[ $? = 3 ] && grep -q "no Falcon is plugged into USB port 9-9; accepted: where there is one: $port" /out/falcon-no-port.log
verdict "falcon: at another port it says where there is one" "$(tail -n 1 /out/falcon-no-port.log)"
stop_device falcon-port

# --- minutes of emulation, which --quick leaves out
if [ -z "$QUICK" ]; then
  # --- the force gain: the readings of a scale below a Falcon that gives half of what it is taken for, at a hand at rest
  start_falcon --loaded 1 || exit
  printf 'none\n12\n\n38\n\n112\n\n165\n\n216\n12\n' |
    tactus hil --calibrate --device falcon:,5000 --yes --out /tmp/gain.toml >/out/falcon-gain.log 2>&1
  grep -q '^name = "falcon:,10020"' /tmp/gain.toml
  verdict "falcon: hil --calibrate finds its force gain" "$(tail -n 1 /out/falcon-gain.log)"
  report
  awk -v most="$(value largest_N)" 'BEGIN { exit !(most >= 1.9 && most <= 2.1) }' && [ "$(value force_N)" = 0 ]
  verdict "falcon: the scale's pushes reach 2 N at its motors, and zeros at the end" "$line"
  stop_device falcon-gain

  # --- the card house
  start_falcon --loaded 1 --scene /tmp/card_house.toml || exit
  tactus run /tmp/card_house.toml --device falcon --duration "${HOUSE_S:-1.2}" >/out/falcon-house.log 2>&1
  verdict "falcon: card house runs at 1000 Hz" "exit status $?; $(tail -n 1 /out/falcon-house.log)"
  contact=$(sed -n 's/^ *in contact *\([0-9.]*\) %.*/\1/p' /out/falcon-house.log)
  awk -v share="${contact:-0}" 'BEGIN { exit !(share >= 30) }'
  verdict "falcon: card house is touched (${contact:-0} % of the ticks)" "less than 30 %"
  report
  [ "$(value largest_N)" != 0 ] && [ "$(value force_N)" = 0 ]
  verdict "falcon: its force reaches the motors, and zeros at the end" "$line"
  stop_device falcon-house
fi

# --- ways out
ways='INT TERM HUP'
if [ -n "$QUICK" ]; then ways=INT; fi
for way in $ways; do
  start_falcon --loaded 1 --scene /tmp/press.toml || exit
  start_host /tmp/press.toml
  if under_force "SIG$way"; then
    mark
    kill -$way "$host_process"
    wait "$host_process"
    report
    [ "$(value force_N)" = 0 ]
    verdict "falcon: SIG$way: zeros before the program ends" "$line"
  fi
  stop_device "falcon-$way"
done

# --- faults
start_falcon --loaded 1 --scene /tmp/press.toml || exit
start_host /tmp/press.toml --rearm
under_force force && ok "falcon: the hand feels the floor"
fault_under_force falcon homing-lost 20 'homed 3'
tell 'homed 7'
for fault in garbage twice; do
  if under_force $fault; then
    mark
    tell "$fault 1"
    sleep 0.3
    ! said '^zero' && host_lives
    verdict "falcon: $fault: packets with bytes between them, or two for one: the force stays" "$line"
    tell "$fault 0"
  fi
done
# again NAME: it answers again, and there is force.
again() {
  in_force
  verdict "falcon: $1: force again after the re-arm" "$(tail -n 1 "$host_log")"
}
fault_under_force falcon cut 20 'cut 1'
tell 'cut 0'
again cut
# A device that hears nothing keeps its last force: the fault is told, and the first packet that it hears is zero.
if under_force mute; then
  faults=$(grep -c 'FAULT at' "$host_log")
  tell 'mute 1'
  sleep 0.5
  [ "$(grep -c 'FAULT at' "$host_log")" -gt "$faults" ] && host_lives
  verdict "falcon: mute: a fault in words" "$(tail -n 1 "$host_log")"
  mark
  tell 'mute 0'
  zero_within falcon mute-ends after 10
  again mute
fi
if under_force unplugged; then
  mark
  tell unplug
  sleep 0.2
  tell plug
  sleep 1
  host_lives && [ -n "$host_process" ]
  verdict "falcon: unplugged: the host lives and says so" "$(tail -n 1 "$host_log")"
fi
kill -INT "$host_process"
wait "$host_process"
cp "$host_log" /out/host-falcon.log
stop_device falcon-faults
