# Functions that run commands in a Debian root file system, for scripts that source this file. Needs root and the
# package debootstrap.

# Prints the mirror of apt on this machine; SHEAF_DEBIAN_MIRROR overrides it.
debian_mirror() {
  if [[ -n ${SHEAF_DEBIAN_MIRROR:-} ]]; then
    echo "$SHEAF_DEBIAN_MIRROR"
    return
  fi
  apt-get indextargets --format '$(ORIGIN) $(CODENAME) $(REPO_URI)' 'Created-By: Packages' |
    awk '$1 == "Debian" && $2 !~ /-/ { print $3; exit }'
}

# make_debian_root FOLDER RELEASE: creates it unless it exists. Meanwhile FOLDER.log holds the log.
make_debian_root() {
  local root=$1 release=$2 mirror
  [[ ! -e $root/.complete ]] || return 0
  mirror=$(debian_mirror)
  [[ -n $mirror ]] || { echo "no Debian mirror in apt's sources; set SHEAF_DEBIAN_MIRROR" >&2; return 1; }
  echo "making $root"
  rm -rf "$root"
  mkdir -p "$root"
  debootstrap --variant=minbase "$release" "$root" "$mirror" >"$root.log" 2>&1 || { tail -n 20 "$root.log" >&2; return 1; }
  apt-config dump | grep -E '^Acquire::(Check-|https?::Proxy)' >"$root/etc/apt/apt.conf.d/90host" || true
  touch "$root/.complete"
}

# open_debian_root FOLDER: copies the network settings, and mounts proc, sysfs and devpts (for pseudo-terminals).
# Unmounts them when the script exits.
open_debian_root() {
  debian_root=$1
  cp /etc/resolv.conf /etc/hosts "$debian_root/etc/"
  debian_mounted=()
  trap close_debian_root EXIT
  local kind folder
  for kind in proc sysfs devpts; do
    case $kind in
      devpts) folder=$debian_root/dev/pts ;;
      *) folder=$debian_root/${kind%fs} ;;
    esac
    if ! mountpoint -q "$folder"; then
      mount -t "$kind" "$kind" "$folder"
      debian_mounted+=("$folder")
    fi
  done
}
close_debian_root() {
  local folder
  for folder in "${debian_mounted[@]}"; do umount "$folder"; done
  debian_mounted=()
}

# in_root COMMAND...: runs a command in the folder that was opened last.
in_root() {
  chroot "$debian_root" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 "$@"
}
