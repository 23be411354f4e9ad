# The bench's kernel and base image: sourced by tools/vm, after tools/stages.sh.
# shellcheck shell=bash disable=SC2154
#
# From Debian's packages, downloaded and unpacked without root: the PREEMPT_RT kernel with its modules, its headers (to
# build gpio-sim, which Debian's kernel leaves out), the kernel's source (gpio-sim itself) and udev. The result is kept
# in the user's cache folder, under the kernel's package version and the hash of what this folder makes of it:
#   KEY/vmlinux        the kernel
#   KEY/base.cpio      busybox, udev, the modules, the start script: all that does not change from run to run
#   KEY/release        the kernel's release, such as 6.1.0-56-rt-amd64

kernel_modules=(vcan can_raw kvaser_pci dummy_hcd usb_f_fs libcomposite virtio_pci virtio_blk)
bench=$root/tests/vm

# Where images are kept: the user's cache; build/ where that cannot be written.
cache_folder() {
  local folder=${XDG_CACHE_HOME:-${HOME:-/nonexistent}/.cache}/tactus/vm
  if mkdir -p "$folder" 2>/dev/null && [[ -w $folder ]]; then echo "$folder"; else echo "$root/build/vm/image"; fi
}

# One line for each thing that is missing here to run the bench; nothing if all is there.
missing_for_bench() {
  local program
  for program in qemu-system-x86_64 busybox dash ip capsh candump cansend cangen cpio depmod make gcc xz dpkg-deb apt-get; do
    command -v "$program" >/dev/null || echo "no program $program"
  done
  command -v qemu-system-x86_64 >/dev/null || return 0
  # AVX2 in the emulated processor, which the programs are built for, came with version 7.2.
  local version
  version=$(qemu-system-x86_64 --version | sed -n '1s/.*version \([0-9]*\.[0-9]*\).*/\1/p')
  if [[ $(printf '%s\n' 7.2 "$version" | sort -V | head -n 1) != 7.2 ]]; then echo "QEMU $version is older than 7.2"; fi
  qemu-system-x86_64 -device help 2>/dev/null | grep -q '"kvaser_pci"' || echo "this QEMU has no kvaser_pci"
}

# The release of Debian's current real-time kernel, and its package version; nothing if apt knows none.
newest_kernel() {
  local release version
  release=$(apt-cache depends linux-image-rt-amd64 2>/dev/null | sed -n 's/^ *Depends: linux-image-//p' | head -n 1)
  [[ -n $release ]] || return 0
  version=$(apt-cache madison "linux-image-$release" 2>/dev/null | awk -F' *[|] *' 'NR == 1 { print $2 }')
  echo "$release $version"
}

# Sets `image` to the folder of a ready image, or fails with status 3 and why.
prepare_image() {
  local folder release version recipe missing
  missing=$(missing_for_bench | paste -sd ';' | sed 's/;/; /g')
  [[ -z $missing ]] || fail 3 "the bench cannot run here: $missing; tools/setup --check installs what it needs"
  folder=$(cache_folder)
  mkdir -p "$folder" 2>/dev/null || fail 3 "cannot write to $folder, nor to a cache folder"
  recipe=$(cat "$bench/image.sh" "$bench/gpio_bench.c" "$bench/guest/init" /usr/bin/busybox | sha256sum | cut -c1-12)
  read -r release version < <(newest_kernel) || true
  if [[ -z ${release:-} ]]; then
    # Without package lists an image that was made earlier still serves.
    image=$(find "$folder" -maxdepth 1 -name "*-$recipe" -printf '%T@ %p\n' | sort -n | tail -n 1 | cut -d' ' -f2-)
    [[ -n $image ]] || fail 3 "apt knows no package linux-image-rt-amd64 (Debian's real-time kernel); try: apt-get update"
    return
  fi
  image=$folder/$version-$recipe
  exec 8>"$folder/.lock"
  flock 8
  if [[ ! -f $image/release ]]; then make_image "$folder" "$release" "$version"; fi
  flock -u 8
}

make_image() {
  local folder=$1 release=$2 version=$3 start=$SECONDS
  work=$folder/.new
  rm -rf "$work"
  mkdir -p "$work"/{packages,debian,module,root,ready}
  say "making the image of the bench ($release; 130 MB of Debian packages, once)"
  run_logged vm-image make_image_parts "$release" "$version" ||
    fail 3 "the image of the bench could not be made: $(first_error "$logs/vm-image.log"); the log is build/logs/vm-image.log; if a package was not found: apt-get update"
  echo "$release" >"$work/ready/release"
  rm -rf "$image"
  mv "$work/ready" "$image"
  rm -rf "$work"
  # Images of other kernels and of older recipes.
  find "$folder" -mindepth 1 -maxdepth 1 -type d -not -path "$image" -mtime +30 -exec rm -rf {} +
  echo "  $((SECONDS - start)) s"
}

# The parts in order; the first that fails ends it (run in a pipe, where `set -e` does not reach).
make_image_parts() {
  get_packages "$1" "$2" && build_gpio_module "$1" && fill_root "$1" && pack "$work/root" "$work/ready/base.cpio" &&
    unpack_kernel "$work/debian/boot/vmlinuz-$1" "$work/ready/vmlinux"
}

