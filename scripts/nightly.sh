#!/usr/bin/env bash
# What takes too long for scripts/test.sh: the long counts of random input, sanitizers on everything, fuzzing, packages,
# other projects that use the library, the study, builds without optional parts, mutation.
#   scripts/nightly.sh                 all of it: about an hour on two cores
#   scripts/nightly.sh SLICE/COUNT     one of COUNT slices that take about as long as each other, from 1/COUNT on
#   scripts/nightly.sh --only NAME …   these alone
#   scripts/nightly.sh --list [COUNT]  names, minutes, and the slice of COUNT (16) that each is in
# Does all set-up, as scripts/test.sh does. Goes on after a failure and exits 1 in the end, naming what failed. Mutation
# only reports. SIGHTLINE_CMAKE_ARGS holds extra CMake arguments.
set -euo pipefail
cd "$(dirname "$0")/.."

# Name, minutes on two cores with most objects in a compiler cache, and what it is.
units="
counts       8 long counts of random input, hostile files and exact pairs
counts-gl   13 long counts of images: occlusion, clusters, portions, state of applications, joints of real models; calls of GL that fail
isa          4 core, culling, ray tracer and primitives with narrower instruction sets
tools        5 tools that are started many times, mpirun, pip from a built tree and from the sources
osmesa       2 GL tests with OSMesa contexts
fuzz         6 twenty seconds of each fuzz target
tsan         8 ThreadSanitizer on core, culling, ray tracer and engine
asan         5 AddressSanitizer on culling, ray tracer, primitives, measuring and comparing
asan-io      7 AddressSanitizer on core, importers, the C API and the viewer's model: what reads bytes or foreign pointers
asan-cad     4 AddressSanitizer on STEP, IGES and BREP
asan-gl      8 AddressSanitizer on the engine and the GPU culler
zink         5 GL tests of gl, gpuscene, culling and render with a second driver
zink-engine  5 GL tests of engine with it
packages     3 Debian packages: built, judged, installed, used
consumers    6 public headers alone; projects that use the installed library, pkg-config or the sources
shared       3 the same with one shared library
study        6 the study and its tests
without      4 builds without optional parts, and their tests
wasm         8 the npm package in all forms beside the library, in node and Chromium
browser      7 the npm package in pages: primitives, scenes of three.js, plants, a project of its own; 3D Tiles in a viewer
arm64        8 cross-built for 64-bit ARM: core, culling and the C API under an emulator
windows      8 cross-built for Windows: core, culling, the C API and contexts under Wine
mutants      7 mutants of files that changed lately, and of occlusion culling: what survives is reported
"

release() {
  SIGHTLINE_SETUP_PACKAGES=1 scripts/setup.sh release
}
# Runs tests of a build, also those that presets leave out: ctest_in BUILD ARGUMENTS …
ctest_in() { ctest --test-dir "build/$1" -j "$(nproc)" --no-tests=error --output-on-failure "${@:2}"; }

