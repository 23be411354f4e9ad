# A user who is not root: what the program says without rights, and that the two capabilities that it asks for are
# enough: CAP_SYS_NICE for SCHED_FIFO, CAP_IPC_LOCK for locked memory. The device itself comes by a udev rule (USB) or
# needs no right at all (CAN).
. /bench/lib.sh
start_device /bench/press.toml || exit
rules=/etc/udev/rules.d
mkdir -p $rules
chmod 1777 /out

# as_user CAPABILITIES COMMAND...: as the user tactus with no capability but these.
as_user() {
  capabilities=$1
  shift
  if [ -z "$capabilities" ]; then
    capsh --user=tactus --shell=/bin/sh -- -c "$*"
  else
    capsh --caps="$capabilities+eip cap_setpcap,cap_setuid,cap_setgid+ep" --keep=1 --user=tactus \
      --addamb="$capabilities" --shell=/bin/sh -- -c "$*"
  fi
}
run="tactus run /bench/press.toml --device $host --rearm --duration"
log=/tmp/user.log

if [ "$link" = usb ]; then
  as_user '' "$run 0.2" >$log 2>&1
  [ $? = 3 ] && grep -q 'no permission' $log
  verdict "without a udev rule it is refused in one line" "$(tail -n 1 $log)"
  # The remedy is in the message: taken literally, it has to work.
  sed -n 's/.*again: \(SUBSYSTEM.*\)/\1/p' $log | head -n 1 >$rules/70-tactus.rules
  udevadm control --reload
  cable out
  cable in
  wait_for sh -c 'ls -l /dev/bus/usb/*/* | grep -q plugdev'
  verdict "the udev rule of the message gives the group the device" "$(cat $rules/70-tactus.rules; ls -l /dev/bus/usb/*/* | tail -n 1)"
fi

as_user '' "$run 0.3" >$log 2>&1
grep -q '^ *FAIL *memory' $log && grep -q '^ *FAIL *priority' $log
verdict "without capabilities it runs and says what it lacks" "$(tail -n 1 $log | cut -c1-200)"

as_user cap_sys_nice,cap_ipc_lock "exec $run 15" >$log 2>&1 &
host_process=$!
in_force
verdict "with two capabilities the hand feels the floor" "$(tail -n 1 $log | cut -c1-200)"
process=$(pidof tactus | cut -d" " -f1)
[ "$(awk '/^Uid:/ { print $2, $3 }' "/proc/$process/status")" = '1000 1000' ]
verdict "it runs as the user" "$(grep Uid "/proc/$process/status")"
# Bits 14 (CAP_IPC_LOCK) and 23 (CAP_SYS_NICE).
[ "$(awk '/^CapEff:/ { print $2 }' "/proc/$process/status")" = 0000000000804000 ]
verdict "it has these two capabilities and no other" "$(grep CapEff "/proc/$process/status")"
# Fields 40 and 41 of stat: real-time priority and policy; 1 is SCHED_FIFO.
cat /proc/"$process"/task/*/stat | sed 's/.*) //' | awk '$38 == 80 && $39 == 1 { found = 1 } END { exit !found }'
verdict "its haptic thread is SCHED_FIFO 80" "$(cat /proc/"$process"/task/*/stat | sed 's/.*) //' | awk '{ printf "%s/%s ", $38, $39 }')"
kill "$process"
wait_for grep -q 'ok *memory' $log && grep -q 'ok *priority' $log
verdict "memory is locked, the priority is granted" "$(tail -n 12 $log | tr '\n' ' ')"
cp $log "/out/user-$link.log"
stop_device user
