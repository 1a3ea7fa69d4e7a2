#!/usr/bin/env bash
# Installs the Debian packages that Sheaf needs for building, and the packages in its arguments. If all are installed,
# it is quick and needs no network. With --list alone, prints the packages instead.
set -euo pipefail

lists=false
if [[ ${1:-} == --list ]]; then
  lists=true
  shift
fi
packages=(
  clang g++ cmake ninja-build
  libembree-dev libtbb-dev
  libopenexr-dev libimath-dev libpng-dev libjpeg-dev libtiff-dev libwebp-dev libopencolorio-dev zlib1g-dev
  libpugixml-dev libnanovdb-dev
  libtinyobjloader-dev libtinygltf-dev libdraco-dev libmeshoptimizer-dev libassimp-dev
  libxsimd-dev libfmt-dev libcli11-dev nlohmann-json3-dev libmicrohttpd-dev
  pybind11-dev python3-dev python3-numpy
  doctest-dev libbenchmark-dev
  "$@"
)
if $lists; then
  printf '%s\n' "${packages[@]}"
  exit 0
fi

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
  [[ $status == installed ]] || missing+=("$package")
done
if ((${#missing[@]} == 0)); then
  echo "packages: all ${#packages[@]} are installed"
  exit 0
fi

echo "packages: installing ${missing[*]}"
as_root=()
if ((EUID != 0)); then
  command -v sudo >/dev/null || { echo "packages: run as root, or install sudo" >&2; exit 1; }
  as_root=(sudo)
fi
run_apt() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0 "$@"
}
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! { run_apt update && run_apt install --yes --no-install-recommends "${missing[@]}"; } >"$log" 2>&1; then
  cat "$log" >&2
  exit 1
fi
echo "packages: done"
