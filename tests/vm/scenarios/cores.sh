# The haptic thread on a core that the kernel leaves to it: isolcpus. Which threads may run where is looked at while it
# runs; how fast is not judged, for this guest has no core of its own in the machine.
. /bench/lib.sh
isolated=$(cat /sys/devices/system/cpu/isolated)
[ "$isolated" = 2 ]
verdict "the kernel has set core 2 apart" "isolated: '$isolated'"
start_device /bench/press.toml || exit
start_host /bench/press.toml --rearm --cpu 2
patience=150  # a slow machine of three processors
wait_for grep -q ' Hz ' "$host_log"
patience=
verdict "the host program runs" "$(tail -n 1 "$host_log" | cut -c1-200)"
sleep 1

# NAME, CPUs it may use, the one it ran on last, priority, policy: a line per thread.
for task in /proc/"$host_process"/task/*; do
  allowed=$(awk '/^Cpus_allowed_list:/ { print $2 }' "$task/status")
  sed 's/.*(\(.*\)) /\1 /' "$task/stat" | awk -v allowed="$allowed" '{ print $1, allowed, $(38), $(39), $(40) }'
done >/out/threads
awk '$2 == "2" && $3 == 2 && $4 == 80 && $5 == 1 { found = 1 } END { exit !found }' /out/threads
verdict "the haptic thread is SCHED_FIFO 80 on core 2 alone" "$(tr '\n' ';' </out/threads)"
awk '$4 != 80 && $3 == 2 { bad = 1 } END { exit bad }' /out/threads
verdict "no other thread of the program is on core 2" "$(tr '\n' ';' </out/threads)"
kill "$host_process"
wait "$host_process"
grep -q 'ok *cpu ' "$host_log"
verdict "the program says that it has its core" "$(grep ' cpu ' "$host_log")"
stop_device cores
