#!/usr/bin/env bash
# Set-up, build and a run of the study (docs/results/culling-study.md and ray-tracing-study.md), in one command.
#   scripts/study.sh [arguments of sightline-study]      default: --tables --scale 0.05 --frames 30, a quick look
# Below build/study: the library as built for the study, prefix/ where it is installed with its private headers, and the
# study itself in program/. STUDY_CMAKE_ARGS holds extra CMake arguments for it, such as -DSTUDY_OSG=OFF.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/setup.sh study install
# shellcheck disable=SC2086
cmake -S study -B build/study/program -G Ninja -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_PREFIX_PATH="$PWD/build/study/prefix" -DSTUDY_TESTS=OFF ${STUDY_CMAKE_ARGS:-} >/dev/null
cmake --build build/study/program -j "$(nproc)"
[ $# -gt 0 ] || set -- --tables --scale 0.05 --frames 30
exec build/study/program/bin/sightline-study "$@"
