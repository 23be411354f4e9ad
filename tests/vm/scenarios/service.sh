# The package under systemd: installed in a clean Debian, the service runs the card house as an unprivileged user, is
# watched, told things, upgraded, stopped, and leaves nothing behind. The guest's own systemd, apt, udev and journal.
. /run/bench/lib.sh
unit=tactus.service
configuration=/etc/tactus/tactus.toml

shows() { systemctl show "$unit" -p "$1" --value; }
# is PROPERTY VALUE: of the unit.
is() { [ "$(shows "$1")" = "$2" ]; }
process() { shows MainPID; }
apt_get() { DEBIAN_FRONTEND=noninteractive apt-get -q -y "$@" >/tmp/apt.log 2>&1; }
why_apt() { tail -n 5 /tmp/apt.log | tr '\n' ' '; }
journal() { journalctl --no-pager -o cat -u "$unit" 2>/dev/null; }
why() { journal | tail -n 4 | tr '\n' ' ' | cut -c1-300; }
state() { tactus control state --json 2>/tmp/state.err; }
# number KEY: of the state that is told now.
number() { state | sed -n "s/.*\"$1\":\([0-9.e+-]*\).*/\1/p"; }
ticks_go_on() { before=$(number ticks); sleep 0.25; [ "$(number ticks)" -gt "${before:-0}" ] 2>/dev/null; }
runs() { is ActiveState active && ticks_go_on; }
# another_runs PROCESS: the service runs, and not as that process.
another_runs() { [ "$(process)" != "$1" ] && runs; }
reloaded() { journal | grep -q '^reloaded .*interval_s=7'; }
disarmed() { state | grep -q '"armed":false' && journal | grep -q '^disarmed'; }
armed() { state | grep -q '"armed":true'; }
# All files that stay, but what apt, dpkg, the journal and systemd keep for themselves; and all users.
listing() {
  find / -xdev \( -path /var/lib/dpkg -o -path /var/lib/apt -o -path /var/cache -o -path /var/log -o -path /tmp \
    -o -path /var/tmp -o -path /root -o -path /var/lib/systemd -o -path '/etc/*-' \) -prune -o -print | sort
  cut -d: -f1 /etc/passwd /etc/group
}

booted() { systemctl is-system-running | grep -q '^running$\|^degraded$'; }
patience=100
wait_for booted
verdict "systemd is up" "$(systemctl is-system-running)"
failed_before=$(systemctl --failed --no-legend | wc -l)
listing >/tmp/before

apt_get install /run/bench/tactus-0.1.0.deb
verdict "apt installs the package" "$(why_apt)"
id tactus >/dev/null 2>&1 && ! grep '^tactus:' /etc/shadow | grep -q '^tactus:\$'
verdict "its user is there, without a password" "$(id tactus 2>&1)"
is ActiveState inactive && [ "$(systemctl is-enabled $unit)" = disabled ]
verdict "installing starts nothing" "$(systemctl is-active $unit) $(systemctl is-enabled $unit)"
tactus config check $configuration >/tmp/config 2>&1
verdict "the installed configuration is good" "$(tail -n 1 /tmp/config)"

# A page of an experiment from what is installed, by a user without rights.
setpriv --reuid nobody --regid nogroup --clear-groups env HOME=/tmp MPLCONFIGDIR=/tmp tactus experiment energy-loss \
  --quick --scenes stack --borders ghost --ratios 8 --page /tmp/page.html >/tmp/page.log 2>&1 && grep -q '</html>' /tmp/page.html
verdict "the installed package writes a page" "$(tail -n 2 /tmp/page.log | tr '\n' ' ')"

systemctl start $unit
verdict "systemctl start: it says that it is ready" "$(why)"
wait_for runs
verdict "its ticks go on" "$(why)"
state | grep -q '"armed":false'
verdict "no force is on before somebody asks" "$(state)"
tactus control arm >/dev/null && wait_for armed
verdict "armed over its socket" "$(state)"
first=$(process)
[ "$(stat -c %U "/proc/$first")" = tactus ]
verdict "it runs as the user tactus" "$(stat -c %U "/proc/$first")"
# Bits 14 (CAP_IPC_LOCK) and 23 (CAP_SYS_NICE).
[ "$(awk '/^CapEff:/ { print $2 }' "/proc/$first/status")" = 0000000000804000 ] &&
  [ "$(awk '/^CapBnd:/ { print $2 }' "/proc/$first/status")" = 0000000000804000 ] &&
  [ "$(awk '/^NoNewPrivs:/ { print $2 }' "/proc/$first/status")" = 1 ]
verdict "of root's rights it has two, and can get no more" "$(grep 'Cap\|NoNew' "/proc/$first/status" | tr '\n' ' ')"
# Fields 40 and 41 of stat: real-time priority and policy; 1 is SCHED_FIFO.
cat /proc/"$first"/task/*/stat | sed 's/.*) //' | awk '$38 == 80 && $39 == 1 { found = 1 } END { exit !found }'
verdict "its haptic thread is SCHED_FIFO 80" "$(cat /proc/"$first"/task/*/stat | sed 's/.*) //' | awk '{ printf "%s/%s ", $38, $39 }')"
[ "$(awk '/^VmLck:/ { print $2 }' "/proc/$first/status")" -gt 10000 ]
verdict "its memory is locked" "$(grep VmLck "/proc/$first/status")"
[ "$(awk '/^Seccomp:/ { print $2 }' "/proc/$first/status")" = 2 ] &&
  awk '$2 == "/" { root = $4 } END { exit !(root ~ /^ro(,|$)/) }' "/proc/$first/mounts"
