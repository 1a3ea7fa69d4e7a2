#!/usr/bin/env bash
# Makes a Debian package of Sheaf for this release of Debian, with the program built for x86-64-v3 and x86-64-v4.
#   tools/packaging/make_package.sh [FOLDER]      default: build/package; receives the builds and the package
# Needs the packages of tools/install_packages.sh, and dpkg-dev, file and python3. Can be rerun.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
folder=$(realpath -m "${1:-build/package}")
source tools/packaging/build_levels.sh

for tool in dpkg-shlibdeps file python3; do
  command -v "$tool" >/dev/null || { echo "package: install the packages dpkg-dev, file and python3 first" >&2; exit 1; }
done
build_levels "$folder" -DSHEAF_BUILD_PYTHON=OFF -- sheaf make_cloud
build_launcher

echo "package: packing"
rm -f "$folder"/sheaf_*.deb
(cd "$folder" && cpack --config "$(basename "${builds[0]}")/CPackConfig.cmake" -D CPACK_CMAKE_GENERATOR=Ninja >cpack.log) ||
  { cat "$folder/cpack.log" >&2; exit 1; }
ls "$folder"/sheaf_*.deb
