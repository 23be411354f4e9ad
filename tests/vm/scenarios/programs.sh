# The programs of the Linux boards themselves, as a device has them: encoders and PWMs are files, e-stop, supply, short
# and a motor's direction are the kernel's GPIO lines through sysfs. `tactus hil` at zero force; then what the motors'
# files get, what survives a restart, how the programs end, and what they say when they cannot begin.
. /bench/lib.sh
host=$(host_of "$link")
folder=/tmp/board
log=$folder/log state=$folder/state mechanics=$folder/mechanics.txt
# Classic CAN slower than the others: the option of the board, and a bus with room to spare.
period_us=1000
case $link in
  usb) program=tactus_device_usb own="--serial BENCH-1" missing="--serial BENCH-1 --udc none" ;;
  can) program=tactus_device_can own="--interface can1" missing="--interface none" period_us=2000 ;;
  can-fd) program=tactus_device_can own="--interface vcan0" missing="--interface none" ;;
esac

# --- the board: e-stop, supply, short, direction of motor 0 are the lines 3 to 6

chip=$(dirname "$(grep -l gpio-sim /sys/class/gpio/gpiochip*/label)")
line_of() { echo /sys/class/gpio/gpio$(($(cat "$chip/base") + $1)); }
pull() { echo "pull-$2" >"$gpio/sim_gpio$1/pull"; }
level() { cat "$gpio/sim_gpio$1/value"; }
give_lines() {
  for each in 3:in 4:in 5:out 6:out; do
    path=$(line_of ${each%:*})
    echo "${path##*gpio}" >/sys/class/gpio/export && echo ${each#*:} >"$path/direction" || return
  done
}
put() { echo "$2" 1<>"$1"; }  # as the kernel's files: not empty in between
take_away() {
  kill -9 "$board" 2>/dev/null
  for each in 3 4 5 6; do
    path=$(line_of $each)
    echo "${path##*gpio}" >/sys/class/gpio/unexport
  done
}
trap take_away EXIT

rm -rf $folder
mkdir -p $folder
for each in 0 1 2; do
  mkdir $folder/motor$each
  for file in count$each direction$each motor$each/period motor$each/duty_cycle motor$each/enable; do
    put $folder/$file 0
  done
done
pull 3 down
pull 4 up
give_lines
verdict "lines through sysfs" "$(ls /sys/class/gpio | tr '\n' ' ')"
ln -sf "$(line_of 6)/value" $folder/direction0

# The host's desk3d: three rotary axes. axis N MAX_EFFORT MAX_SPEED
axis() {
  echo "axis$1.count = $folder/count$1"
  echo "axis$1.quantum = 1.25663706e-4"
  echo "axis$1.max_speed = $3"
  echo "axis$1.pwm = $folder/motor$1"
  echo "axis$1.full_effort = 2.5"
  echo "axis$1.max_effort = $2"
  echo "axis$1.direction = $folder/direction$1"
}
{
  echo "device_class = 1"
  echo "max_force_N = 2.085"
  echo "pwm_period_ns = 50000"
  echo "stop_line = $(line_of 3)/value"
  echo "motor_bus = $(line_of 4)/value"
  echo "brake_line = $(line_of 5)/value"
  axis 0 2.085 25.74
  axis 1 1.396 23.07
  axis 2 1.396 23.07
} >$mechanics

ready() { grep -Eqs '^(device|node) ' $log; }
ready_or_dead() { ready || ! kill -0 "$board" 2>/dev/null; }
# start [OPTION...]: back when the host can find it.
start() {
  $program --mechanics $mechanics $own --state $state --period-us $period_us --priority 90 "$@" >$log 2>&1 &
  board=$!
  wait_for ready_or_dead
  ready && { [ "$link" != usb ] || wait_for usb_is_there; }
}
# SIGTERM; its exit status into $ended.
stop() {
  kill "$board"
  wait "$board"
  ended=$?
  cat $log >>"/out/programs-$link.log"
}

# What the device says, into $answer. says VALUE REGISTER; is WORDS: of a state frame.
# Limit 0x4000: no FORCE before a host has wanted IDLE, which none has since the device's last start.
ask() { answer=$(ask_device "$host" "$@" 2>&1); }
says() { ask read "$2" && [ "$answer" = "value=$1" ]; }
is() { ask state && case $answer in *"$1"*) ;; *) return 1 ;; esac; }
# motor DUTY DIRECTION SHORT: what the first motor has, into $motor.
motor() {
  read -r duty <$folder/motor0/duty_cycle
  motor="duty $duty ns, direction $(level 6), short $(level 5)"
  [ "$duty $(level 6) $(level 5)" = "$1 $2 $3" ]
}

# --- at rest, and the host's suite

start
verdict "$program begins" "$(tail -n 1 $log)"
read -r period <$folder/motor0/period
read -r enable <$folder/motor0/enable
[ "$period $enable" = "50000 1" ]
verdict "the PWM has its period and is on" "period $period, enable $enable"
wait_for is 'state=1 fault=0 limits=0x4000' && motor 0 0 0
verdict "it is IDLE, motors free and without effort" "$answer; $motor"
put $folder/count0 120
put $folder/count1 4294967246  # -50 in 32 bits
wait_for is 'counts=120,-50,0,0,0,0'
verdict "the counts of the files arrive" "$answer"

cat >/tmp/provoke-program <<'END'
. /bench/lib.sh
host=$(host_of "$link")
gadget=/sys/kernel/config/usb_gadget/tactus/UDC
case $1:$2:$link in
  estop:*) e_stop "$2" ;;
  unplug:on:usb) echo >$gadget ;;
  unplug:off:usb) ls /sys/class/udc >$gadget ;;
  unplug:on:*) cable out ;;
  unplug:off:*) cable in ;;
