#!/usr/bin/env bash
# Set-up, build and tests, in one command.
#   scripts/test.sh [--isa SET] [PRESET] [ctest arguments …]     release (default), debug, asan or tsan
# --isa scalar, avx2 or avx512 names the widest instruction set that the kernels use; the processor must have it.
# SIGHTLINE_TARGETS names what to build (default: everything); select among its tests with ctest's -R. Random input is
# tried a tenth as often as in scripts/nightly.sh, which also runs what is left out here; SIGHTLINE_LONG=1 changes that.
set -euo pipefail
cd "$(dirname "$0")/.."
if [ "${1:-}" = --isa ]; then
  [[ ${2:-} =~ ^(scalar|avx2|avx512)$ ]] || { echo "test: --isa scalar, avx2 or avx512, not '${2:-}'" >&2; exit 2; }
  export SIGHTLINE_ISA=$2
  shift 2
fi
preset=${1:-release}
[ $# -gt 0 ] && shift
# shellcheck disable=SC2086
scripts/setup.sh "$preset" ${SIGHTLINE_TARGETS:-}
# Mesa keeps some memory until the process ends, and its threads disturb LeakSanitizer's scan of thread-local storage.
export LSAN_OPTIONS="use_tls=0:suppressions=$PWD/tests/support/lsan.supp${LSAN_OPTIONS:+:$LSAN_OPTIONS}"
export TSAN_OPTIONS="suppressions=$PWD/tests/support/tsan.supp${TSAN_OPTIONS:+:$TSAN_OPTIONS}"
ctest --preset "$preset" -j "$(nproc)" --no-tests=error "$@"
