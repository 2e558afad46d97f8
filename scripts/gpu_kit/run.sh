#!/usr/bin/env bash
# Tells how Sightline works on this machine's GPU, in at most eight minutes: writes OUT/report.md and little beside it.
#   ./run.sh [OUT]      default: gpu-report
# The folder needs nothing but x86-64 Linux with glibc 2.36 and a graphics driver. Environment variables:
#   SCALE (1)           share of the items that are timed: 100,000, 1 million and 5 million
#   FRAMES (60)         frames of a flight
#   SIZE (1280x720)     pixels of timed frames; images that are compared have their own size
#   TOTAL (470)         seconds, after which no step begins
#   STEPS (all)         names of steps, such as "machine images"; --list tells them
#   SIGHTLINE_CONTEXT   where OpenGL comes from: egl, egl-device, egl-surfaceless or osmesa; without it the first way that
#                       gives hardware
# A step that fails or takes too long is reported, and the next one begins. An interrupted run leaves what it has found.
set -uo pipefail
PATH=$PATH:/usr/sbin:/sbin  # ldconfig's
kit=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
bin=$kit/bin
scale=${SCALE:-1} frames=${FRAMES:-60} size=${SIZE:-1280x720} total=${TOTAL:-470}
steps=(machine tests images stability hybrid_100k hybrid_1m submission occlusion samples hybrid_5m prepare passes motion first_image trace table_6_1 edits)

case ${1:-} in
  -h | --help) sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "$0"; exit 0 ;;
  --list) echo "${steps[*]}"; exit 0 ;;
  -*) echo "run.sh: no option $1; see --help" >&2; exit 2 ;;
esac
mkdir -p "${1:-gpu-report}" || exit 2
out=$(cd "${1:-gpu-report}" && pwd)
report=$out/report.md
hardware=""
scratch=$(mktemp -d "${TMPDIR:-/tmp}/sightline-kit.XXXXXX") || exit 2
trap 'rm -rf "$scratch"' EXIT
trap 'exit 130' INT TERM

# Drivers and programs keep shaders of this run alone, so that a first start is one. The tests find their data here.
export XDG_CACHE_HOME=$scratch/cache __GL_SHADER_DISK_CACHE_PATH=$scratch/cache
export SIGHTLINE_CHECKOUT=$kit/checkout SIGHTLINE_BIN=$bin SIGHTLINE_DRAWN_VIEWS=100
mkdir -p "$XDG_CACHE_HOME"

say() { printf '%s\n' "$*" >>"$report"; }
left() { echo $((total - SECONDS)); }
product() { awk -v a="$1" -v b="$2" 'BEGIN { printf "%.6g", a * b }'; }
items() { awk -v a="$scale" -v b="$1" 'BEGIN { n = int(a * b); print n < 1000 ? 1000 : n }'; }

# limited SECONDS COMMAND…: runs it for so long at most, and not beyond the end of the whole run.
limited() {
  local seconds=$1 rest
  shift
  rest=$(left)
  if [ "$rest" -lt 2 ]; then return 124; fi
  if [ "$rest" -lt "$seconds" ]; then seconds=$rest; fi
  timeout -k 2 "$seconds" "$@"
}

outcome() {
  case $1 in
    0) echo "done" ;;
    124 | 137) echo "ended after its time" ;;
    *) echo "FAILED, exit code $1" ;;
  esac
}

# show SECONDS TOOL ARGUMENTS…: runs a tool; its command line, output and times get into the report. Lines that fit the
# variable `unsaid` do not.
show() {
  local seconds=$1 log=$scratch/log code
  shift
  TIMEFORMAT='%R s, processor time %U s and %S s in the kernel'
  { time limited "$seconds" "$bin/$1" "${@:2}" >"$log" 2>&1; } 2>"$scratch/time"
  code=$?
  # shellcheck disable=SC2016  # the backquotes are Markdown's
  {
    printf '`%s`: %s, %s\n\n```\n' "${*//$scratch\//}" "$(outcome $code)" "$(tail -n 1 "$scratch/time")"
    tr '\r' '\n' <"$log" | grep -v "${unsaid:-^$}" | head -c 12000 | cut -c1-400
    printf '```\n\n'
  } >>"$report"
  return $code
}

