#!/usr/bin/env bash
# Makes the files of a release on Debian 12: an archive that runs on any Linux with glibc 2.36 or newer, and wheels.
#   tools/packaging/make_release.sh [FOLDER [PYTHON...]]
#   tools/packaging/make_release.sh --arm64 [FOLDER]
# FOLDER (default: build/release_files) receives the builds, sheaf-VERSION-linux-x86_64.tar.xz, and wheels for Debian's
# python3 and for each interpreter PYTHON, which needs its headers. With --arm64, it receives the archive for aarch64
# alone. Needs the packages of tools/install_packages.sh, python3-venv and patchelf, and with --arm64 those of
# tools/packaging/arm64_root.sh; tools of PyPI are installed in FOLDER. tests/package/check_release.sh tests the files.
# Can be rerun.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
source tools/packaging/build_levels.sh
source tools/packaging/arm64_root.sh
processor=x86_64
if [[ ${1:-} == --arm64 ]]; then
  processor=aarch64
  shift
fi
folder=$(realpath -m "${1:-build/release_files}")
debian_python=/usr/bin/python3
version=$(sheaf_version)
name=sheaf-$version-linux-$processor
tree=$folder/$name
libraries=lib/sheaf/libraries

for command in patchelf readelf xz; do
  command -v "$command" >/dev/null || { echo "release: '$command' is missing" >&2; exit 1; }
done
mkdir -p "$folder"

# build_for PYTHON TARGET...: builds with the module for an interpreter. Only the files of the module depend on it.
build_for() {
  build_levels "$folder" -U 'Python_*' -U '_Python_*' -U 'pybind11_*' -DSHEAF_BUILD_PYTHON=ON -DPython_EXECUTABLE="$1" \
    -Dpybind11_DIR="$("$folder/tools/bin/pybind11-config" --cmakedir)" -- "${@:2}"
}

# make_tree BUILD SHEAF [OPTION...]: the contents of the archive. SHEAF is a program that runs on this machine; the options
# are those of bundle_libraries.py.
make_tree() {
  echo "release: collecting $name"
  rm -rf "$tree"
  cmake --install "$1" --prefix "$tree" --strip >/dev/null
  if [[ -d $tree/share/zsh/vendor-completions ]]; then mv "$tree/share/zsh/vendor-completions" "$tree/share/zsh/site-functions"; fi
  sed "s/@VERSION@/$version/" tools/packaging/release_readme.txt >"$tree/README.txt"
  rm -r "$tree/share/doc/sheaf"
  mkdir -p "$tree/share/doc/sheaf" "$tree/LICENSES"
  cp LICENSE "$tree"
  SHEAF=$2 tools/documentation/make_site.sh
  cp -r out/site "$tree/share/doc/sheaf/site"
  # Libraries that are compiled into the program
  local package
  for package in libxsimd-dev libnanovdb-dev libtinygltf-dev libtinyobjloader-dev libcli11-dev nlohmann-json3-dev; do
    cp "/usr/share/doc/$package/copyright" "$tree/LICENSES/$package.txt"
  done
  cp scene/data/daylight_tables.txt "$tree/LICENSES"
  tools/packaging/bundle_libraries.py "$tree" --into "$libraries" --licenses "$tree/LICENSES" "${@:3}"
}

# make_archive: the same contents make the same bytes.
make_archive() {
  echo "release: packing $name.tar.xz"
  tar --create --directory="$folder" --sort=name --owner=0 --group=0 --numeric-owner --mtime="$(git log -1 --format=%cI)" \
    "$name" | xz -9 --extreme --threads=0 >"$folder/$name.tar.xz"
}

# make_wheel PYTHON: the package in Python, with the program, the module and the libraries of the archive.
make_wheel() {
  local contents=$folder/wheel tag level
  tag=$("$1" -c 'import sys; print("cp%d%d" % sys.version_info[:2])')
  echo "release: packing the wheel for $tag"
  rm -rf "$contents"
  mkdir -p "$contents/sheaf/bin"
  cp tools/python/sheaf/*.py tools/python/sheaf/*.pyi tools/python/sheaf/py.typed "$contents/sheaf"
  cp "$tree/bin/sheaf" "$contents/sheaf/bin"
  cp -r "$tree/lib" "$tree/LICENSES" "$contents/sheaf"
  build_for "$1" sheaf_python_module
  for level in "${levels[@]}"; do
    cp "$folder/$level/python/sheaf/_sheaf.so" "$contents/sheaf/lib/sheaf/$level"
    strip --strip-unneeded "$contents/sheaf/lib/sheaf/$level/_sheaf.so"
  done
  # Other modules of the same process have to share these two, so manylinux leaves them to the system.
  rm -f "$contents/sheaf/$libraries"/lib{stdc++.so.6,gcc_s.so.1}
  tools/packaging/bundle_libraries.py "$contents" --into "sheaf/$libraries" --licenses "$contents/sheaf/LICENSES" \
    --keep libstdc++.so.6 --keep libgcc_s.so.1
  "$debian_python" tools/packaging/pack_wheel.py "$contents" "$folder" --tag "$tag-$tag-manylinux_2_36_x86_64" \
    --script tools/packaging/sheaf_script.py
}

make_x86_64() {
  local python wheel
  "$debian_python" -m venv "$folder/tools"
  "$folder/tools/bin/pip" install --quiet auditwheel pybind11
  build_for "$debian_python" sheaf make_cloud
  build_launcher
  make_tree "${builds[0]}" "${builds[0]}/sheaf"
  make_archive
  rm -f "$folder"/sheaf-*.whl
  for python in "$debian_python" "$@"; do make_wheel "$python"; done
  for wheel in "$folder"/sheaf-*.whl; do "$folder/tools/bin/auditwheel" show "$wheel"; done
}

make_aarch64() {
  local root=$folder/arm64_root build=$folder/arm64
  make_arm64_root "$root"
  build_arm64 "$root" "$build" "sheaf make_cloud sheaf_manual" -DSHEAF_MARCH=armv8-a -DSHEAF_BUILD_TESTS=OFF \
    -DSHEAF_BUILD_BENCH=OFF -DSHEAF_BUILD_PYTHON=OFF -DCMAKE_SKIP_INSTALL_ALL_DEPENDENCY=ON
  printf '#!/bin/sh\nexec qemu-aarch64-static -L "%s" "%s/sheaf" "$@"\n' "$root" "$build" >"$folder/sheaf_by_qemu"
  chmod +x "$folder/sheaf_by_qemu"
  make_tree "$build" "$folder/sheaf_by_qemu" --search "$root/usr/lib/aarch64-linux-gnu" --search "$root/lib/aarch64-linux-gnu"
  run_arm64 "$root" "$tree/bin/sheaf" render scenes/cornell/cornell.xml --scale 0.1 --spp 1 -o "$folder/arm64.png"
  make_archive
}

"make_$processor" "${@:2}"
(cd "$folder" && ls -ld sheaf-"$version"*)
