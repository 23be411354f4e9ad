# A device that lies, and on CAN a node that babbles: the host program lives on, no force goes beyond the limits, and
# what is true again is felt again.
. /bench/lib.sh
start_device /bench/press.toml || exit
start_host /bench/press.toml --rearm
in_force
verdict "force before the lies" "$(tail -n 1 "$host_log")"

for lie in wild_states corrupt_states odd_sizes repeated_states babble silence lost_states; do
  # The CAN link sends no frame that is none; the babbling nodes below do.
  case $link:$lie in can*:corrupt_states | can*:odd_sizes) continue ;; esac
  tell "$lie 300"
  sleep 0.5
  host_lives && in_force
  verdict "$lie: survived, and force again" "$(host_lives || echo 'the host died; ')$(tail -n 1 "$host_log" | cut -c1-200)"
done

# babbles NAME INTERFACE ID: random content, lengths and - on FD - kinds, as fast as it goes.
case $link in can-fd) kinds=-m ;; *) kinds= ;; esac
babbles() {
  timeout 1 cangen "$2" $kinds -g 0 -I "$3" -L r -D r -i >/dev/null 2>&1
  host_lives && in_force
  verdict "$1: survived, and force again" "$(host_lives || echo 'the host died; ')$(tail -n 1 "$host_log" | cut -c1-200)"
}
if [ "$link" != usb ]; then
  bus=${host#can:}
  device_side=$(device_of "$link")
  babbles "a node babbles as the device" "${device_side#*:}" 181
  babbles "a node babbles as the host" "$bus" 081
  babbles "a node babbles on its own" "$bus" 005
fi

report
awk -v share="$(value largest_share)" 'BEGIN { exit !(share <= 1) }'
verdict "no effort beyond the limits" "$(value largest_share) of the limit"
[ "$(value finite)" = 1 ]
verdict "no effort that is not finite" "the host sent one"
kill "$host_process"
wait "$host_process"
[ $? -le 1 ]
verdict "the host ends in order" "$(tail -n 1 "$host_log" | cut -c1-200)"
stop_device hostile
