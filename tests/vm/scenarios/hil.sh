# The hardware-in-the-loop suite as a user runs it, with the faults that only the bench can cause, and the soak.
. /bench/lib.sh
start_device /bench/press.toml --hand still || exit
tactus hil --device "$host" --yes --force 1 --timing report --provoke /bench/provoke --soak-frames "${SOAK_FRAMES:-20000}" \
  --junit "/out/hil-$link.xml" >"/out/hil-$link.log" 2>&1
[ $? -le 1 ]
verdict "hil runs" "$(tail -n 1 "/out/hil-$link.log")"
hil_verdicts "/out/hil-$link.log"
report
awk -v share="$(value largest_share)" 'BEGIN { exit !(share <= 1) }'
verdict "no effort beyond the limits in the suite" "$(value largest_share) of the limit"
stop_device hil
