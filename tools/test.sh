#!/usr/bin/env bash
# Runs all tests from a clean checkout on Debian 12 or 13. Can be rerun. The first of two runs uses sanitizers, on unit
# tests that are not slow, on one image of each example scene, and on mutated files for each file reader
# (tests/fuzz/README.md). The second run is optimized. It repeats the tests of core and kernels, and includes slow tests,
# benchmarks, scripts and whole images; ctest's summary comes last, after the coverage of the Python package. Both render
# the scenes that the first one generates.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

tools/install_packages.sh python3 python3-numpy python3-scipy python3-matplotlib chromium clang-format lld mkdocs \
  mkdocs-material python3-pygments python3-coverage
# For the test of `sheaf farm` on a local cluster; without these packages it is skipped.
tools/farm/slurm.sh install
for preset in asan release; do
  echo "test: configuring $preset"
  options=()
  [ "$preset" = release ] && options=("-DSHEAF_ONLY_SLOW_TESTS=scene" "-DSHEAF_GENERATED_SCENES=$PWD/build/asan/smoke")
  cmake --preset "$preset" "${options[@]}" >/dev/null
  echo "test: building $preset"
  cmake --build --preset "$preset"
  echo "test: running $preset"
  # One more than there are cores: some tests wait for other programs.
  coverage=build/$preset/python/coverage.txt
  ctest --preset "$preset" --parallel "$(($(nproc) + 1))" |
    sed -u "/ tests passed, /e [ ! -f $coverage ] || cat $coverage"
done
