#!/usr/bin/env bash
# Set-up, build and tests, in one command.
#   scripts/test.sh [PRESET] [ctest arguments …]     release (default), debug, asan or tsan
# SIGHTLINE_TARGETS names what to build (default: everything); select among its tests with ctest's -R.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}
[ $# -gt 0 ] && shift
# shellcheck disable=SC2086
scripts/setup.sh "$preset" ${SIGHTLINE_TARGETS:-}
# Mesa keeps some memory until the process ends, and its threads disturb LeakSanitizer's scan of thread-local storage.
export LSAN_OPTIONS="use_tls=0:suppressions=$PWD/tests/support/lsan.supp${LSAN_OPTIONS:+:$LSAN_OPTIONS}"
export TSAN_OPTIONS="suppressions=$PWD/tests/support/tsan.supp${TSAN_OPTIONS:+:$TSAN_OPTIONS}"
ctest --preset "$preset" -j "$(nproc)" --no-tests=error "$@"
