#!/usr/bin/env bash
# From a clean checkout on Debian 12 or 13 to the results of all tests. Can be run again.
# The tests run twice: with sanitizers (all but the slow ones), then optimised; ctest's summary comes last.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

tools/install_packages.sh
for preset in asan release; do
  echo "test: configuring $preset"
  cmake --preset "$preset" >/dev/null
  echo "test: building $preset"
  cmake --build --preset "$preset"
  echo "test: running $preset"
  ctest --preset "$preset" --parallel "$(nproc)"
done
