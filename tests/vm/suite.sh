# The scenarios, run and counted: sourced by tools/vm, after image.sh.
# shellcheck shell=bash disable=SC2154
#
# Guests `usb`, `can` and `fd` have one processor each, whose clock counts instructions: everything that the wire, the
# firmware and the host program do is in them, at the nominal rate on any machine; they run side by side. `cores` has
# four, one of them set apart, on this machine's clock: what the kernel grants. `debian` has a whole Debian with systemd,
# in which the package is installed. Each verdict counts as one test; a scenario that this machine cannot run is said,
# counts as neither, and makes the exit status 3.
side_by_side=(debian usb can fd)
declare -A scenarios_of=(
  [usb]='drivers user:usb programs:usb faults:usb recovery:usb hostile:usb house:usb hil:usb falcon:usb'
  [can]='user:can programs:can faults:can recovery:can hostile:can house:can hil:can arms:can'
  [fd]='programs:can-fd faults:can-fd recovery:can-fd hostile:can-fd hil:can-fd arms:can-fd own_device:can-fd gpio_hands libraries'
  [debian]='service'
  [cores]='doctor:usb cores:usb timing:usb')
# With --quick: each scenario once, on one of the links, and QUICK set in the guest; not the Debian, the guest that takes longest.
declare -A quick_scenarios_of=(
  [usb]='drivers user:usb programs:usb house:usb falcon:usb'
  [can]='faults:can hil:can arms:can'
  [fd]='recovery:can-fd hostile:can-fd own_device:can-fd gpio_hands libraries'
  [debian]=''
  [cores]='doctor:usb cores:usb timing:usb')
guest_tools=(candump cansend cangen)

# What the scenarios need of the build; the guest tests are taken as far as they exist.
guest_programs() { find "$build/tests/vm" -maxdepth 1 -type f -name '*_guest_test' -perm -u+x; }

build_guest_programs() {
  if [[ -n $build_given ]]; then return; fi
  take_lock
  build_preset release tactus bench_programs deploy_files || fail 1 "nothing to run: the build failed"
  exec 9>&-
}

