#!/usr/bin/env bash
# Builds and tests Sheaf on Debian 13, in a root file system that debootstrap creates and that later runs reuse.
#   tools/packaging/check_debian13.sh [FOLDER]      default: build/debian13
# Needs root (or sudo) and the package debootstrap. The mirror is the one of apt on this machine; SHEAF_DEBIAN_MIRROR
# overrides it. SHEAF_MARCH (default: native) is the instruction set to build for.
set -euo pipefail

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
root=$(realpath -m "${1:-$repository/build/debian13}")
march=${SHEAF_MARCH:-native}
source_in_root=/root/sheaf

if ((EUID != 0)); then
  exec sudo --preserve-env=SHEAF_DEBIAN_MIRROR,SHEAF_MARCH "$0" "$@"
fi
command -v debootstrap >/dev/null || { echo "debian13: install the package debootstrap first" >&2; exit 1; }

source "$repository/tools/packaging/debian_root.sh"
make_debian_root "$root" trixie
open_debian_root "$root"

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
