#!/usr/bin/env bash
# From a clean checkout on Debian 12 or 13 to the results of all tests. Can be run again.
# The tests run twice: with sanitizers (those of units that aren't slow, and one picture of each example scene), then
# optimised, benchmarks, scripts and whole pictures included; ctest's summary comes last. Between them everything that
# reads files is fuzzed for a short time (tests/fuzz/README.md).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

tools/install_packages.sh python3 python3-numpy python3-scipy python3-matplotlib chromium libclang-rt-dev clang-format
# For `sheaf farm`, on a cluster of this machine alone; without them its test is left out.
tools/slurm.sh install
for preset in asan fuzz release; do
  echo "test: configuring $preset"
  cmake --preset "$preset" >/dev/null
  echo "test: building $preset"
  cmake --build --preset "$preset"
  echo "test: running $preset"
  ctest --preset "$preset" --parallel "$(nproc)"
done