verdict "its system calls are filtered, its system is read-only" "$(grep Seccomp: "/proc/$first/status") $(grep ' / ' "/proc/$first/mounts")"
touched() { [ "$(number members)" -gt 0 ] && [ "$(number contacts)" -gt 0 ]; }
wait_for touched
verdict "the card house is in the sub-world" "$(state)"
[ "$(number fault)" = 0 ] && [ "$(number overruns)" = 0 ]
verdict "no fault, no overrun" "$(state)"
journal | grep -q '^running rate_Hz='
verdict "the journal has its start, with its fields" "$(why)"
setpriv --reuid nobody --regid nogroup --clear-groups tactus control state >/dev/null 2>/tmp/refused
[ $? = 3 ]
verdict "who is not in its group may not ask it" "$(cat /tmp/refused)"
setpriv --reuid nobody --regid nogroup --groups tactus tactus control state --json >/tmp/visitor 2>&1 &&
  grep -q '"ok":true' /tmp/visitor
verdict "who is in its group may" "$(tail -n 1 /tmp/visitor)"

# What follows is about processes: a world that costs an emulated core little.
sed -i 's|^scene = .*|scene = "/usr/share/tactus/scenes/wall.toml"|' $configuration
systemctl restart $unit
wait_for another_runs "$first"
verdict "systemctl restart: it runs another scene" "was $first, is $(process); $(why)"
first=$(process)
tactus control arm >/dev/null

sed -i 's/^interval_s = 1 /interval_s = 7 /' $configuration
systemctl reload $unit
[ $? = 0 ] && wait_for reloaded
verdict "systemctl reload: what is safe is changed" "$(why)"
[ "$(process)" = "$first" ] && ticks_go_on && is NRestarts 0
verdict "it goes on as it was" "was $first, is $(process)"
tactus control disarm >/dev/null && wait_for disarmed && tactus control arm >/dev/null
verdict "disarmed over its socket: the journal says so" "$(why)"
wait_for armed
verdict "armed again" "$(state)"
sed -i 's/^rate_Hz = 1000/rate_Hz = 500/' $configuration
! systemctl reload $unit 2>/dev/null && journal | grep -q 'a restart is needed for'
verdict "what needs a restart is refused by name" "$(why)"
[ "$(process)" = "$first" ] && ticks_go_on
verdict "and it goes on all the same" "was $first, is $(process)"
sed -i 's/^rate_Hz = 500/rate_Hz = 1000/' $configuration

kill -STOP "$first"
sleep 8
wait_for another_runs "$first"
verdict "it stands still: the watchdog starts it again" "$(why)"
journal_of_systemd() { journalctl --no-pager -o cat _PID=1 + UNIT=$unit 2>/dev/null; }
journal_of_systemd | grep -qi 'watchdog timeout'
verdict "and the journal says so" "$(journal_of_systemd | tail -n 3 | tr '\n' ' ')"
second=$(process)
kill -KILL "$second"
wait_for another_runs "$second"
verdict "it is killed: it is started again" "$(why)"

second=$(process)
apt_get install /run/bench/tactus-0.1.1.deb
verdict "it is upgraded while it runs" "$(why_apt)"
[ "$(dpkg-query -W -f='${Version}' tactus)" = 0.1.1 ] && [ "$(process)" = "$second" ] && ticks_go_on
verdict "the upgrade leaves the running service alone" "$(dpkg-query -W tactus); was $second, is $(process); $(why)"
grep -q 'the service runs on' /tmp/apt.log
verdict "and says so" "$(why_apt)"
systemctl restart $unit
wait_for another_runs "$second"
verdict "restarted by hand, the new version runs" "was $second, is $(process); $(why)"
grep -q '^interval_s = 7 ' $configuration
verdict "the edited configuration is kept" "$(grep interval_s $configuration)"

systemctl stop $unit
is ActiveState inactive && is Result success && is ExecMainStatus 0
verdict "systemctl stop: it ends well" "$(shows ActiveState) $(shows Result) $(shows ExecMainStatus); $(why)"
[ ! -e /run/tactus ]
verdict "its socket is gone" "$(ls -d /run/tactus 2>&1)"
sed -i 's/^scene = .*/scene = "nowhere.toml"/' $configuration
! systemctl start $unit 2>/dev/null && sleep 5 && is ActiveState failed && is NRestarts 0
verdict "a bad configuration ends it once, not in a loop" "$(shows ActiveState), $(shows NRestarts) restarts; $(why)"
journal | grep -q 'nowhere.toml'
verdict "and the journal names what is bad" "$(why)"
systemctl reset-failed $unit

sed -i 's|^scene = .*|scene = "/usr/share/tactus/scenes/wall.toml"|' $configuration
systemctl enable --now $unit >/dev/null 2>&1
wait_for runs
verdict "it is enabled, and runs again" "$(why)"
apt_get remove tactus
verdict "it is removed while it runs" "$(why_apt)"
! pidof tactus >/dev/null && [ ! -e /usr/bin/tactus ] && [ -f $configuration ]
verdict "nothing runs; the configuration is left" "$(pidof tactus) $(ls /usr/bin/tactus $configuration 2>&1)"
apt_get purge tactus
verdict "it is purged" "$(why_apt)"
listing >/tmp/after
diff /tmp/before /tmp/after >/tmp/left
verdict "nothing of it is left: no file, no user" "$(tr '\n' ' ' </tmp/left | cut -c1-300)"
[ "$(systemctl --failed --no-legend | wc -l)" = "$failed_before" ] && [ "$(shows LoadState)" = not-found ]
verdict "systemd knows it no more" "$(shows LoadState); $(systemctl --failed --no-legend | tr '\n' ' ')"
journalctl --no-pager -o short-monotonic >/run/out/journal