run_counts() {
  release
  SIGHTLINE_LONG=1 ctest_in release -R '^((culling|importers|importers_vtk|shaders|stability|view|gpuprims)\.|hostile_table)' -LE '^nightly'
}
run_counts-gl() {
  release
  SIGHTLINE_LONG=1 ctest_in release -R '^(engine_gl\..*(OcclusionDrawnItems|DrawnTriangles|Portions|ForeignState|Faults|Levels|PagedEngineTest)|render_gl\..*JointImages)'
}
run_isa() {
  release
  for isa in scalar avx2; do
    SIGHTLINE_ISA=$isa ctest_in release -R '^(core|core_checked|culling|raytrace|gpuprims|engine)\.'
  done
}
run_tools() {
  release
  ctest_in release -L '^nightly' -R '^(apps|apps_gl|engine_gl|python|python_gl)\.'
}
# A part of what scripts/arm64.sh and scripts/windows.sh build and run, as much as a slice has time for.
run_arm64() { SIGHTLINE_TARGETS="core_tests culling_tests capi_tests" scripts/arm64.sh test -R '^(core|culling|capi)\.'; }
run_windows() {
  SIGHTLINE_TARGETS="core_tests culling_tests capi_tests gl_gl_tests" scripts/windows.sh test -R '^(core|culling|capi|gl_gl)\.'
}
run_zink() { with_zink '^(gl|gpuscene|culling|render)_gl\.'; }
run_zink-engine() { with_zink '^engine_gl\.'; }
# But for what compares to the byte (zink rounds colours otherwise), what counts late reports by frames, and two tests
# that find faults of Mesa 22.3.6: one of many edits in which lavapipe crashes unless each of its calls is waited for
# (ZINK_DEBUG=validation), and one of tiles with samples, some of which lavapipe shades once a pixel and not once a
# sample, even if GL_SAMPLE_SHADING asks for each.
with_zink() {
  release
  scripts/with_driver.sh zink ctest --test-dir build/release -j "$(nproc)" --no-tests=error --output-on-failure \
    -R "$1" -LE '^nightly' -E '\.(Images\.OfEveryPlatform|HybridTest\.TheOldestLateReports|StreamingTest\.ReusedIdsAre|FrameTilesInAllModes\.JoinWithoutSeams/samples)'
}
run_osmesa() {
  release
  ctest_in release -R '^osmesa\.'
}
run_fuzz() { scripts/fuzz.sh 20; }
run_tsan() {
  SIGHTLINE_TARGETS="core_tests culling_tests lod_tests raytrace_tests engine_tests" scripts/test.sh tsan -R '^(core|culling|lod|raytrace|engine)\.'
}
run_asan() {
  SIGHTLINE_TARGETS="culling_tests raytrace_tests gpuprims_tests measure_tests compare_tests lod_tests engine_tests" \
    scripts/test.sh asan -R '^(culling|raytrace|gpuprims|measure|compare|lod|engine)\.'
}
run_asan-io() {
  SIGHTLINE_TARGETS="core_tests importers_tests importers_vtk_tests capi_tests view_tests" \
    scripts/test.sh asan -R '^(core|importers|importers_vtk|capi|view)\.'
}
run_asan-cad() {
  SIGHTLINE_TARGETS=importers_cad_tests scripts/test.sh asan -R '^importers_cad\.'
}
run_asan-gl() {
  SIGHTLINE_TARGETS="culling_gl_tests engine_gl_tests view_gl_tests capi_gl_tests" \
    scripts/test.sh asan -R '^(culling_gl|engine_gl|view_gl|capi_gl)\.'
  ctest_in asan -L '^nightly' -R '^engine_gl\.'
}
run_packages() {
  release
  ctest_in release -R '^consumers\.debs$'
}
run_consumers() {
  release
  ctest_in release -R '^consumers\.(headers|package|pkg_config|c_package|c_pkg_config|drawing_package|subdirectory)$'
}
run_shared() {
  release
  ctest_in release -R '^consumers\.(shared_package|c_shared_package|c_shared_pkg_config)$'
}
run_study() {
  SIGHTLINE_CMAKE_ARGS="-DSIGHTLINE_TESTS=ON ${SIGHTLINE_CMAKE_ARGS:-}" \
    scripts/setup.sh study sightline-study study_tests study_gl_tests
  ctest_in study -R '^study'
}
run_wasm() {
  SIGHTLINE_LONG=1 scripts/wasm.sh test culling
}
run_browser() {
  SIGHTLINE_WASM_FORMS=simd scripts/wasm.sh test package plant primitives three tiles
}
# Each in a tree as deep as that of release, so that a compiler cache finds the objects.
run_without() {
  local off="-DSIGHTLINE_APPS=OFF -DSIGHTLINE_PYTHON=OFF -DSIGHTLINE_EXAMPLES=OFF -DSIGHTLINE_REQUIRE_ALL=OFF"
  without bare "$off -DSIGHTLINE_IMPORTERS=OFF -DSIGHTLINE_RAYTRACE=OFF -DSIGHTLINE_LOD=OFF -DSIGHTLINE_IMAGE=OFF -DSIGHTLINE_GL=OFF -DSIGHTLINE_CAPI=OFF -DSIGHTLINE_OPENMP=OFF"
  without no-gl "$off -DSIGHTLINE_GL=OFF -DSIGHTLINE_VTK=OFF -DSIGHTLINE_SLC=OFF -DSIGHTLINE_DRACO=OFF -DSIGHTLINE_MESHOPT=OFF"
}
# without NAME OPTIONS: builds and tests a tree with these options, also where extra CMake arguments require everything.
without() {
  # shellcheck disable=SC2086
  cmake --preset release -B "build/without-$1" ${SIGHTLINE_CMAKE_ARGS:-} $2 "${launcher[@]}" >/dev/null
  cmake --build "build/without-$1" -j "$(nproc)"
  ctest_in "without-$1" -LE '^nightly' -E '^(consumers|docs)\.'
}
# First the files of occlusion culling and its neighbours, whose mistakes no image shows at once. Then one folder in
# turn, of those with files that the last 14 commits changed.
run_mutants() {
  local folders folder files
  mapfile -t files < <(git ls-files culling | grep -E "/($quiet_files)$")
  scripts/mutate.sh --minutes 2 --seed "$(git rev-list --count HEAD)" --targets culling_tests --tests '^culling\.' "${files[@]}" ||
    echo "mutants: could not be tried"
  mapfile -t folders < <(changed_files | xargs -r dirname | sort -u)
  [ ${#folders[@]} -gt 0 ] || { echo "no library file the last 14 commits changed"; return; }
  folder=${folders[$(($(git rev-list --count HEAD) / 14 % ${#folders[@]}))]}
  mapfile -t files < <(changed_files | grep "^$folder/[^/]*$")
  scripts/mutate.sh --minutes 2 --seed "$(git rev-list --count HEAD)" "${files[@]}" || echo "mutants: could not be tried"
}
# By name alone, wherever they lie in culling/.
quiet_files='inner_occluders.cpp|occluder_raster.cpp|occlusion_test.cpp|depth_test.cpp|depth_test.h|depth_pyramid.cpp|cover_polygons.h|small_boxes.h|near_first.cpp|region_query.cpp|contribution.cpp|cull_states.cpp'
changed_files() {
  local since
  since=$(git rev-list --max-count=51 HEAD | tail -1)
  git diff --name-only --diff-filter=AM "$since" HEAD | grep -E '^(core|culling|gpuprims|importers|analysis|lod|raytrace|engine)/.*\.cpp$' || true
}
# Compiles every K-th of N sources and public headers alone with both compilers, as developers without batches do, and
# with g++ all that the last 14 commits changed.
alone() {
  SIGHTLINE_SETUP_CLANG=1 release
  scripts/alone.py build/release --slice "$1/$2" --changed 14
  scripts/alone.py build/release --slice "$1/$2" --compiler clang++
}

names() { awk 'NF { print $1 }' <<<"$units"; }
# Lines "NAME MINUTES SLICE": the longest first, each into the slice that has least so far.
slices() {
  awk 'NF { print $1, $2 }' <<<"$units" | sort -k2,2nr -s | awk -v count="$1" '{
    least = 1
    for (s = 2; s <= count; ++s) if (minutes[s] + 0 < minutes[least] + 0) least = s
    minutes[least] += $2
    print $1, $2, least }'
}
list() {
  slices "$1" | sort -k3,3n -s | while read -r name minutes slice; do
    printf 'slice %s/%s  %2d min  %-10s %s\n' "$slice" "$1" "$minutes" "$name" "$(awk -v n="$name" '$1 == n { $1 = $2 = ""; sub(/^ +/, ""); print }' <<<"$units")"
  done
}

slice=1 count=1 chosen=()
case ${1:-} in
  '') mapfile -t chosen < <(names) ;;
  --list) list "${2:-16}"; exit 0 ;;
  --only)
    shift
    chosen=("$@") slice=0
    for name in "${chosen[@]}"; do names | grep -qx -- "$name" || { echo "nightly: no part '$name', see --list" >&2; exit 2; }; done
    ;;
  [1-9]*/[1-9]*)
    slice=${1%/*} count=${1#*/}
    mapfile -t chosen < <(slices "$count" | awk -v s="$slice" '$3 == s { print $1 }')
    ;;
  *) sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "$0"; [ "$1" = --help ] && exit 0; exit 2 ;;
esac
launcher=()
if command -v ccache >/dev/null; then
  launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
  export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1
fi

failed=()
# In a shell of its own, since "set -e" does not hold in a condition.
part() {
  local start=$SECONDS status=0
  printf '\n== %s\n' "$*"
  set +e
  (set -e; "$@")
  status=$?
  set -e
  printf '== %s: %s after %d s\n' "$*" "$([ $status -eq 0 ] && echo passed || echo FAILED)" $((SECONDS - start))
  [ $status -eq 0 ] || failed+=("$*")
}
for name in "${chosen[@]}"; do part "run_$name"; done
[ "$slice" -eq 0 ] || part alone "$slice" "$count"
if [ ${#failed[@]} -gt 0 ]; then
  printf 'nightly: failed: %s\n' "${failed[*]}" >&2
  exit 1
fi
