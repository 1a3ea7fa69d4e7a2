#!/usr/bin/env bash
# Builds and tests Sheaf on Debian 13, in a folder of its own that debootstrap makes and later runs use again.
#   tools/check_debian13.sh [FOLDER]      default: build/debian13
# Needs root (or sudo) and the package debootstrap. The mirror is the one that apt on this machine uses;
# SHEAF_DEBIAN_MIRROR names another. SHEAF_MARCH (default: native) is the instruction set to build for.
set -euo pipefail

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
root=$(realpath -m "${1:-$repository/build/debian13}")
march=${SHEAF_MARCH:-native}
source_in_root=/root/sheaf

if ((EUID != 0)); then
  exec sudo --preserve-env=SHEAF_DEBIAN_MIRROR,SHEAF_MARCH "$0" "$@"
fi
command -v debootstrap >/dev/null || { echo "debian13: install the package debootstrap first" >&2; exit 1; }

host_mirror() {
  apt-get indextargets --format '$(ORIGIN) $(CODENAME) $(REPO_URI)' 'Created-By: Packages' |
    awk '$1 == "Debian" && $2 !~ /-/ { print $3; exit }'
}

make_root() {
  local mirror=${SHEAF_DEBIAN_MIRROR:-$(host_mirror)}
  [[ -n $mirror ]] || { echo "debian13: no Debian mirror in apt's sources; set SHEAF_DEBIAN_MIRROR" >&2; exit 1; }
  echo "debian13: making $root"
  rm -rf "$root"
  mkdir -p "$root"
  debootstrap --variant=minbase trixie "$root" "$mirror" >"$root.log" 2>&1 || { tail -n 20 "$root.log" >&2; exit 1; }
  apt-config dump | grep -E '^Acquire::(Check-|https?::Proxy)' >"$root/etc/apt/apt.conf.d/90host" || true
  touch "$root/.complete"
}

in_root() {
  chroot "$root" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 "$@"
}

[[ -e $root/.complete ]] || make_root
cp /etc/resolv.conf /etc/hosts "$root/etc/"
mounted=()
unmount_all() {
  for folder in "${mounted[@]}"; do umount "$folder"; done
}
trap unmount_all EXIT
for kind in proc sysfs; do
  folder=$root/${kind%fs}
  if ! mountpoint -q "$folder"; then
    mount -t "$kind" "$kind" "$folder"
    mounted+=("$folder")
  fi
done

echo "debian13: copying the working tree"
mkdir -p "$root$source_in_root"
find "$root$source_in_root" -mindepth 1 -maxdepth 1 ! -name build -exec rm -rf {} +
git -c safe.directory="$repository" -C "$repository" ls-files --cached --others --exclude-standard -z |
  (cd "$repository" && while IFS= read -r -d '' file; do [[ ! -e $file ]] || printf '%s\0' "$file"; done |
    tar --create --null --files-from=- --file=-) |
  tar --extract --file=- --directory="$root$source_in_root" --no-same-owner

in_root "$source_in_root/tools/install_packages.sh" python3
in_root bash -euo pipefail -c "
  cd $source_in_root
  cmake --preset release -DSHEAF_MARCH=$march
  cmake --build --preset release
  ctest --preset release --parallel $(nproc)"
