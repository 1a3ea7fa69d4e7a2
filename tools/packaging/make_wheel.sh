#!/usr/bin/env bash
# Makes a wheel of the Python package for this release of Debian, with the module built for x86-64-v3 and x86-64-v4.
#   tools/packaging/make_wheel.sh [FOLDER [LEVEL...]]      default: build/wheel, both levels; receives the builds and the wheel
# Needs the packages of tools/install_packages.sh. Can be rerun.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
folder=$(realpath -m "${1:-build/wheel}")
levels=("${@:2}")
((${#levels[@]} > 0)) || levels=(x86-64-v3 x86-64-v4)

for level in "${levels[@]}"; do
  echo "wheel: building for $level"
  cmake --preset release -B "$folder/$level" -DSHEAF_MARCH="$level" -DSHEAF_BUILD_TESTS=OFF -DSHEAF_BUILD_BENCH=OFF \
    -DSHEAF_BUILD_PYTHON=ON >/dev/null
  cmake --build "$folder/$level" --target sheaf_python_module
done

echo "wheel: packing"
contents=$folder/contents
rm -rf "$contents"
mkdir -p "$contents/sheaf"
cp tools/python/sheaf/*.py tools/python/sheaf/*.pyi tools/python/sheaf/py.typed "$contents/sheaf"
for level in "${levels[@]}"; do
  mkdir "$contents/sheaf/$level"
  # The libraries and the helper are links in the build folder
  for file in _sheaf.so sheaf_color_io.so sheaf_import_model; do
    [ ! -e "$folder/$level/python/sheaf/$file" ] || cp -L "$folder/$level/python/sheaf/$file" "$contents/sheaf/$level"
  done
  strip --strip-unneeded "$contents/sheaf/$level"/*
done
exec /usr/bin/python3 tools/packaging/pack_wheel.py "$contents" "$folder"
