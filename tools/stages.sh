# Shared by tools/setup, tools/demo and tools/check: sourced, after `program` is set to the caller's name.
# Messages, one clear line for a failure, logs with progress, configuring and building a preset.
# shellcheck shell=bash

root=$(dirname "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")")
logs=$root/build/logs
# Number of parallel compilers: one per core, and at most one per 1.5 GB of available memory, beyond which a small
# machine swaps.
jobs=$(awk -v cores="$(nproc)" '/^MemAvailable/ { n = int($2 / 1572864); if (n < 1) n = 1
                                                  print n < cores ? n : cores }' /proc/meminfo)
explained=
# The sanitizers of these compilers do not stand the wider address randomisation of some kernels; their test programs
# already run during the build, to list their cases.
same_addresses=()
if setarch "$(uname -m)" -R true 2>/dev/null; then same_addresses=(setarch "$(uname -m)" -R); fi

say() { printf '%s: %s\n' "$program" "$*"; }

# fail STATUS MESSAGE: the one clear line. 1 a check failed, 2 bad usage, 3 the machine cannot do it.
fail() {
  explained=yes
  printf '%s: %s\n' "$program" "${*:2}" >&2
  exit "$1"
}

# Leaves nothing of root's in the checkout of the user behind sudo.
give_back() {
  if [[ $EUID == 0 && -n ${SUDO_UID:-} && -d $root/build && $(stat -c %u "$root") == "$SUDO_UID" ]]; then
    chown -RPh "$SUDO_UID:${SUDO_GID:-$SUDO_UID}" "$root/build" || true
  fi
}

# Whatever ends a script ends it with one line.
on_exit() {
  local status=$1 line=$2 command=$3
  give_back
  if ((status != 0)) && [[ -z $explained ]]; then
    printf '%s: stopped with status %s at line %s: %s\n' "$program" "$status" "$line" "$command" >&2
  fi
}
trap 'on_exit $? $LINENO "$BASH_COMMAND"' EXIT
trap 'fail 130 interrupted' INT
trap 'fail 143 terminated' TERM

open_logs() {
  mkdir -p "$logs" 2>/dev/null && [[ -w $root/build && -w $logs ]] ||
    fail 3 "cannot write to $root/build (owner: $(stat -c %U "$root/build" 2>/dev/null || stat -c %U "$root")); run as that user or with sudo"
}

# One build in this checkout at a time: two would write the same files.
take_lock() {
  open_logs
  exec 9>"$root/build/.lock"
  if ! flock -n 9; then
    say "waiting for another build in this checkout"
    flock 9
  fi
}

# Shows what comes in: on a terminal the last line, in place; else one line every 30 s, so that a log shows life.
show_progress() {
  local line shown=$SECONDS columns
  columns=$(tput cols 2>/dev/null) || columns=80
  while IFS= read -r line; do
    if [[ -t 1 ]]; then
      printf '\r\033[K%.*s' $((columns - 1)) "$line"
    elif ((SECONDS - shown >= 30)); then
      shown=$SECONDS
      printf '  %.100s\n' "$line"
    fi
  done
  if [[ -t 1 ]]; then printf '\r\033[K'; fi
}

# run_logged NAME COMMAND...: output to build/logs/NAME.log, progress on the screen, the command's status.
run_logged() {
  "${@:2}" </dev/null 2>&1 9>&- | tee "$logs/$1.log" | show_progress
}

# The part of a log that explains: from the first failed step of ninja or error of CMake on, else the end.
explain_log() {
  if grep -qE '^(FAILED:|CMake Error)' "$1"; then
    sed -nE '/^(FAILED:|CMake Error)/,$p' "$1" | cut -c1-300 | head -n 40
  else
    tail -n 25 "$1"
  fi
}

# The first line that a tool calls an error, for the middle of our own line.
first_error() { grep -m1 -E '^E: |[Ee]rror' "$1" || tail -n 1 "$1"; }

# configure_preset PRESET: only where it was never done, or the presets have changed; ninja does the rest itself.
configure_preset() {
  local build=$root/build/$1
  if [[ -f $build/CMakeCache.txt ]] && ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$root" "$build/CMakeCache.txt"; then
    rm -rf "$build"  # the checkout has moved: CMake refuses its old cache
  fi
  if [[ -f $build/build.ninja && $build/build.ninja -nt $root/CMakePresets.json ]]; then return; fi
  run_logged "$1-configure" cmake --preset "$1" -S "$root"
}

# build_preset PRESET [TARGET...]: says what it does and how long it took; false if it failed, with the log's end shown.
build_preset() {
  local preset=$1 start=$SECONDS targets=()
  if (($# > 1)); then targets=(--target "${@:2}"); fi
  say "building ($preset)"
  if ! configure_preset "$preset"; then
    explain_log "$logs/$preset-configure.log"
    say "configuring ($preset) failed; the log is build/logs/$preset-configure.log, the reason is above" >&2
    return 1
  fi
  if ! run_logged "$preset-build" "${same_addresses[@]}" \
      cmake --build "$root/build/$preset" --parallel "$jobs" "${targets[@]}"; then
    explain_log "$logs/$preset-build.log"
    say "building ($preset) failed; the log is build/logs/$preset-build.log, the reason is above" >&2
    return 1
  fi
  echo "  $((SECONDS - start)) s"
}
