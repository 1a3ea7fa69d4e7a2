#!/usr/bin/env bash
# Renders an image from a clean checkout on Debian 12 or 13. Can be rerun.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

tools/install_packages.sh
echo "quickstart: configuring"
cmake --preset release >/dev/null
echo "quickstart: building"
cmake --build --preset release --target sheaf make_cloud
mkdir -p out
build/release/sheaf render scenes/cornell/cornell.xml -o out/cornell.exr -o out/cornell.png
echo "quickstart: see $PWD/out/cornell.png and $PWD/out/cornell.exr"
