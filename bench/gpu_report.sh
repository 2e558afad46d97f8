#!/usr/bin/env bash
# Answers every question that needs a real GPU, in one command: builds, measures, and writes one Markdown report.
#   bench/gpu_report.sh [REPORT.md]      default: out/gpu_report/report.md; its folder also gets JSON, CSV and plots
# Environment variables: SCALE (1: 713,000 and 5 million items), FRAMES (200), PASSES (5), SIZE (1280x720), BIN (a
# folder of built programs: nothing is built then), MODELS and VIEWS (real models and a folder of views of them).
# SCALE=0.01 FRAMES=40 PASSES=2 SIZE=320x180 takes some ten minutes on a software rasteriser.
set -euo pipefail
cd "$(dirname "$0")/.."
report=${1:-out/gpu_report/report.md}
scale=${SCALE:-1} frames=${FRAMES:-200} passes=${PASSES:-5} size=${SIZE:-1280x720}
out=$(dirname "$report")
mkdir -p "$out"
if [ -z "${BIN:-}" ]; then scripts/setup.sh release; fi
bin=${BIN:-build/release/bin}
times() { awk -v a="$1" -v b="$2" 'BEGIN { printf "%.6g", a * b }'; }
whole() { awk -v a="$1" -v b="$2" 'BEGIN { n = int(a * b); print n < 1000 ? 1000 : n }'; }

section() { printf '\n## %s\n\n' "$1" >>"$report"; echo "gpu_report: $1" >&2; }
# shellcheck disable=SC2016  # the backquotes are Markdown's
# Runs a program and puts its command line and output into the report. A failure is reported, and the script goes on.
show() {
  printf '`%s`\n\n```\n' "$(basename "$1") ${*:2}" >>"$report"
  "$@" >>"$report" 2>&1 || echo "FAILED, exit $?" >>"$report"
  printf '```\n' >>"$report"
}

cat >"$report" <<HEAD
# GPU report

- date: $(date -u +%F), Sightline $(git describe --always --dirty 2>/dev/null || echo unknown)
- processor: $(sed -n 's/^model name[^:]*: *//p' /proc/cpuinfo | head -1), $(nproc) cores; load at the start $(cut -d' ' -f1 /proc/loadavg)
- graphics: $(nvidia-smi --query-gpu=name,driver_version --format=csv,noheader 2>/dev/null || echo "no nvidia-smi; the renderer is named below")
- system: $(sed -n 's/^PRETTY_NAME="\(.*\)"/\1/p' /etc/os-release), kernel $(uname -r)
- scale $scale, $frames frames, $passes passes, $size

Times of different sections were measured at different times: compare within a table.
HEAD

hybrid=("$bin/sightline-bench" hybrid --frames "$frames" --size "$size")
section "Table 6.1: platforms and aircraft, rendering off and on"
show "${hybrid[@]}" --scale "$scale" --passes "$passes" --csv "$out/figures" --json "$out/table_6_1.json"

section "The aircraft's path: total frame against the better single path, longer"
show "${hybrid[@]}" --scale "$scale" --only aircraft --rendering on --passes $((2 * passes + 1)) --json "$out/aircraft.json"

section "Five million items"
show "${hybrid[@]}" --scale "$(times "$scale" 7.0143)" --passes "$passes" --only aircraft --json "$out/aircraft_5m.json"
show "${hybrid[@]}" --scale "$(times "$scale" 7.2259)" --passes "$passes" --only P-50 --json "$out/plant_5m.json"

section "What frames culled by the GPU cost the CPU, by the number of items"
counts=""
for n in 100000 713000 5000000; do counts+="${counts:+,}$(whole "$scale" "$n")"; done
for form in geometry compute; do
  show "$bin/sightline-bench" hybrid --submission "$counts" --gpu-pass "$form" --frames "$frames" --size "$size" \
    --json "$out/submission_$form.json"
done

section "GPU cull time by pass form, rendering off and on"
for n in 713000 5000000; do
  items=$(whole "$scale" "$n")
  plant="$out/plant_$items.rvm"
  [ -e "$plant" ] || "$bin/sightline-generate" --items "$items" "$plant" >/dev/null
  for form in geometry compute; do
    for rendering in --no-render ""; do
      # shellcheck disable=SC2086
      show "$bin/sightline-replay" "$plant" --culler gpu --frames "$frames" --size "$size" $rendering --gpu-pass "$form"
    done
  done
done

section "Recorded traces: what either path costs in every frame, and both policies on them"
traces=("$out"/figures/*_trace.csv)
for n in 713000 5000000; do
  items=$(whole "$scale" "$n")
  trace="$out/plant_${items}_trace.csv"
  "$bin/sightline-replay" "$out/plant_$items.rvm" --record-both "$trace" --frames "$frames" --size "$size" >>"$report" 2>&1
  traces+=("$trace")
done
show "$bin/sightline-bench" controller "${traces[@]}" --seeds 1 --plot "$out/regret.svg"

section "Error against time: triangles and ray-cast primitives, kind by kind and in models (MODELS names files, VIEWS a folder of views)"
show "$bin/sightline-bench" error-time --json "$out/error_time.json" --plot "$out/error_time"
read -ra models <<<"${MODELS:-}"
if [ ${#models[@]} -gt 0 ]; then
  show "$bin/sightline-bench" error-time "${models[@]}" ${VIEWS:+--views "$VIEWS"} --size "$size" --json "$out/error_time_models.json" \
    --plot "$out/error_time_models"
fi

echo "Written: $report" >&2