plant() { # items: path of a generated plant, made when it is first asked for
  local file=$scratch/plant_$1.slc
  [ -e "$file" ] || limited 15 "$bin/sightline-generate" --items "$1" "$file" >/dev/null || rm -f "$file"
  echo "$file"
}

# --- the machine -----------------------------------------------------------------------------------------------------

# NVIDIA's EGL is found through a file that some containers lack.
name_nvidia_to_glvnd() {
  local folder=$scratch/egl_vendor.d
  ldconfig -p 2>/dev/null | grep -q libEGL_nvidia.so.0 || return 0
  cat /usr/share/glvnd/egl_vendor.d/*.json /etc/glvnd/egl_vendor.d/*.json 2>/dev/null | grep -q libEGL_nvidia && return 0
  mkdir -p "$folder"
  echo '{"file_format_version": "1.0.0", "ICD": {"library_path": "libEGL_nvidia.so.0"}}' >"$folder/10_nvidia.json"
  export __EGL_VENDOR_LIBRARY_DIRS=$folder:/etc/glvnd/egl_vendor.d:/usr/share/glvnd/egl_vendor.d
  say "- NVIDIA's EGL is not registered with libglvnd; this run does it by itself"
}

describe_machine() {
  say "- processor: $(sed -n 's/^model name[^:]*: *//p' /proc/cpuinfo | head -n 1), $(nproc) threads, load $(cut -d' ' -f1 /proc/loadavg)"
  say "- memory: $(awk '/^MemTotal/ { printf "%.1f GB", $2 / 1e6 }' /proc/meminfo)"
  say "- system: $(sed -n 's/^PRETTY_NAME="\(.*\)"/\1/p' /etc/os-release), kernel $(uname -r), $(ldd --version 2>/dev/null | head -n 1)"
  say "- NVIDIA: $(timeout 5 nvidia-smi --query-gpu=name,driver_version,memory.total --format=csv,noheader 2>/dev/null | paste -sd';' || true)"
  say "- devices: $(find /dev -maxdepth 2 \( -path '/dev/dri/*' -o -name 'nvidia*' \) 2>/dev/null | sort | paste -sd' ')"
  say "- libraries: $(ldconfig -p 2>/dev/null | awk '/libEGL|libOpenGL\.|libGLX_|libOSMesa/ { print $1 }' | sort -u | paste -sd' ')"
}

# Tries every way to a context, and leaves the first that gives hardware in SIGHTLINE_CONTEXT.
choose_context() {
  local way log asked=${SIGHTLINE_CONTEXT:-} chosen="" fallback=""
  unset SIGHTLINE_CONTEXT
  say "" && say "| context | what it gives |" && say "| --- | --- |"
  for way in egl-device egl egl-surfaceless osmesa; do
    log=$scratch/context_$way
    if limited 6 "$bin/sightline-info" --gl --context-platform "$way" >"$log" 2>&1; then
      say "| $way | $(sed -n 's/^\(platform\|renderer\|version\|made in\)  *//p' "$log" | paste -sd';' | sed 's/;/; /g') |"
      if grep -q '^  software  *false' "$log"; then chosen=${chosen:-$way}; fi
      fallback=${fallback:-$way}
    else
      say "| $way | none: $(tail -n 1 "$log" | cut -c1-300 | tr '|' '/') |"
    fi
  done
  way=${asked:-${chosen:-$fallback}}
  [ -n "$way" ] || return 1
  export SIGHTLINE_CONTEXT=$way
  hardware=$chosen
  if [ -z "$hardware" ]; then say "" && say "**No context of hardware was found: what follows is a software rasteriser's.**"; fi
  say "" && say "What follows uses \`$way\`:" && say "" && sed 's/^/- /' "$scratch/context_$way" | cut -c1-9000 >>"$report"
}

step_machine() {
  describe_machine
  name_nvidia_to_glvnd
  choose_context
}

