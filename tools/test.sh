#!/usr/bin/env bash
# Runs all tests from a clean checkout on Debian 12 or 13. Can be rerun. The tests run twice. The first run uses
# sanitizers, on unit tests that are not slow, on one image of each example scene, and on mutated files for each file
# reader (tests/fuzz/README.md). The second run is optimised and includes benchmarks, scripts and whole images; ctest's
# summary comes last.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

tools/install_packages.sh python3 python3-numpy python3-scipy python3-matplotlib chromium clang-format mkdocs \
  mkdocs-material python3-pygments
# For the test of `sheaf farm` on a local cluster; without these packages it is skipped.
tools/slurm.sh install
for preset in asan release; do
  echo "test: configuring $preset"
  cmake --preset "$preset" >/dev/null
  echo "test: building $preset"
  cmake --build --preset "$preset"
  echo "test: running $preset"
  ctest --preset "$preset" --parallel "$(nproc)"
done