# run_guest NAME SCENARIO...: one guest with its scenarios; each verdict is shown as it comes.
run_guest() {
  local name=$1 file start=$SECONDS
  scratch=$work_folder/$name
  mkdir -p "$scratch/root/etc"
  : >"$logs/vm-$name.log"
  for file in "$build/tools/tactus" "$build"/tests/vm/{bench_device,bench_drives,bench_falcon,ask_device} \
    "$build"/firmware/boards/tactus_device_{usb,can} "$build/tests/tools/examples/device_in_c/device_can_fd" \
    "$build"/tests/libtactus_stand_in_{dhd,hd}.so $(guest_programs); do
    add_file "$file"
  done
  for file in "${guest_tools[@]}"; do add_file "$(command -v "$file")"; done
  for file in "$bench"/guest/{suite,provoke,lib.sh} "$bench/press.toml" "$root/sim/scenes/card_house.toml" \
    "$root/tools/examples/two_hands.toml" \
    "$root"/hal/devices/{point_arm_drives,wristed_arm_moteus}.toml; do
    add_file "$file" "bench/$(basename "$file")"
  done
  for file in "$bench"/scenarios/*.sh; do add_file "$file" "bench/scenarios/$(basename "$file")"; done
  echo "SOAK_FRAMES=$soak_frames QUICK=$quick exec sh /bench/suite ${*:2}" >"$scratch/root/etc/command"
  boot | tee "$logs/vm-$name.log" | show_verdicts
  echo "  guest '$name' took $((SECONDS - start)) s"
}

# run_debian SCENARIO...: as run_guest, with two versions of the package, in a whole Debian.
run_debian() {
  local version file start=$SECONDS log=$logs/vm-debian.log
  scratch=$work_folder/debian
  mkdir -p "$scratch/root/bench"
  for version in 0.1.0 0.1.1; do
    (cd "$build" && cpack -G DEB -D CPACK_PACKAGE_VERSION="$version" -D CPACK_PACKAGE_DIRECTORY="$scratch/$version") \
      >"$logs/vm-package.log" 2>&1 && cp "$scratch/$version"/tactus_*.deb "$scratch/root/bench/tactus-$version.deb" ||
      { echo "not ok debian: cpack makes a package: $(first_error "$logs/vm-package.log")" | tee "$log" | show_verdicts; return; }
  done
  prepare_debian "$scratch/root/bench/tactus-0.1.0.deb"
  if [[ -z $debian_root ]]; then
    printf 'cannot debian: %s: %s\nsuite ended\n' "$*" "$debian_missing" | tee "$log" | show_verdicts
    return
  fi
  for file in "$bench"/guest/{boot_debian,debian_suite,bench.service,lib.sh}; do add_file "$file" "bench/$(basename "$file")"; done
  for file in "$@"; do add_file "$bench/scenarios/$file.sh" "bench/scenarios/$file.sh"; done
  chmod +x "$scratch/root/bench/boot_debian"
  echo "$*" >"$scratch/root/bench/scenarios.list"
  disk=$debian_root memory_MiB=3072 append='rdinit=/bench/boot_debian systemd.wants=bench.service systemd.getty_auto=no' boot |
    tee "$log" | show_verdicts
  echo "  guest 'debian' took $((SECONDS - start)) s"
}

# Verdicts only; what is not good stands out. After each scenario how long it took here.
show_verdicts() {
  local line scenario='' start=0
  while IFS= read -r line || [[ -n $line ]]; do
    case $line in
      'ok '*) echo "  ok       ${line#ok }" ;;
      'skip '*) echo "  skipped  ${line#skip }" ;;
      'cannot '*) echo "  CANNOT   ${line#cannot }" ;;
      'not ok '*) echo "  NOT OK   ${line#not ok }" ;;
      'guest:'*) echo "  $line" ;;
      'scenario '* | 'suite ended'*)
        if [[ -n $scenario ]]; then echo "  $scenario took $((SECONDS - start)) s"; fi
        scenario=$line start=$SECONDS
        ;;
    esac
  done
}

# collect NAME: what a guest left, and its verdicts, into `passed` and `failed`.
collect() {
  local log=$logs/vm-$1.log
  if [[ -d $work_folder/$1/out ]]; then cp -r "$work_folder/$1/out" "$results/$1"; fi
  passed=$((passed + $(grep -c '^ok ' "$log" || true)))
  failed=$((failed + $(grep -c '^not ok ' "$log" || true)))
  skipped=$((skipped + $(grep -c '^cannot ' "$log" || true)))
  if grep -qx 'suite ended' "$log"; then return; fi
  failed=$((failed + 1))
  say "the guest '$1' did not come to its end; the log is build/logs/vm-$1.log, its last lines:" >&2
  tail -n 15 "$log" >&2
}

check_scenarios() {
  local passed=0 failed=0 skipped=0 start=$SECONDS guest scenarios
  local -a guests=()
  local -A process
  results=$root/build/vm
  exec 7>"$root/build/.vm-lock"
  if ! flock -n 7; then
    say "waiting for another check in this checkout"
    flock 7
  fi
  work_folder=$(mktemp -d)
  rm -rf "$results"
  mkdir -p "$results"
  rm -f "$logs"/vm-{debian,usb,can,fd,cores}.log
  build_guest_programs
  soak_frames=20000 limit_s=4800
  if [[ -n $quick ]]; then soak_frames=5000; fi
  if [[ -n $long ]]; then soak_frames=1000000 limit_s=36000; fi

  for guest in "${side_by_side[@]}"; do
    choose "$guest" || continue
    if [[ $guest == debian ]]; then run_debian "${scenarios[@]}" & else run_guest "$guest" "${scenarios[@]}" & fi
    process[$guest]=$! guests+=("$guest")
  done
  for guest in "${guests[@]}"; do wait "${process[$guest]}" || true; done
  if choose cores; then
    truncate -s 16M "$work_folder/swap"
    # Without Intel's name QEMU does not say which processors share a core.
    cpus=4 threads=2 model=max,vendor=GenuineIntel disk=$work_folder/swap append='isolcpus=managed_irq,domain,2 nohz_full=2 rcu_nocbs=2' run_guest cores "${scenarios[@]}"
    guests+=(cores)
  fi

  ((${#guests[@]})) || fail 2 "no scenario${quick:+ of --quick} has '$only' in its name"
  for guest in "${guests[@]}"; do collect "$guest"; done
  print_figures
  say "took $((SECONDS - start)) s; what the guests left is in build/vm"
  explained=yes
  if ((skipped > 0)); then echo "$skipped skipped: this machine cannot run them; see above"; fi
  echo "$passed passed, $failed failed"
  ((failed == 0 && passed + skipped > 0)) || exit 1
  ((skipped == 0)) || exit 3
}

# choose GUEST: its scenarios that are asked for, into `scenarios`; false if none is.
choose() {
  scenarios=()
  local each all=${scenarios_of[$1]}
  if [[ -n $quick ]]; then all=${quick_scenarios_of[$1]}; fi
  for each in $all; do
    if [[ -z $only || $each == *"$only"* ]]; then scenarios+=("$each"); fi
  done
  ((${#scenarios[@]})) || return 1
  say "guest '$1': ${scenarios[*]}"
}

# The table of control periods to safe, and the same as JSON.
print_figures() {
  local figures=$results/figures
  cat "$results"/*/figures >"$figures" 2>/dev/null || true
  [[ -s $figures ]] || return 0
  awk '
    { key = $2 " " $3; if (!(key in seen)) { seen[key] = 1; order[++n] = key } value[$1, key] = $4 }
    function cell(link, key) { return (link, key) in value && value[link, key] >= 0 ? value[link, key] : "-" }
    END {
      print "  control periods from the last good command, or from the edge of the e-stop line, to"
      printf "  %-22s %-6s %8s %8s %8s\n", "fault", "", "USB", "CAN", "CAN FD"
      for (i = 1; i <= n; i++) {
        split(order[i], part, " ")
        printf "  %-22s %-6s %8s %8s %8s\n", part[1], part[2], cell("usb", order[i]), cell("can", order[i]), cell("can-fd", order[i])
      }
    }' "$figures"
  awk '
    NR > 1 { print "," }
    NR == 1 { print "[" }
    { printf "  {\"link\": \"%s\", \"fault\": \"%s\", \"to\": \"%s\", \"control_periods\": %s}", $1, $2, $3, $4 }
    END { print "\n]" }' "$figures" >"$results/figures.json"
}
