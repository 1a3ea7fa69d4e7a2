#!/usr/bin/env bash
# Checks that clang-format of Debian 12 (version 14) would leave every C++ file unchanged. Lists the lines that it would
# change, and fails if there are any. Other versions format differently, so the check is skipped.
#
#   tools/check_format.sh [--fix]     --fix: format the files instead
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

version=14
program=$(command -v "clang-format-$version" || command -v clang-format || true)
if [[ -z $program ]] || ! "$program" --version | grep -q "version $version\."; then
  echo "skipped: no clang-format $version (Debian 12: apt-get install clang-format)"
  exit 0
fi
mode=(--dry-run -Werror)
[[ ${1:-} != --fix ]] || mode=(-i)
find bench cmake core kernels scene scenes/make tests tools \( -name '*.h' -o -name '*.cpp' \) -print0 | xargs -0 "$program" "${mode[@]}"
