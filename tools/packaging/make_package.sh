#!/usr/bin/env bash
# Makes a Debian package of Sheaf for this release of Debian, with the program built for x86-64-v3 and x86-64-v4.
#   tools/packaging/make_package.sh [FOLDER]      default: build/package; receives the builds and the package
# Needs the packages of tools/install_packages.sh, and dpkg-dev, file and python3. Can be rerun.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
folder=$(realpath -m "${1:-build/package}")
levels=(x86-64-v3 x86-64-v4)

for tool in dpkg-shlibdeps file python3; do
  command -v "$tool" >/dev/null || { echo "package: install the packages dpkg-dev, file and python3 first" >&2; exit 1; }
done
builds=()
for level in "${levels[@]}"; do
  echo "package: building for $level"
  cmake --preset release -B "$folder/$level" -DSHEAF_MARCH="$level" -DSHEAF_BUILD_TESTS=OFF -DSHEAF_BUILD_BENCH=OFF \
    -DSHEAF_BUILD_PYTHON=OFF -DSHEAF_PACKAGED_BUILDS= -DCMAKE_SKIP_INSTALL_ALL_DEPENDENCY=ON >/dev/null
  cmake --build "$folder/$level" --target sheaf make_cloud
  builds+=("$folder/$level")
done

echo "package: packing"
# Making the manual runs the program of the first build, which has the lowest level.
cmake -B "$folder/${levels[0]}" -DSHEAF_PACKAGED_BUILDS="$(IFS=';'; echo "${builds[*]}")" >/dev/null
cmake --build "$folder/${levels[0]}" --target sheaf_launcher sheaf_manual
rm -f "$folder"/sheaf_*.deb
(cd "$folder" && cpack --config "${levels[0]}/CPackConfig.cmake" -D CPACK_CMAKE_GENERATOR=Ninja >cpack.log) ||
  { cat "$folder/cpack.log" >&2; exit 1; }
ls "$folder"/sheaf_*.deb
