#!/usr/bin/env bash
# Set-up, build and tests, in one command.
#   scripts/test.sh [--isa SET] [--driver NAME] [PRESET] [ctest arguments …]     release (default), debug, asan or tsan
# --isa scalar, neon, avx2 or avx512 names the widest instruction set that the kernels use; the processor must have it.
# --driver zink or llvmpipe runs tests with that OpenGL driver (scripts/with_driver.sh): those with a context of gl,
# gpuscene, culling, render and engine, and builds no more than these, unless SIGHTLINE_TARGETS and -R name others.
# SIGHTLINE_TARGETS names what to build (default: everything); select among its tests with ctest's -R. Random input is
# tried a tenth as often as in scripts/nightly.sh, which also runs what is left out here; SIGHTLINE_LONG=1 changes that.
set -euo pipefail
cd "$(dirname "$0")/.."
with_driver=() only=()
while [[ ${1:-} == --* ]]; do
  case $1 in
    --isa)
      [[ ${2:-} =~ ^(scalar|neon|avx2|avx512)$ ]] || { echo "test: --isa scalar, neon, avx2 or avx512, not '${2:-}'" >&2; exit 2; }
      export SIGHTLINE_ISA=$2
      ;;
    --driver)
      [[ ${2:-} =~ ^(zink|llvmpipe)$ ]] || { echo "test: --driver zink or llvmpipe, not '${2:-}'" >&2; exit 2; }
      with_driver=(scripts/with_driver.sh "$2")
      only=(-R '^(gl|gpuscene|culling|render|engine)_gl\.')
      SIGHTLINE_TARGETS=${SIGHTLINE_TARGETS:-gl_gl_tests gpuscene_gl_tests culling_gl_tests render_gl_tests engine_gl_tests}
      ;;
    *) echo "test: unknown option '$1'" >&2; exit 2 ;;
  esac
  shift 2
done
preset=${1:-release}
[ $# -gt 0 ] && shift
# shellcheck disable=SC2086
scripts/setup.sh "$preset" ${SIGHTLINE_TARGETS:-}
# Mesa keeps some memory until the process ends, and its threads disturb LeakSanitizer's scan of thread-local storage.
export LSAN_OPTIONS="use_tls=0:suppressions=$PWD/tests/support/lsan.supp${LSAN_OPTIONS:+:$LSAN_OPTIONS}"
export TSAN_OPTIONS="suppressions=$PWD/tests/support/tsan.supp${TSAN_OPTIONS:+:$TSAN_OPTIONS}"
"${with_driver[@]}" ctest --preset "$preset" -j "$(nproc)" --no-tests=error "${only[@]}" "$@"
