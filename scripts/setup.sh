#!/usr/bin/env bash
# Installs what a build needs on Debian 12 (skips what is installed), then configures and builds one preset.
#   scripts/setup.sh [PRESET [TARGET …]]      release (default), debug, asan, tsan, fuzz, packages, study, gpu-kit-build,
#                                             wasm, wasm-threads or wasm-scalar; everything, or these targets
# Packages that only tests and the window need are installed when everything or a target with tests (…_tests, wasm_…) is
# built.
# Sources are compiled in batches; after edits of single files it is faster without: SIGHTLINE_CMAKE_ARGS=-DSIGHTLINE_UNITY=OFF.
# SIGHTLINE_CMAKE_ARGS holds extra CMake arguments; SIGHTLINE_SETUP_VTK=1 installs VTK, SIGHTLINE_SETUP_OCCT=1 Open CASCADE,
# SIGHTLINE_SETUP_EXAMPLES=1 what the examples with OpenSceneGraph and Qt 6 need, SIGHTLINE_SETUP_PACKAGES=1 what tests
# of the Debian packages need, SIGHTLINE_SETUP_BROWSER=1 what those of the npm package need, SIGHTLINE_SETUP_CLANG=1 clang.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}
[ $# -gt 0 ] && shift

packages=(g++ cmake ninja-build libglm-dev libexpected-dev libfmt-dev libcli11-dev nlohmann-json3-dev
  libstb-dev libmeshoptimizer-dev libdraco-dev libxxhash-dev libpng-dev libegl-dev libgl-dev libopengl-dev libegl1 libegl-mesa0 libgl1-mesa-dri)
if [[ $preset == wasm* ]]; then
  packages=(emscripten cmake ninja-build libglm-dev libexpected-dev libfmt-dev nlohmann-json3-dev libxxhash-dev)
  # A node that is not Debian's has an npm of its own, which Debian's cannot be installed beside.
  command -v npm >/dev/null || packages+=(npm)
  # Emscripten's own scripts look for node's modules where Debian installs them.
  export NODE_PATH=/usr/share/nodejs${NODE_PATH:+:$NODE_PATH}
elif [ "$preset" = packages ]; then
  packages+=(libglfw3-dev libimgui-dev libpcre2-dev libzip-dev libpugixml-dev pybind11-dev python3-dev python3-numpy)
elif [ "$preset" = gpu-kit-build ]; then
  packages+=(ccache libgtest-dev libgmp-dev binutils)
elif [ $# -eq 0 ] || [[ $* == *_tests* || $* == *wasm_* ]]; then
  packages+=(ccache fonts-dejavu-core libglfw3-dev libimgui-dev libpcre2-dev libgtest-dev libgmp-dev libosmesa6 mesa-vulkan-drivers pkg-config xvfb xdotool
    libopenmpi-dev openmpi-bin parallel libzip-dev libpugixml-dev pybind11-dev python3-dev python3-numpy python3-pip python3-venv mypy doxygen
    glslang-dev glslang-tools spirv-tools)
fi
if [ "$preset" = packages ] || [ -n "${SIGHTLINE_SETUP_PACKAGES:-}" ]; then packages+=(dpkg-dev file help2man); fi
if [ -n "${SIGHTLINE_SETUP_PACKAGES:-}" ]; then packages+=(lintian); fi
# VTK brings 246 packages, so it is installed only on request. With it the build has importers/vtk.
if [ -n "${SIGHTLINE_SETUP_VTK:-}" ]; then packages+=(libvtk9-dev); fi
# Open CASCADE, for STEP, IGES and BREP, likewise.
if [ "$preset" = packages ] || [ -n "${SIGHTLINE_SETUP_OCCT:-}" ]; then
  packages+=(libocct-data-exchange-dev libocct-ocaf-dev libocct-modeling-algorithms-dev libocct-visualization-dev libtbb-dev zlib1g-dev)
fi
# For the examples that draw into the windows of others.
if [ -n "${SIGHTLINE_SETUP_EXAMPLES:-}" ]; then packages+=(libopenscenegraph-dev qt6-base-dev libqt6opengl6-dev); fi
if [ -n "${SIGHTLINE_SETUP_BROWSER:-}" ]; then packages+=(chromium); fi
if [ "$preset" = fuzz ] || [ -n "${SIGHTLINE_SETUP_CLANG:-}" ]; then packages+=(clang libclang-rt-14-dev); fi

scripts/install.sh "${packages[@]}"

# With relative paths trees of the same depth, such as build/release and build/packages, share compiled objects; so do
# checkouts, whose folder only debug information would name.
if command -v ccache >/dev/null && [ -z "$(ccache --get-config base_dir)" ]; then
  export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1
fi
# The launcher is chosen once: a change would recompile everything.
launcher=()
if [ ! -e "build/$preset/CMakeCache.txt" ] && command -v ccache >/dev/null; then
  launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
# shellcheck disable=SC2086
cmake --preset "$preset" "${launcher[@]}" ${SIGHTLINE_CMAKE_ARGS:-} >/dev/null
cmake --build --preset "$preset" -j "$(nproc)" ${1:+--target "$@"}
