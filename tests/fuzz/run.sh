#!/usr/bin/env bash
# Runs one fuzz target: tests/fuzz/run.sh BUILD TARGET [LIBFUZZER OPTION...]
#
#   tests/fuzz/run.sh build/fuzz ply -max_total_time=600
#
# Failing inputs are written to BUILD/found/. A file given as an option is the only input. With
# SHEAF_FUZZ_CORPUS=FOLDER, inputs that reach new code are kept in FOLDER/TARGET for later runs.
set -euo pipefail
build=$(realpath "$1") target=$2
shift 2

# Each input becomes a file, in memory if possible.
memory=/dev/shm
[[ -w $memory ]] || memory=/tmp
TMPDIR=$(mktemp -d -p "${TMPDIR:-$memory}" sheaf_fuzz_XXXXXX)
export TMPDIR
trap 'rm -rf "$TMPDIR"' EXIT

"$build/sheaf_fuzz_seeds" "$TMPDIR/seeds"
corpus=${SHEAF_FUZZ_CORPUS:-$TMPDIR/corpus}/$target
mkdir -p "$corpus" "$build/found"
# Without -entropic=0, scenes take twice as long, because their many features are weighted each time.
options=(-rss_limit_mb=2048 -timeout=30 -entropic=0 -print_final_stats=1 "-artifact_prefix=$build/found/$target-")
[[ ! -s $TMPDIR/seeds/$target.dict ]] || options+=("-dict=$TMPDIR/seeds/$target.dict")
for argument in "$@"; do [[ ! -f $argument ]] || alone=1; done
[[ -n ${alone:-} ]] || options+=("$corpus" "$TMPDIR/seeds/$target")
# A small quarantine and short allocation stacks halve the time of each input.
export ASAN_OPTIONS=quarantine_size_mb=16:malloc_context_size=6
"$build/fuzz_$target" "${options[@]}" "$@"
