# The timing of the real loop, with what the kernel's own tracer says of interruptions. How fast the loop is here says
# nothing (tests/vm/README.md); that every late tick has a cause, and what it is told from, is judged.
. /bench/lib.sh
link=timing
mount -t tracefs tracing /sys/kernel/tracing 2>/dev/null
before=$(cat /sys/kernel/tracing/osnoise/cpus /sys/kernel/tracing/osnoise/timerlat_period_us)
out=/out/timing.json
tactus timing --cpu 2 --duration 8 --members 2 --sub-steps 1 --rate 100 --os-noise --json >$out 2>/tmp/timing.err
status=$?
[ $status -le 1 ]
verdict "it runs" "status $status; $(tail -n 1 /tmp/timing.err)"
number() { sed -n "s/^ *\"$1\": \([0-9]*\),*$/\1/p" $out | head -n 1; }
[ "$(number ticks)" -gt 50 ]
verdict "it counts ticks" "$(number ticks)"
sum=0
for cause in late_wake_up page_fault context_switch interrupt own_work machine_inferred; do
  sum=$((sum + $(number $cause)))
done
[ "$sum" = "$(number overruns_total)" ]
verdict "every overrun has a cause" "$sum causes, $(number overruns_total) overruns"
[ "$(number page_faults)" = 0 ]
verdict "no page fault" "$(number page_faults)"
grep -q '"evidence": ".*the kernel measured [a-z]' $out
verdict "a late tick names what the kernel measured on its core" "$(grep -m 2 evidence $out | tr '\n' ' ' | cut -c1-300)"
[ "$(cat /sys/kernel/tracing/osnoise/cpus /sys/kernel/tracing/osnoise/timerlat_period_us)" = "$before" ] &&
  [ ! -e /sys/kernel/tracing/instances/tactus ]
verdict "the tracer is left as it was" "$(ls /sys/kernel/tracing/instances)"
capsh --user=tactus --shell=/bin/sh -- -c 'tactus timing --cpu 2 --duration 3 --os-noise' >/dev/null 2>/tmp/timing.err
[ $? = 3 ] && grep -q 'they need root' /tmp/timing.err
verdict "without rights it is refused in one line" "$(tail -n 1 /tmp/timing.err)"
