# The card house end to end: the global world, the sub-world, the link, the kernel's drivers, the firmware, the arm and
# the hand that presses on the top.
. /bench/lib.sh
start_device /bench/card_house.toml || exit
tactus run /bench/card_house.toml --device "$host" --duration "${HOUSE_S:-1.2}" >"/out/house-$link.log" 2>&1
verdict "card house runs at 1000 Hz" "exit status $?; $(tail -n 1 "/out/house-$link.log")"
contact=$(sed -n 's/^ *in contact *\([0-9.]*\) %.*/\1/p' "/out/house-$link.log")
awk -v share="${contact:-0}" 'BEGIN { exit !(share >= 30) }'
verdict "card house is touched (${contact:-0} % of the ticks)" "less than 30 %"
grep -q ' 0 corrupt;.* 0 lost' "/out/house-$link.log"
verdict "card house: no frame is lost" "$(grep 'state frames' "/out/house-$link.log")"
report
awk -v effort="$(value largest_effort)" 'BEGIN { exit !(effort > 0) }'
verdict "card house: its force reaches the motors" "largest effort $(value largest_effort)"
stop_device house
