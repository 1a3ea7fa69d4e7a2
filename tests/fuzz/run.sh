#!/usr/bin/env bash
# Feeds one fuzz target: tests/fuzz/run.sh BUILD TARGET [OPTION OF LIBFUZZER...]
#
#   tests/fuzz/run.sh build/fuzz ply -max_total_time=600
#
# What is found goes to BUILD/found/; such a file given as an option is tried alone. With SHEAF_FUZZ_CORPUS=FOLDER the
# inputs that were found to reach something new are kept in FOLDER/TARGET, and are there for the next time.
set -euo pipefail
build=$(realpath "$1") target=$2
shift 2
root=$(realpath "$(dirname "${BASH_SOURCE[0]}")/../..")

# Each input becomes a file: in memory where that is possible.
memory=/dev/shm
[[ -w $memory ]] || memory=/tmp
TMPDIR=$(mktemp -d -p "${TMPDIR:-$memory}" sheaf_fuzz_XXXXXX)
export TMPDIR
trap 'rm -rf "$TMPDIR"' EXIT

"$build/sheaf_fuzz_seeds" "$TMPDIR/seeds"
corpus=${SHEAF_FUZZ_CORPUS:-$TMPDIR/corpus}/$target
mkdir -p "$corpus" "$build/found"
# Without -entropic=0 scenes take twice as long: there is much to be reached, and all of it is weighed each time.
options=(-rss_limit_mb=2048 -timeout=30 -entropic=0 -print_final_stats=1 "-artifact_prefix=$build/found/$target-")
[[ ! -s $TMPDIR/seeds/$target.dict ]] || options+=("-dict=$TMPDIR/seeds/$target.dict")
for argument in "$@"; do [[ ! -f $argument ]] || alone=1; done
[[ -n ${alone:-} ]] || options+=("$corpus" "$TMPDIR/seeds/$target")
# Short memories of where memory came from and went: half the time of each input.
export ASAN_OPTIONS=quarantine_size_mb=16:malloc_context_size=6 LSAN_OPTIONS="suppressions=$root/cmake/lsan.supp:print_suppressions=0"
"$build/fuzz_$target" "${options[@]}" "$@"
