# One e-stop line for two hands: the whole host program with two simulated devices, its lines over gpio-sim. A press
# stops both, held or short; the faults stay latched, and a re-arm of each hand takes its own back.
. /bench/lib.sh
socket=/tmp/hands.sock
run_log=/out/gpio-hands.log
enabled() { cat $gpio/sim_gpio4/value; }

# state HAND / ask HAND REQUEST: over the hand's socket.
socket_of() { case $1 in 1) echo $socket ;; 2) echo /tmp/hands.2.sock ;; esac; }
state() { tactus control state --socket "$(socket_of "$1")" --json 2>&1; }
ask() { tactus control "$2" --socket "$(socket_of "$1")" 2>&1; }
has() { state "$1" | grep -q "\"$2\":$3[,}]"; }
armed() { has "$1" fault 0 && has "$1" armed true; }
stopped() { has "$1" fault 11; }
both() { "$1" 1 && "$1" 2; }
states() { echo "$(state 1 | cut -c1-200) $(state 2 | cut -c1-200)"; }
# faults HAND: how many the run has told of it.
faults() { grep -c "hand $1: FAULT.*e-stop\|hand $1: FAULT.*emergency" $run_log; }

for pull in $gpio/sim_gpio*/pull; do echo pull-down >"$pull"; done
tactus run /bench/two_hands.toml --device sim --device sim --gpio chip=gpiochip0,estop=3,enable=4 --control $socket \
  >$run_log 2>&1 &
run=$!
wait_for both armed
verdict "two hands in force" "$(states) $(tail -n 1 $run_log)"
[ "$(enabled)" = 1 ]
verdict "the drive enable is active" "$(enabled)"

# Held.
e_stop on
wait_for both stopped
verdict "e-stop held: both hands are stopped" "$(states)"
[ "$(enabled)" = 0 ]
verdict "e-stop held: the drive enable is off" "$(enabled)"
ask 1 rearm >/tmp/refused
sleep 0.5
both stopped
verdict "e-stop held: no re-arm takes it back" "$(states)"
e_stop off
sleep 1
both stopped && [ "$(enabled)" = 0 ]
verdict "e-stop released: both stay latched" "$(states) enable $(enabled)"
ask 1 rearm >/tmp/rearm && wait_for armed 1
verdict "a re-arm of the first hand gives it force" "$(cat /tmp/rearm) $(state 1)"
stopped 2
verdict "and leaves the second latched" "$(state 2)"
[ "$(enabled)" = 1 ]
verdict "the drive enable is active for one hand" "$(enabled)"
ask 2 rearm >/tmp/rearm && wait_for armed 2
verdict "a re-arm of the second gives it force" "$(cat /tmp/rearm) $(state 2)"

# Short, twice.
for press in 1 2; do
  # One process presses and releases, so that the line is active for less than some ticks.
  (echo pull-up; echo pull-down) | while read -r pull; do echo "$pull" >$gpio/sim_gpio3/pull; done
  wait_for both stopped
  verdict "short press $press: both hands are stopped" "$(states)"
  ask 1 rearm >/tmp/rearm && ask 2 rearm >>/tmp/rearm && wait_for both armed
  verdict "short press $press: both are in force again" "$(tr '\n' ' ' </tmp/rearm) $(states)"
done
[ "$(faults 1)" -ge 1 ] && [ "$(faults 2)" -ge 1 ]
verdict "the run tells each hand's fault" "$(tail -n 3 $run_log | tr '\n' ' ')"
kill $run
wait $run
status=$?
[ "$(enabled)" = 0 ]
verdict "the end of the run takes the drive enable away" "status $status, enable $(enabled)"
