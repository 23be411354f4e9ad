# For the scripts that build what Node runs: sourced, with WORK OUT STAMP as their arguments. Puts the packages of a
# package-lock.json into WORK. Where that is not possible it says why, leaves neither OUT nor STAMP, so that the next build
# tries again, and ends with 0: everything else is built without.

work=$1 out=$2 stamp=$3

# leave_out WHY: `left_out` says what is left out, and who says so.
leave_out() {
  echo "$left_out is left out: $*" >&2
  rm -rf "$out" "$stamp"
  exit 0
}

# install_packages FILE...: copies these files and folders, with their package-lock.json, to WORK, goes there and installs.
install_packages() {
  local program
  for program in node npm; do
    command -v "$program" >/dev/null || leave_out "no program $program (Debian: nodejs, npm)"
  done
  mkdir -p "$work"
  cp -r "$@" "$work"
  cd "$work"
  # Again only where the packages are others than those that are there.
  if ! cmp -s package-lock.json node_modules/.tactus-lock; then
    npm ci --ignore-scripts --no-audit --no-fund >npm.log 2>&1 || leave_out "npm could not install its packages; $work/npm.log says why"
    cp package-lock.json node_modules/.tactus-lock
  fi
}