# The kernel itself out of the file that unpacks itself at boot: emulated, that would take longer than all the rest of
# the boot. Offsets are those of the header that boot loaders read (Linux, Documentation/x86/boot.rst); the last four
# bytes of the payload are its length.
unpack_kernel() {
  local sectors offset length
  echo "unpacking the kernel"
  sectors=$(od -An -tu1 -j $((0x1f1)) -N 1 "$1")
  offset=$(od -An -tu4 -j $((0x248)) -N 4 "$1")
  length=$(od -An -tu4 -j $((0x24c)) -N 4 "$1")
  dd if="$1" bs=1M iflag=skip_bytes,count_bytes skip=$(((sectors + 1) * 512 + offset)) count=$((length - 4)) status=none |
    xz -dc >"$2"
}

# A mirror may have the kernel's parts in two revisions for some hours: what runs is of one version, the tools that build
# modules (kbuild) are any of the release's, and the source is of the same upstream version.
get_packages() {
  local release=$1 version=$2 package source
  local packages=("linux-image-$release=$version" "linux-headers-$release=$version"
    "linux-headers-${release%-rt-amd64}-common-rt=$version" "linux-kbuild-${release%%.0-*}" udev libkmod2)
  kernel_source=/usr/src/linux-source-${release%%.0-*}.tar.xz
  source=$(dpkg-query -W -f='${Version}' "linux-source-${release%%.0-*}" 2>/dev/null)
  if [[ ${source%-*} != "${version%-*}" ]]; then
    packages+=("linux-source-${release%%.0-*}=$version")
    kernel_source=$work/debian$kernel_source
  fi
  echo "downloading ${packages[*]}"
  (cd "$work/packages" && apt-get -q download -o APT::Sandbox::User=root "${packages[@]}") || return 1
  for package in "$work"/packages/*.deb; do
    echo "unpacking $(basename "$package")"
    dpkg-deb -x "$package" "$work/debian" || return 1
    rm "$package"
  done
}

build_gpio_module() {
  local headers=$work/debian/usr/src/linux-headers-$1
  echo "building gpio-sim"
  # Debian's headers name each other by absolute path; here they are not installed.
  sed -i "s|^include /usr/src|include $work/debian/usr/src|" "$headers/Makefile" || return 1
  tar -xJf "$kernel_source" -C "$work/module" --strip-components=3 --wildcards --occurrence=1 \
    '*/drivers/gpio/gpio-sim.c' '*/drivers/gpio/gpiolib.h' '*/kernel/irq/irq_sim.c' || return 1
  cp "$bench/gpio_bench.c" "$work/module/" && echo 'obj-m := gpio_bench.o' >"$work/module/Makefile" &&
    make -C "$headers" M="$work/module" modules
}

fill_root() {
  local release=$1 into=$work/root applet file
  mkdir -p "$into"/{bin,modules,etc,proc,sys,dev,tmp,run,usr/lib,lib/udev/rules.d,user,out} || return 1
  chmod 1777 "$into/tmp" "$into/out"
  cp /usr/bin/busybox "$into/bin/" || return 1
  for applet in $(busybox --list); do
    [[ $applet == busybox ]] || ln -sf busybox "$into/bin/$applet"
  done
  # Programs of the same name that can more; and a shell that takes what stands in /bin before what busybox has built in.
  for file in dash ip capsh; do
    rm -f "$into/bin/$file"
    cp -L "$(command -v "$file")" "$into/bin/" && copy_libraries "$into/bin/$file" "$into" || return 1
  done
  ln -sf dash "$into/bin/sh"
  # udev gives the user access to a device that is plugged in, and libusb its hot-plug events, as on a PC.
  cp "$work/debian/bin/udevadm" "$into/bin/" && ln -s udevadm "$into/bin/systemd-udevd" &&
    copy_libraries "$work/debian/bin/udevadm" "$into" "$work/debian/usr/lib/x86_64-linux-gnu:$work/debian/lib/x86_64-linux-gnu" || return 1
  install -m 755 "$bench/guest/init" "$into/init" || return 1
  printf 'root:x:0:0::/:/bin/sh\ntactus:x:1000:1000::/user:/bin/sh\n' >"$into/etc/passwd"
  printf 'root:x:0:\ntactus:x:1000:\nplugdev:x:46:tactus\n' >"$into/etc/group"
  chown 1000:1000 "$into/user" 2>/dev/null || true
  echo "choosing the modules"
  depmod -b "$work/debian" "$release" || return 1
  for file in "${kernel_modules[@]}"; do
    modprobe -d "$work/debian" -S "$release" --show-depends "$file" || return 1
  done | awk '$1 == "insmod" && !seen[$2]++ { print $2 }' >"$work/modules"
  while read -r file; do
    cp "$file" "$into/modules/" && basename "$file" >>"$into/etc/modules" || return 1
  done <"$work/modules"
  cp "$work/module/gpio_bench.ko" "$into/modules/" && echo gpio_bench.ko >>"$into/etc/modules"
}

# copy_libraries PROGRAM INTO [PATH]: the shared libraries that a program needs, to the same places under INTO.
copy_libraries() {
  local library
  while read -r library; do
    if [[ -f $2/$library ]]; then continue; fi
    install -D "$library" "$2/${library#"${work:-/nonexistent}/debian"}" || return 1
  done < <(LD_LIBRARY_PATH=${3:-} ldd "$1" 2>/dev/null | awk '/=> \// { print $3 } /^\t\// { print $1 }')
}

# pack FOLDER FILE: the folder as the kernel takes it; all of it root's, and everybody may read it.
pack() { chmod -R a+rX "$1" && (cd "$1" && find . -print0 | sort -z | cpio --null --create --format=newc --owner=0:0 --quiet) >"$2"; }