# --- correctness -----------------------------------------------------------------------------------------------------

# From GoogleTest's output: a line for each test that failed, with the first lines of its message.
failed_tests() {
  awk '/^\[ RUN/ { name = $4; lines = 0; text = ""; next }
       /^\[  FAILED  \]/ && name != "" { print "- " name ": " text; name = ""; next }
       /^\[ / { name = ""; next }
       name != "" && lines < 6 && NF { text = text (lines++ ? " / " : "") substr($0, 1, 200) }
       END { if (name != "") print "- " name ": did not end" (text == "" ? "" : ": " text) }' "$1"
}

# run_tests NAME SECONDS FILTER: goes on behind a test that ends the program.
run_tests() {
  local name=$1 seconds=$2 filter=$3 log=$scratch/$1.log all=$scratch/$1.all code=0 round done_tests begin=$SECONDS
  : >"$all"
  for round in {1..8}; do
    limited $((seconds - SECONDS + begin > 0 ? seconds - SECONDS + begin : 1)) "$bin/tests" --gtest_color=no --gtest_filter="$filter" >"$log" 2>&1
    code=$?
    cat "$log" >>"$all"
    failed_tests "$log" >>"$scratch/failed"
    awk '/^\[ RUN/ { text = "" } { text = text $0 "\n" } /^\[  FAILED  \] .*ms\)$/ { printf "%s\n", text }' "$log" |
      cut -c1-2000 | head -c 1000000 >>"$out/failed_tests.log"
    # Exit code 1 is that of a program whose tests failed; 124 and 137 are those of the time that is over.
    case $code in 0 | 1 | 124 | 137) break ;; esac
    done_tests=$(sed -n 's/^\[ RUN      \] //p' "$log" | paste -sd:)
    [ -n "$done_tests" ] || break
    case $filter in *-*) filter+=":$done_tests" ;; *) filter+="-$done_tests" ;; esac
  done
  count() { grep -c "^\[ *$1 *\] .*ms)$" "$all"; }
  say "| $name | $(count OK) | $(count FAILED) | $(count SKIPPED) | $((SECONDS - begin)) s | $(outcome $code)$([ "$round" = 1 ] || echo ", started $round times") |"
}

step_tests() {
  local name seconds filter
  : >"$scratch/failed"
  say "| tests of | passed | failed | skipped | time | |" && say "| --- | --- | --- | --- | --- | --- |"
  while read -r name seconds filter; do
    run_tests "$name" "$seconds" "$filter"
  done <"$bin/tests.txt"
  if [ -n "$hardware" ]; then run_tests rest 110 "-$(sed -n 's/^\[ RUN      \] //p' "$scratch"/*.all | paste -sd:)"; fi
  say ""
  if [ -s "$scratch/failed" ]; then
    head -c 40000 "$scratch/failed" >>"$report"
    say "" && say "All that they say is in failed_tests.log."
  else
    say "No test failed."
  fi
}

# field TEXT: the number behind it in the log of an image.
field() { sed -n "s/.*$1 \([^ ,;]*\).*/\1/p" "$scratch/image.log" | head -n 1; }

