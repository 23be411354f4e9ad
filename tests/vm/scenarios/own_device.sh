# The template of a device in C on a CAN FD bus: registers by `tactus device ask`, the suite, a run.
. /bench/lib.sh
host=can:vcan0
device_can_fd vcan0 >/out/own-device.log 2>&1 &
device=$!
wait_for grep -q ready /out/own-device.log || { not_ok own-device "did not start: $(cat /out/own-device.log)"; exit; }
tactus device ask --device $host read serial period max_effort >/out/own-device-ask.log 2>&1
verdict "device in C: it tells its registers" "$(tail -n 1 /out/own-device-ask.log)"
tactus device ask --device $host --profile desk3d needs --write >/out/own-device-needs.log 2>&1
verdict "device in C: it has what the description needs, once it is written" "$(grep 'write it' /out/own-device-needs.log | head -n 1)"
tactus hil --device $host --profile desk3d --yes --timing report --only \
  identity,registers,losses,round-trip,force-age,clock,watchdog,brake,not-finite,broken-commands,repeated-commands,saturation >/out/own-device-hil.log 2>&1
status=$?
[ $status -le 1 ]
verdict "device in C: hil runs" "status $status: $(tail -n 1 /out/own-device-hil.log)"
hil_verdicts /out/own-device-hil.log "device in C"
kill $device
