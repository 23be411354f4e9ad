# What the doctor says of this PC: right as it is, and with each thing wrong that can be wrong here, one at a time, put
# right again by its remedy. Core 2 is set apart by the kernel's command line; core 3 shares its hardware.
. /bench/lib.sh
link=doctor
found=/tmp/doctor.json
doctor() { tactus doctor --json "$@" >$found; }
# The user tactus, without any capability; limits are set before.
doctor_as_user() { capsh --user=tactus --shell=/bin/sh -- -c 'tactus doctor --json "$@"' sh "$@" >$found; }
has() { grep -A1 "\"check\": \"$1\"" $found | grep -q "\"verdict\": \"$2\""; }
says() { grep -A3 "\"check\": \"$1\"" $found | tr '\n' ' '; }
# expect CHECK VERDICT WHEN: of what the doctor said last.
expect() { has "$1" "$2"; verdict "$1 is $2 $3" "$(says "$1")"; }
# remedy CHECK [OPTION...]: runs what --fix prints for the check.
remedy() {
  check=$1
  shift
  tactus doctor --fix "$@" | awk -v head="# $check:" 'index($0, "# ") == 1 { on = index($0, head) == 1 } on' >/tmp/remedy.sh
  sh /tmp/remedy.sh >/tmp/remedy.log 2>&1
}
mkdir -p /etc/sysctl.d

doctor --cpu 2
for check in kernel isolation timer-ticks rcu priority-limit memory-limit cores huge-pages swap governor; do
  expect $check green "on core 2 as it is"
done
expect machine amber "in an emulator"
grep -q '"representative": false' $found
verdict "figures of an emulator are said not to be representative" "$(tail -n 3 $found)"
doctor --cpu 1
for check in isolation timer-ticks rcu; do expect $check amber "on core 1, which is not set apart"; done
# This guest has no boot loader; one that reads what Debian's reads.
printf '#!/bin/sh\n. /etc/default/grub.d/*isolcpus.cfg; . /etc/default/grub.d/*nohz_full.cfg; . /etc/default/grub.d/*rcu_nocbs.cfg; echo $GRUB_CMDLINE_LINUX >/tmp/boot-line\n' >/bin/update-grub
chmod +x /bin/update-grub
for check in isolation timer-ticks rcu; do remedy $check --cpu 1; done
[ "$(cat /tmp/boot-line)" = 'isolcpus=managed_irq,domain,1 nohz_full=1 rcu_nocbs=1' ]
verdict "their remedies give the boot loader one line" "$(cat /tmp/boot-line /tmp/remedy.log)"

echo 0 >/tmp/zero
mount --bind /tmp/zero /sys/kernel/realtime
doctor --cpu 2
expect kernel red "where the kernel says that it is not PREEMPT_RT"
umount /sys/kernel/realtime

echo 950000 >/proc/sys/kernel/sched_rt_runtime_us
doctor --cpu 2
expect throttling amber "as kernels come"
remedy throttling --cpu 2
doctor --cpu 2
expect throttling green "after its remedy"

# A PREEMPT_RT kernel puts no pages together; one that does, made up.
mkdir -p /tmp/mm/transparent_hugepage
echo '[always] madvise never' >/tmp/mm/transparent_hugepage/enabled
mount --bind /tmp/mm /sys/kernel/mm
doctor --cpu 2
expect huge-pages amber "where pages are put together at will"
echo 'always [madvise] never' >/tmp/mm/transparent_hugepage/enabled
doctor --cpu 2
expect huge-pages green "where they are where a program asks"
umount /sys/kernel/mm

mkswap /dev/vda >/dev/null && swapon /dev/vda
doctor --cpu 2
expect swap amber "with swap on"
remedy swap --cpu 2
doctor --cpu 2
expect swap green "after its remedy"

clocks=/sys/devices/system/clocksource/clocksource0
before=$(cat $clocks/current_clocksource)
for clock in $(cat $clocks/available_clocksource); do
  echo "$clock" >$clocks/current_clocksource
  if [ "$clock" = tsc ] || [ "$clock" = kvm-clock ]; then right=green; else right=amber; fi
  doctor --cpu 2
  expect clock $right "on the clock source $clock"
done
echo "$before" >$clocks/current_clocksource

doctor --cpu 2
expect sibling amber "while the other thread of its hardware is online"
remedy sibling --cpu 2
doctor --cpu 2
expect sibling green "after its remedy"
expect cores amber "with three cores"
echo 0 >/sys/devices/system/cpu/cpu1/online
doctor --cpu 1
expect cores red "where the chosen one is offline"
remedy cores --cpu 1
doctor --cpu 1
expect cores amber "after its remedy"

# The line that the bench itself speaks over has a driver and an interrupt.
serial=$(awk -F: '/ttyS0/ { print $1 + 0; exit }' /proc/interrupts)
echo 2 >"/proc/irq/$serial/smp_affinity_list"
interrupts_are() { echo >/dev/ttyS0; doctor --cpu 2; has interrupts "$1"; }
wait_for interrupts_are amber
verdict "interrupts is amber where a device's comes to core 2" "$(says interrupts)"
remedy interrupts --cpu 2
wait_for interrupts_are green
verdict "interrupts is green after its remedy" "$(says interrupts); $(cat /tmp/remedy.sh /tmp/remedy.log | tr '\n' ' ')"

doctor --cpu 2 --device usb
expect usb red "without a device"
doctor --cpu 2 --device can:can7
expect can red "where there is no such interface"
ip link set can0 down
doctor --cpu 2 --device can:can0
expect can red "while it is down"
ip link set can0 type can bitrate 125000 && ip link set can0 up
doctor --cpu 2 --device can:can0
expect can red "at 125 kbit/s, too slow for 1 kHz"
remedy can --cpu 2 --device can:can0
doctor --cpu 2 --device can:can0
expect can green "after its remedy"
# It may share its line with what was sent to one core above.
echo 0,2-3 >"/proc/irq/$(cat /sys/class/net/can0/device/irq)/smp_affinity_list"
doctor --cpu 2 --device can:can0
expect bus-interrupt amber "where that of the controller may come to any core"
remedy bus-interrupt --cpu 2 --device can:can0
doctor --cpu 2 --device can:can0
expect bus-interrupt green "after its remedy"
expect interrupts green "while only the device's own bus interrupts the core"
doctor --cpu 2 --device can:vcan0
expect can green "on a virtual bus"
! grep -q bus-interrupt $found
verdict "bus-interrupt is not looked for where there is none" "$(says bus-interrupt)"
doctor --cpu 2 --gpio
expect gpio green "for root"

ulimit -r 0
ulimit -l 64
doctor_as_user --cpu 2 --gpio
expect priority-limit red "for a user without rights"
expect memory-limit red "for a user without rights"
expect gpio red "for a user without rights"
ulimit -r 98
ulimit -l unlimited
doctor_as_user --cpu 2
expect priority-limit green "for a user with the limits of the remedy"
expect memory-limit green "for a user with the limits of the remedy"

link=usb
start_device /bench/press.toml || exit
link=doctor
doctor --cpu 2 --device usb
expect usb green "with the device, for root"
doctor_as_user --cpu 2 --device usb
expect usb red "with the device, for a user whom no rule lets"
stop_device doctor
