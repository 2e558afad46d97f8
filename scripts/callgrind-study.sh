#!/usr/bin/env bash
# Counts instructions per frame of culling alone, per method of the study and model. Counts are repeatable, times are
# not.
#   scripts/callgrind-study.sh [BENCH arguments …]     default: --only P-38 aircraft
# Environment variables: BENCH (build/study/program/bin/sightline-study, as scripts/study.sh builds it where
# valgrind/callgrind.h is found), FRAMES (12), VARIANTS (names, comma-separated; empty: all). Valgrind does not support
# AVX-512: production runs with AVX2 there. Only the caller's thread is counted, so variants with threads are left out.
set -euo pipefail
cd "$(dirname "$0")/.."
bench=${BENCH:-build/study/program/bin/sightline-study}
frames=${FRAMES:-12}
default="no tree corners,no tree radar-two-answers,no tree vertices,no tree split simd-per-test,no tree vertices simd-over-boxes"
# Only the compact walk is run with flags.
for tree in mean median; do
  for walk in stack stackless compact; do default+=",$tree $walk vertices whole-leaves"; done
  for flags in +masking "+coherency +octant"; do default+=",$tree compact vertices $flags whole-leaves"; done
  for rest in vertices "vertices +masking" "split simd-per-test" "split simd-per-test +masking"; do default+=",$tree compact $rest"; done
done
for rest in vertices "vertices +masking" "split simd-per-test +masking" "vertices +masking whole-leaves depth<=12"; do
  default+=",SAH compact $rest"
done
default+=",production,production ids,production scalar,OpenSceneGraph,Open CASCADE,VTK"
variants=${VARIANTS-$default}
arguments=("$@")
[ ${#arguments[@]} -gt 0 ] || arguments=(--only P-38 aircraft)
command -v valgrind >/dev/null || { echo "callgrind-study: needs valgrind" >&2; exit 1; }

dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
valgrind -q --tool=callgrind --instr-atstart=no --collect-atstart=no --callgrind-out-file="$dir/out" \
  "$bench" --tour-only --frames "$frames" --passes 1 --samples 1 --tables ${variants:+--variants "$variants"} \
  "${arguments[@]}" >"$dir/tables" 2>"$dir/log" || { cat "$dir/log" >&2; exit 1; }

# Dumps are numbered in the order of the runs. The models come in the same order, and each ends with brute force.
printf '%-60s %16s\n' method 'instructions/frame'
find "$dir" -name 'out.*' | sort -V | while read -r dump; do
  name=$(sed -n 's/^desc: Trigger: Client Request: //p' "$dump")
  total=$(awk '/^(totals|summary):/ { print $2; exit }' "$dump")
  [ -n "$name" ] || continue
  printf '%-60s %16d\n' "$name" $((total / frames))
  case $name in brute*) echo ;; esac
done
