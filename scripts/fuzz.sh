#!/usr/bin/env bash
# Feeds made-up bytes to everything that reads files, under AddressSanitizer and UndefinedBehaviorSanitizer: set-up, build
# and runs of all fuzz targets, as many at a time as there are processors. Needs Debian's clang, installed when missing.
#   scripts/fuzz.sh [SECONDS] [TARGET …]     seconds each (default 20); targets such as rvm (default: all)
# Prints a line for each target. Inputs that failed stay in build/fuzz/crashes/TARGET/ (run them again with
# build/fuzz/bin/fuzz_TARGET FILE), the corpus grows in build/fuzz/corpus/TARGET/. Exits 1 when any target failed.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=20
if [[ ${1:-} =~ ^[0-9]+$ ]]; then
  seconds=$1
  shift
elif [[ ${1:-} == -* ]]; then
  sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "$0"
  exit 0
fi

scripts/setup.sh fuzz
build=build/fuzz
if [ $# -gt 0 ]; then
  targets=("$@")
else
  targets=()
  for program in "$build"/bin/fuzz_*; do targets+=("${program##*/fuzz_}"); done
fi
for target in "${targets[@]}"; do
  [ -x "$build/bin/fuzz_$target" ] || { echo "fuzz: no target '$target' in this build" >&2; exit 2; }
done

# Longest input worth mutating: binary formats need room for a few chunks, text that is understood is short.
longest() {
  case $1 in
    *json | controller_trace) echo 1024 ;;
    *) echo 8192 ;;
  esac
}

run() {
  local target=$1 log=$build/logs/$1.log status=passed options=()
  mkdir -p "$build/corpus/$target" "$build/crashes/$target" "$build/logs"
  [ -f "tests/fuzz/$target.dict" ] && options+=("-dict=tests/fuzz/$target.dict")
  [ -n "${CI:-}" ] && options+=(-seed=1) # the same inputs in every run; elsewhere new ones
  UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 "$build/bin/fuzz_$target" "-max_total_time=$seconds" -timeout=10 \
    -rss_limit_mb=3000 -malloc_limit_mb=1100 "-max_len=$(longest "$target")" -print_final_stats=1 "${options[@]}" \
    "-artifact_prefix=$build/crashes/$target/" "$build/corpus/$target" "tests/fuzz/corpus/$target" >"$log" 2>&1 ||
    status=FAILED
  figure() { sed -n "s/^stat::$1: *//p" "$log" | tail -1; }
  local coverage size
  coverage=$(sed -n 's/.* cov: \([0-9]*\) .*/\1/p' "$log" | tail -1)
  size=$(sed -n 's/.* corp: \([0-9]*\)\/.*/\1/p' "$log" | tail -1)
  printf '%-18s %12s %8s %8s %7s %7s  %s\n' "$target" "$(figure number_of_executed_units)" \
    "$(figure average_exec_per_sec)" "${coverage:--}" "${size:--}" "$(figure peak_rss_mb)" "$status"
  if [ "$status" = FAILED ]; then
    grep -hE '^expected|ERROR|runtime error|Test unit written' "$log" | cut -c1-200 >&2 || true
    return 1
  fi
}
export build seconds
export -f longest run
printf '%-18s %12s %8s %8s %7s %7s  %s\n' target executions per_s edges corpus rss_MB result
printf '%s\n' "${targets[@]}" | xargs -P "$(nproc)" -I{} bash -c 'run {}' || exit 1
