# Devices through makers' libraries, by the stand-ins for them: the suite with its times judged, which only a machine of
# one's own bears, then faults of a library in a push: a call of 50 ms, errors, a clock that runs backwards.
. /bench/lib.sh

# hil_on NAME DEVICE [FAULT]
hil_on() {
  TACTUS_STAND_IN_FAULT=$3 TACTUS_STAND_IN_END=/tmp/end \
    tactus hil --device "$2" --yes --force 1 >"/out/hil-$1.log" 2>&1
}
# a_fault DEVICE_NAME DEVICE FAULT WORDS
a_fault() {
  rm -f /tmp/end
  hil_on "$1-${3%@*}" "$2" "$3"
  [ $? = 1 ] && grep -q "left in BRAKE: .*$4" "/out/hil-$1-${3%@*}.log" && grep -q 'forces off' /tmp/end
  verdict "$1: ${3%@*} in a push: bad, left in BRAKE, forces off" "$(tail -n 3 "/out/hil-$1-${3%@*}.log")"
}

dhd=dhd:/bin/libtactus_stand_in_dhd.so hd=openhaptics:/bin/libtactus_stand_in_hd.so
for each in "dhd $dhd" "openhaptics $hd"; do
  hil_on "${each%% *}" "${each#* }"
  verdict "${each%% *}: hil is good" "exit status $?; $(tail -n 1 "/out/hil-${each%% *}.log")"
  hil_verdicts "/out/hil-${each%% *}.log" "${each%% *}"
done
a_fault dhd "$dhd" blocks@push 'its library took 50'
a_fault dhd "$dhd" errors@push 'refuses exchanges'
a_fault openhaptics "$hd" blocks@push 'its library took 50'
a_fault openhaptics "$hd" errors@push 'refuses exchanges'
a_fault openhaptics "$hd" backwards@push 'clock ran backwards'
