# A clean Debian with systemd, for the guest in which the package is installed: sourced by tools/vm, after image.sh.
# shellcheck shell=bash disable=SC2154
#
# Made by mmdebstrap from the Debian mirror that this machine's apt is set up with; it needs no root (where it has none, a
# user with ids of its own in /etc/subuid, or fakechroot). Kept beside the bench's image as one archive, which the guest
# unpacks into its memory: what a scenario does to it is gone with the guest. In its name are the release, systemd's
# version, and the hash of this file and of the packages in it.

# Debian's own package lists that apt has here, as lines for a sources.list.
debian_sources() {
  apt-get indextargets --format '$(ORIGIN) deb $(REPO_URI) $(CODENAME) $(COMPONENT)' 'Created-By: Packages' 2>/dev/null |
    sed -n 's/^Debian //p' | sort -u
}

# The names of the packages that a .deb depends on, one a line.
dependencies_of() { dpkg-deb -f "$1" Depends | tr ',' '\n' | sed 's/^ *//; s/[ (|].*//'; }

# prepare_debian PACKAGE: sets `debian_root` to the archive, or `debian_missing` to why there is none.
prepare_debian() {
  local folder codename version archive key
  local -a sources packages
  debian_root='' debian_missing=''
  folder=$(cache_folder)
  codename=$(sed -n 's/^VERSION_CODENAME=//p' /etc/os-release)
  mapfile -t sources < <(debian_sources)
  # What a machine has beside Debian's smallest set and what the package itself depends on; of what it suggests, what
  # draws its pages.
  packages=(systemd-sysv udev python3-matplotlib)
  mapfile -t -O "${#packages[@]}" packages < <(dependencies_of "$1")
  version=$(apt-cache madison systemd 2>/dev/null | awk -F' *[|] *' 'NR == 1 { print $2 }')
  key=$( (cat "$bench/debian.sh"; echo "${packages[@]}") | sha256sum | cut -c1-12)
  archive=$folder/debian-$codename-${version:-any}-$key.tar
  exec 8>"$folder/.lock"
  flock 8
  if [[ -f $archive ]]; then
    debian_root=$archive
  elif ! command -v mmdebstrap >/dev/null; then
    debian_missing="no program mmdebstrap; tools/setup --check installs it"
  elif [[ -z $version || ${#sources[@]} == 0 ]]; then
    debian_missing="apt knows no Debian mirror here; try: apt-get update"
  else
    make_debian
  fi
  flock -u 8
}

make_debian() {
  local start=$SECONDS
  say "making a clean Debian ($codename) for the package's scenario, once"
  # No documents and no translations: nobody reads them there, and they are half of it.
  # shellcheck disable=SC2016
  if run_logged vm-debian-root mmdebstrap --variant=minbase --include="$(IFS=,; echo "${packages[*]}")" --format=tar \
      --customize-hook='rm -rf "$1"/usr/share/locale/* "$1"/usr/share/man/* "$1"/usr/share/doc/*' \
      "$codename" "$archive.new" "${sources[@]}"; then
    mv "$archive.new" "$archive"
    find "$folder" -maxdepth 1 -name 'debian-*' -not -path "$archive" -mtime +30 -delete
    debian_root=$archive
    echo "  $((SECONDS - start)) s"
  else
    rm -f "$archive.new"
    debian_missing="mmdebstrap made no root: $(first_error "$logs/vm-debian-root.log"); the log is build/logs/vm-debian-root.log"
  fi
}