# compare_image NAME MODEL OPTION…: the options of a view, and behind them those of a culler.
compare_image() {
  local name=$1 model=$2 ref=$kit/refs/$1 code verdict culler
  shift 2
  culler="$*" && culler=${culler##*--culler } && culler=${culler/ --gpu-variant/,}
  cd "$kit" || return 1
  limited 8 "$bin/sightline-render" "$model" "$@" --compare "$ref.png" --max 255 --mean 255 \
    --compare-ids "$ref.ids.png" --compare-depth "$ref.pfm" --out "$scratch/$name.png" --diff "$scratch/$name.diff.png" >"$scratch/image.log" 2>&1
  code=$?
  if [ $code -ne 0 ]; then
    say "| $name | $culler | | | | | | | | $(outcome $code): $(tail -n 1 "$scratch/image.log" | cut -c1-200 | tr '|' '/') |"
    wrong_images=$((wrong_images + 1))
    return
  fi
  verdict=ok
  if [ "$(field 'at no silhouette')" != "$(field ties)" ] || [ "$(field 'beyond it')" != 0 ]; then
    verdict=DIFFERS
    wrong_images=$((wrong_images + 1))
    mkdir -p "$out/images"
    cp "$scratch/$name.png" "$out/images/$name.drawn.png"
    cp "$ref.png" "$out/images/$name.reference.png"
    cp "$scratch/$name.diff.png" "$out/images/"
  fi
  say "| $name | $culler | $(field 'of another item') | $(field 'at no silhouette') | $(field ties) | $(field 'largest difference') in $(field 'depth:') pixels | $(field ' m,') | $(field 'beyond it') | $(field max), $(field 'max [0-9]*  mean') | $verdict |"
}

step_images() {
  local name model options
  wrong_images=0
  say "| image | culler | pixels of another item | at no silhouette | of them ties | depth: largest difference, m | its share of the bound | beyond it | colour: max, mean | |"
  say "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |"
  while read -r name model options; do
    if [ "$(left)" -lt 3 ] || [ $((SECONDS - step_began)) -gt 50 ]; then say "| $name | no time left |" && continue; fi
    # shellcheck disable=SC2086
    compare_image "$name" "$model" $options
  done <"$kit/refs/images.txt"
  say "" && say "$wrong_images images differ from llvmpipe's otherwise than at silhouettes and in ties, or beyond the bounds of depth."
}

step_stability() {
  local rays=200
  if [ "$(items 1000000)" -lt 500000 ]; then rays=5; fi
  unsaid=' ok  *|$' show 20 sightline-stability --path glsl --rays $rays
}

# --- times -----------------------------------------------------------------------------------------------------------

# fly ITEMS SECONDS: all cullers in turns on a plant of platform P-50's parts, with both variants of the GPU culler.
fly() {
  local share variant
  share=$(awk -v n="$(items "$1")" 'BEGIN { s = n / 691951; printf "%.5f", s < 0.001 ? 0.001 : s }')
  for variant in geometry compute; do
    show "$2" sightline-bench hybrid --only P-50 --scale "$share" --gpu-variant "$variant" --frames "$frames" --passes 1 \
      --size "$size"
  done
}

step_hybrid_100k() { fly 100000 12; }
step_hybrid_1m() { fly 1000000 18; }
# One culler after the other, from a scene cache: to build eight engines of so many items would take too long.
step_hybrid_5m() {
  local file rendering culler
  file=$(plant "$(items 5000000)")
  for rendering in --no-render ""; do
    for culler in cpu "gpu --gpu-variant geometry" "gpu --gpu-variant compute" hybrid; do
      # shellcheck disable=SC2086
      show 7 sightline-replay "$file" --culler $culler $rendering --frames $((frames / 2 + 2)) --size "$size"
    done
  done
  rm -f "$file"
}
# Images of a moving camera within a budget, beside complete ones.
step_motion() {
  local count
  for count in 1000000 5000000; do
    show 30 sightline-bench motion --items "$(items $count)" --budget 33 --frames "$frames" --every 20 --ways drawn \
      --size "$size"
  done
}
# Work of the processor before GL draws, by threads.
step_prepare() {
  local count
  for count in 1000000 5000000; do
    show 30 sightline-bench prepare --items "$(items $count)" --threads "$(nproc)" --passes 5 --frames 8
  done
}
# Time on the GPU's clock by pass and kind, and what a depth prepass of the application's would leave.
step_passes() {
  local samples
  for samples in 1 4; do
    show 10 sightline-bench passes --items "$(items 100000)" --samples $samples --frames $((frames / 4 + 1)) --size "$size"
  done
}
step_submission() {
  local variant
  for variant in geometry compute; do
    show 10 sightline-bench hybrid --submission "$(items 100000),$(items 1000000)" --gpu-variant "$variant" --frames "$frames" --size "$size"
  done
}
step_occlusion() {
  local count culler choice file
  for count in 100000 1000000; do
    file=$(plant "$(items $count)")
    for culler in cpu gpu; do
      for choice in off on auto; do
        show 7 sightline-replay "$file" --culler "$culler" --occlusion "$choice" --frames "$frames" --size "$size"
      done
    done
  done
}
step_samples() {
  local file looks
  file=$(plant "$(items 100000)")
  for looks in "--samples 1" "--samples 4" "--samples 8" "--samples 4 --depth-shading 0.5 --edge-lines 0.5"; do
    # shellcheck disable=SC2086
    show 7 sightline-replay "$file" $looks --frames "$frames" --size "$size"
  done
}
step_first_image() {
  local file cache
  file=$(plant "$(items 100000)")
  for cache in empty filled; do
    say "With the cache of shaders $cache:" && say ""
    XDG_CACHE_HOME=$scratch/first __GL_SHADER_DISK_CACHE_PATH=$scratch/first show 5 sightline-bench start "$file" --size "$size"
  done
}
step_trace() {
  local file
  file=$(plant "$(items 1000000)")
  show 14 sightline-replay "$file" --record-both "$out/trace.csv" --frames "$frames" --size "$size"
  say "What either path costs in every frame: trace.csv. The controller on it:" && say ""
  if [ -s "$out/trace.csv" ]; then show 4 sightline-replay --controller-only "$out/trace.csv"; fi
}
step_table_6_1() { show 30 sightline-bench hybrid --scale "$(product "$scale" 0.15)" --frames "$frames" --passes 1 --size "$size"; }
step_edits() { show 18 sightline-bench edit --items "$(items 1000000)" --subject scenes --commits 2; }

# --- the run ---------------------------------------------------------------------------------------------------------

title() {
  case $1 in
    machine) echo "Machine, driver, limits and extensions" ;;
    tests) echo "Tests with a context" ;;
    images) echo "Images against llvmpipe's" ;;
    stability) echo "Stability of the shaders (docs/reference/accuracy.md)" ;;
    hybrid_100k) echo "$(items 100000) items: cullers, rendering off and on" ;;
    hybrid_1m) echo "$(items 1000000) items: cullers, rendering off and on" ;;
    hybrid_5m) echo "$(items 5000000) items: cullers, rendering off and on" ;;
    motion) echo "Moving images within 33 ms, $(items 1000000) and $(items 5000000) items" ;;
    prepare) echo "Preparing a frame by threads, $(items 1000000) and $(items 5000000) items" ;;
    passes) echo "Passes of an image on the GPU's clock, $(items 100000) items" ;;
    submission) echo "What frames culled by the GPU cost the processor" ;;
    occlusion) echo "Occlusion off, on and learnt, $(items 100000) and $(items 1000000) items" ;;
    samples) echo "Samples per pixel, depth shading and lines, $(items 100000) items" ;;
    first_image) echo "First image" ;;
    trace) echo "Both paths in every frame, $(items 1000000) items" ;;
    table_6_1) echo "Table 6.1: platforms and aircraft at $(product "$scale" 0.15) of their items" ;;
    edits) echo "Edits of 1 % of $(items 1000000) items" ;;
  esac
}

keep_it_small() {
  if [ "$(du -sk "$out" | cut -f1)" -gt 15000 ]; then rm -rf "$out/images" && say "" && say "The images were too large to keep."; fi
}

{
  echo "# Sightline on a GPU"
  echo
  echo "- $(cat "$kit/version.txt")"
  echo "- $(date -u +'%F %H:%M') UTC; scale $scale, $frames frames, $size"
} >"$report"
for step in "${steps[@]}"; do
  if [[ -n ${STEPS:-} && " $STEPS machine " != *" $step "* ]]; then continue; fi
  say "" && say "## $(title "$step")" && say ""
  if [ "$(left)" -lt 5 ]; then say "Not begun: the time was over." && continue; fi
  echo "run.sh: $(title "$step") ($SECONDS s)" >&2
  step_began=$SECONDS
  "step_$step" || say "This step did not succeed."
  say "" && say "($((SECONDS - step_began)) s)"
done
keep_it_small
say "" && say "$SECONDS s in all."
echo "run.sh: written: $report ($SECONDS s)" >&2