esac
END
report=/out/programs-hil-$link.log
checks=identity,registers,losses,round-trip,force-age,clock,watchdog,brake,not-finite,saturation,e-stop,unplug
tactus hil --device "$host" --profile desk3d --rate $((1000000 / period_us)) --only $checks --yes --timing report \
  --provoke "sh /tmp/provoke-program" >"$report" 2>&1
[ $? -le 1 ]
verdict "hil runs" "$(tail -n 1 "$report")"
hil_verdicts "$report"

# --- a configuration that is kept

# Axis 0 carries -0.5 N m of weight, in IDLE too: a fifth of full effort, 10000 of 50000 ns, without a host that drives.
ask write 0x0400 0xbf000000 && ask write 0x0450 1 && { [ "$link" = usb ] || ask write 0x0500 5; }
verdict "the host writes registers" "$answer"
wait_for ask execute 0x0800 0 && wait_for says 0x2 0x060b
verdict "the host has them saved" "$answer"
wait_for motor 10000 1 0
verdict "an effort is duty and direction" "$motor"
stop
[ $ended = 0 ]
verdict "SIGTERM under effort: it ends with 0" "exit status $ended: $(tail -n 1 $log)"
motor 0 1 1
verdict "SIGTERM under effort: zero duty, shorted" "$motor"
grep -Eq '^[1-9][0-9]* periods|^periods +[1-9]' $log && grep -Eq '[ ;]0 i/o failures|^i/o failures +0$' $log
verdict "SIGTERM under effort: it prints its counters" "$(tail -n 3 $log | tr '\n' ' ')"
[ "$link" != usb ] || [ ! -e /sys/kernel/config/usb_gadget/tactus ]
verdict "nothing is left of the link" "$(ls /sys/kernel/config/usb_gadget)"

if [ "$link" != usb ]; then host=$host:5; fi
start
says 0xbf000000 0x0400 && wait_for motor 10000 1 0
verdict "what was saved is in force after a restart" "$answer, $motor; $(cat $log)"

# --- what ends the effort

pull 3 up
wait_for is 'state=3 fault=2 limits=0x4200' && motor 0 1 1
verdict "e-stop pressed: BRAKE, zero duty, shorted" "$answer; $motor"
pull 3 down
wait_for is 'state=3 fault=2 limits=0x4000' && motor 0 1 1
verdict "e-stop released: stays braked" "$answer; $motor"
stop
pull 3 up
start
wait_for is 'state=3 fault=2 limits=0x4200' && motor 0 0 1
verdict "begun with the e-stop pressed: BRAKE, zero duty, shorted" "$answer; $motor"
pull 3 down
stop
start
wait_for motor 10000 1 0
verdict "begun with the e-stop released: the effort is there" "$motor"
pull 4 down
wait_for is 'state=3 fault=5 limits=0x4400' && motor 0 1 1
verdict "motor supply fails: BRAKE, zero duty, shorted" "$answer; $motor"
pull 4 up
stop
start
wait_for motor 10000 1 0 && : >$folder/count2
wait_for is 'state=3 fault=5' && motor 0 1 1
verdict "an encoder that cannot be read: BRAKE, zero duty, shorted" "$answer; $motor"
put $folder/count2 0
stop
grep -Eq '[ ;][1-9][0-9]* i/o failures|^i/o failures +[1-9]' $log
verdict "... and counted" "$(tail -n 3 $log | tr '\n' ' ')"
start
kill -9 "$board"
wait "$board" 2>/dev/null
start
wait_for is 'state=1 fault=0'
verdict "begins again after it was killed" "$answer; $(tail -n 1 $log)"
stop

# --- a file that is none, an end by itself, no beginning

echo nonsense >$state
if [ "$link" != usb ]; then host=$(host_of "$link"); fi
start
says 0x0 0x0400 && grep -q "$state holds no configuration" $log
verdict "a broken state file: told, and the mechanics file counts" "$answer; $(cat $log)"
stop
start --periods 100
wait "$board"
ended=$?
[ $ended = 0 ] && grep -Eq '^100 periods|^periods +100$' $log
verdict "--periods: ends by itself" "exit status $ended: $(tail -n 1 $log)"

# refuses NAME STATUS WORDS OPTION...: one line with the words, and that status.
refuses() {
  name=$1 status=$2 words=$3
  shift 3
  timeout 5 $program "$@" >$log 2>&1
  ended=$?
  [ $ended = "$status" ] && [ "$(wc -l <$log)" = 1 ] && grep -q "^$program: .*$words" $log
  verdict "$name: $(cut -c1-120 $log)" "exit status $ended, $(wc -l <$log) lines"
}
sed 's/^axis1.quantum = .*/axis1.quantum = fine/' $mechanics >$folder/bad.txt
sed "s:count1\$:count7:" $mechanics >$folder/absent.txt
refuses "no mechanics file" 2 "cannot be read" --mechanics $folder/none.txt $own
refuses "a bad mechanics file" 2 "bad.txt:[0-9]*: axis1.quantum = 'fine'; accepted" --mechanics $folder/bad.txt $own
refuses "a counter that is not there" 3 "count7: No such file" --mechanics $folder/absent.txt $own
refuses "an interface that is not there" 3 "no.* 'none'" --mechanics $mechanics $missing
refuses "a folder for the state that is not there" 3 "/none/.*--state" --mechanics $mechanics $own --state /none/state
case $link in
  usb) refuses "a serial number with a space" 2 "serial.*accepted" --mechanics $mechanics --serial "A 1" ;;
  can) refuses "FD where there is none" 3 "can1 takes no FD" --mechanics $mechanics $own --format fd ;;
esac
motor 0 0 1
verdict "who is refused leaves the motors without effort" "$motor"
