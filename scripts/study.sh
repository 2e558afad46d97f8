#!/usr/bin/env bash
# Set-up, build and a run of the study (docs/results/culling-study.md and ray-tracing-study.md), in one command.
#   scripts/study.sh [arguments of sightline-study]      default: cull --scale 0.05 --frames 30, a quick look
# Built in build/study. SIGHTLINE_CMAKE_ARGS holds extra CMake arguments, such as -DSTUDY_GPU=OFF.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/setup.sh study sightline-study
[ $# -gt 0 ] || set -- cull --scale 0.05 --frames 30
exec build/study/bin/sightline-study "$@"
