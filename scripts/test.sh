#!/usr/bin/env bash
# All set-up, build and tests.
#   scripts/test.sh [PRESET] [ctest arguments …]     release (default), debug, asan or tsan
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}
[ $# -gt 0 ] && shift
if [ -n "${CI:-}" ]; then export SIGHTLINE_CMAKE_ARGS="${SIGHTLINE_CMAKE_ARGS:-} -DSIGHTLINE_WARNINGS_AS_ERRORS=ON"; fi
scripts/setup.sh "$preset"
# Mesa keeps some memory for the life of the process, and its threads upset LeakSanitizer's thread-local scan.
export LSAN_OPTIONS="use_tls=0:suppressions=$PWD/tests/support/lsan.supp${LSAN_OPTIONS:+:$LSAN_OPTIONS}"
export TSAN_OPTIONS="suppressions=$PWD/tests/support/tsan.supp${TSAN_OPTIONS:+:$TSAN_OPTIONS}"
ctest --preset "$preset" -j "$(nproc)" "$@"
