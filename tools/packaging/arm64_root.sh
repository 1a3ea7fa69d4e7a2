# Functions that compile Sheaf for ARM64 on another machine, for scripts that source this file and run in the repository.
# They need the packages lld and qemu-user-static, but no root.

source "$(dirname "${BASH_SOURCE[0]}")/debian_root.sh"

# arm64_packages: prints the development packages of Sheaf, without those of Python and of benchmarks.
arm64_packages() {
  tools/install_packages.sh --list | grep -e '-dev$' | grep -vE '^(python3|pybind11|libbenchmark)-dev$'
  echo libc6-dev
  echo libstdc++-12-dev
}

# make_arm64_root FOLDER: unpacks Debian 12's packages for arm64 and their dependencies unless that is done. No script
# of a package runs: for apt, the folder is an empty system. The mirror is the one of debian_mirror.
make_arm64_root() {
  local root=$1 mirror package link target
  [[ ! -e $root/.complete ]] || return 0
  mirror=$(debian_mirror)
  [[ -n $mirror ]] || { echo "no Debian mirror in apt's sources; set SHEAF_DEBIAN_MIRROR" >&2; return 1; }
  echo "making $root"
  rm -rf "$root"
  mkdir -p "$root"/etc/apt/{apt.conf.d,preferences.d} "$root"/var/lib/{apt/lists/partial,dpkg} \
    "$root"/var/cache/apt/archives/partial
  touch "$root/var/lib/dpkg/status"
  echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $mirror bookworm main" >"$root/etc/apt/sources.list"
  cat >"$root/etc/apt/apt.conf" <<END
Dir "$root";
Dir::State::status "$root/var/lib/dpkg/status";
APT::Architecture "arm64";
APT::Architectures { "arm64"; };
APT::Install-Recommends "false";
APT::Sandbox::User "";
Acquire::Languages "none";
END
  apt-config dump | grep -E '^Acquire::(Check-|https?::Proxy)' >>"$root/etc/apt/apt.conf" || true
  # shellcheck disable=SC2046  # one word per package
  if ! { APT_CONFIG=$root/etc/apt/apt.conf apt-get -qq update &&
    APT_CONFIG=$root/etc/apt/apt.conf apt-get -qq --yes --download-only install $(arm64_packages); } >"$root.log" 2>&1; then
    tail -n 20 "$root.log" >&2
    return 1
  fi
  for package in "$root"/var/cache/apt/archives/*.deb; do
    dpkg-deb --fsys-tarfile "$package" | tar --extract --directory="$root" --no-same-owner --exclude=./usr/share/doc \
      --exclude=./usr/share/man --exclude=./usr/share/locale
    rm "$package"
  done
  # Absolute links would leave the root.
  find "$root" -type l -lname '/*' -printf '%p\t%l\n' | while IFS=$'\t' read -r link target; do
    ln -sfr "$root$target" "$link"
  done
  touch "$root/.complete"
}

# build_arm64 ROOT BUILD TARGETS [OPTION]...: configures in the folder BUILD, with options of cmake, and builds the
# targets, which are words of one argument.
build_arm64() {
  local root=$1 build=$2 targets=$3
  shift 3
  mkdir -p "$build"
  cmake --preset release -B "$build" --toolchain cmake/toolchains/aarch64.cmake -DCMAKE_SYSROOT="$root" "$@" \
    >"$build.log" 2>&1 || { cat "$build.log" >&2; return 1; }
  # shellcheck disable=SC2086  # one word per target
  cmake --build "$build" --target $targets
}

# run_arm64 ROOT COMMAND...: runs a program for ARM64.
run_arm64() {
  qemu-aarch64-static -L "$@"
}
