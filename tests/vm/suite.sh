# The scenarios, run and counted: sourced by tools/vm, after image.sh.
# shellcheck shell=bash disable=SC2154
#
# Two guests. `links` has one processor whose clock counts instructions: everything that the wire, the firmware and the
# host program do is in it, at the nominal rate on any machine. `cores` has three, one of them isolated, on this
# machine's clock: what the kernel grants. Each verdict that a scenario prints counts as one test.

links_scenarios=(drivers user:usb user:can)
for link in usb can can-fd; do links_scenarios+=("faults:$link" "hostile:$link" "hil:$link" "house:$link"); done
cores_scenarios=(cores:usb)
guest_tools=(candump cansend cangen)

# What the scenarios need of the build; the guest tests are taken as far as they exist.
guest_programs() { find "$build/tests/vm" -maxdepth 1 -type f -name '*_guest_test' -perm -u+x; }

build_guest_programs() {
  if [[ -n $build_given ]]; then return; fi
  take_lock
  build_preset release tactus bench_programs || fail 1 "nothing to run: the build failed"
  exec 9>&-
}

# run_guest NAME LIMIT_S OPTION... : one guest with its scenarios ($scenarios); each verdict is shown as it comes.
run_guest() {
  local name=$1 file start=$SECONDS
  limit_s=$2
  scratch=$work_folder/$name
  mkdir -p "$scratch/root/etc" "$logs"
  for file in "$build/tools/tactus" "$build/tests/vm/bench_device" $(guest_programs); do add_file "$file"; done
  for file in "${guest_tools[@]}"; do
    add_file "$(command -v "$file")"
  done
  for file in "$bench"/guest/{suite,provoke,lib.sh} "$bench/press.toml" "$root/sim/scenes/card_house.toml"; do
    add_file "$file" "bench/$(basename "$file")"
  done
  for file in "$bench"/scenarios/*.sh; do add_file "$file" "bench/scenarios/$(basename "$file")"; done
  echo "SOAK_FRAMES=$soak_frames exec sh /bench/suite ${scenarios[*]}" >"$scratch/root/etc/command"
  boot | tee "$logs/vm-$name.log" | show_verdicts
  echo "  guest '$name' took $((SECONDS - start)) s"
  if [[ -d $scratch/out ]]; then mkdir -p "$results/$name" && cp -r "$scratch/out/." "$results/$name/"; fi
  count_verdicts "$logs/vm-$name.log" "$name"
}

# Verdicts only; what is not good stands out.
show_verdicts() { sed -u -n 's/^ok /  ok       /p; s/^skip /  skipped  /p; s/^not ok /  NOT OK   /p; s/^guest:/  &/p'; }

count_verdicts() {
  passed=$((passed + $(grep -c '^ok ' "$1" || true)))
  failed=$((failed + $(grep -c '^not ok ' "$1" || true)))
  if ! grep -qx 'suite ended' "$1"; then
    failed=$((failed + 1))
    say "the guest '$2' did not come to its end; the log is build/logs/vm-$2.log, its last lines:" >&2
    tail -n 15 "$1" >&2
  fi
}

check_scenarios() {
  local passed=0 failed=0 scenarios all start=$SECONDS
  results=$root/build/vm
  work_folder=$(mktemp -d)
  scratch=$work_folder
  rm -rf "$results"
  mkdir -p "$results"
  build_guest_programs
  soak_frames=20000 limit_of_links_s=1500
  if [[ -n $long ]]; then soak_frames=1000000 limit_of_links_s=36000; fi
  choose "${links_scenarios[@]}"
  if ((${#scenarios[@]})); then
    say "the links in the guest: ${scenarios[*]}"
    run_guest links "$limit_of_links_s"
  fi
  choose "${cores_scenarios[@]}"
  if ((${#scenarios[@]})); then
    say "cores and rights in the guest: ${scenarios[*]}"
    cpus=3 append='isolcpus=2 nohz_full=2 rcu_nocbs=2' run_guest cores 240
  fi
  scratch=$work_folder
  print_figures
  say "took $((SECONDS - start)) s; what the guests left is in build/vm"
  explained=yes
  echo "$passed passed, $failed failed"
  ((failed == 0)) || exit 1
  ((passed > 0)) || fail 2 "no scenario has '$only' in its name"
}

# choose SCENARIO...: those asked for, into `scenarios`.
choose() {
  scenarios=()
  local each
  for each in "$@"; do
    if [[ -z $only || $each == *"$only"* ]]; then scenarios+=("$each"); fi
  done
}

# The table of control periods to safe, and the same as JSON.
print_figures() {
  local figures=$results/links/figures
  [[ -s $figures ]] || return 0
  awk '
    { key = $2 " " $3; if (!(key in seen)) { seen[key] = 1; order[++n] = key } value[$1, key] = $4 }
    function cell(link, key) { return (link, key) in value && value[link, key] >= 0 ? value[link, key] : "-" }
    END {
      print "  control periods from the last good command, or from the edge of the e-stop line, to"
      printf "  %-20s %-6s %8s %8s %8s\n", "fault", "", "USB", "CAN", "CAN FD"
      for (i = 1; i <= n; i++) {
        split(order[i], part, " ")
        printf "  %-20s %-6s %8s %8s %8s\n", part[1], part[2], cell("usb", order[i]), cell("can", order[i]), cell("can-fd", order[i])
      }
    }' "$figures"
  awk '
    { printf "%s  {\"link\": \"%s\", \"fault\": \"%s\", \"to\": \"%s\", \"control_periods\": %s}", NR > 1 ? ",\n" : "[\n", $1, $2, $3, $4 }
    END { print "\n]" }' "$figures" >"$results/figures.json"
}
