#!/usr/bin/env bash
# The library and its tools for Windows, built on Debian 12 with MinGW-w64, and their tests under Wine.
#   scripts/windows.sh                 installs what is missing, builds dependencies once, then everything
#   scripts/windows.sh deps            the dependencies alone, into build/windows-deps
#   scripts/windows.sh build [TARGET …]   dependencies, then these targets
#   scripts/windows.sh check           objects with wide instructions, for stores that need an aligned stack
#   scripts/windows.sh test [ctest arguments …]   builds everything, checks objects, and runs the tests
# SIGHTLINE_JOBS: processes at once (default: all processors). SIGHTLINE_CMAKE_ARGS: more arguments of CMake.
set -euo pipefail
cd "$(dirname "$0")/.."
jobs=${SIGHTLINE_JOBS:-$(nproc)}
deps=$PWD/build/windows-deps
sources=$PWD/build/windows-sources
tree=$PWD/build/windows-mingw

# --- what is installed -----------------------------------------------------------------------------------------------
packages=(g++-mingw-w64-x86-64-posix binutils cmake ninja-build dpkg-dev wine wine64 xvfb python3 debian-archive-keyring
  libgl-dev libegl-dev libglm-dev libexpected-dev nlohmann-json3-dev libcli11-dev libstb-dev libxxhash-dev)

# --- dependencies ----------------------------------------------------------------------------------------------------
# Sources of the distribution, of the versions that its packages are built from. The list is private: the machine's own
# need not name sources.
apt_sources() {
  mkdir -p "$sources/lists/partial"
  echo "deb-src [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian bookworm main" \
    > "$sources/sources.list"
  (cd "$sources" && apt-get -qq -o Dir::Etc::sourcelist="$sources/sources.list" -o Dir::Etc::sourceparts=/dev/null \
    -o Dir::State::lists="$sources/lists" -o Dir::Cache="$sources/cache" -o APT::Sandbox::User=root "$@")
}
source_of() {  # the folder of a source package, which is fetched where it is not there yet
  local found=("$sources/$1"-[0-9]*/)
  if [ ! -d "${found[0]}" ]; then
    { [ -n "$(ls "$sources/lists" 2>/dev/null | grep Sources)" ] || apt_sources update; apt_sources source "$1"; } >&2
    found=("$sources/$1"-[0-9]*/)
  fi
  echo "${found[0]}"
}
launcher=()
if command -v ccache >/dev/null; then launcher=(-DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
built() { [ -e "$deps/.built/$1" ]; }
mark_built() { mkdir -p "$deps/.built" && touch "$deps/.built/$1"; }
with_cmake() {  # NAME arguments of CMake …
  local name=$1 folder
  shift
  if built "$name"; then return 0; fi
  echo "Building $name for Windows"
  folder=$(source_of "$name")
  cmake -S "$folder" -B "$sources/build/$name" -G Ninja -DCMAKE_TOOLCHAIN_FILE="$PWD/cmake/toolchains/mingw.cmake" \
    -DSIGHTLINE_WINDOWS_DEPS="$deps" -DCMAKE_INSTALL_PREFIX="$deps" -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_POLICY_DEFAULT_CMP0091=NEW -DBUILD_SHARED_LIBS=OFF -DBUILD_TESTING=OFF "${launcher[@]}" "$@" >/dev/null
  cmake --build "$sources/build/$name" -j "$jobs" --target install >/dev/null
  mark_built "$name"
}
# Headers alone, copied from where the distribution installs them, so that nothing else of its folder is seen.
copy_headers() {
  if built headers; then return 0; fi
  mkdir -p "$deps/include" "$deps/share/cmake"
  for header in glm tl nlohmann CLI stb xxhash.h; do cp -rL "/usr/include/$header" "$deps/include/"; done
  mkdir -p "$deps/include/GL"
  cp /usr/include/GL/glcorearb.h "$deps/include/GL/"
  cp -r /usr/include/KHR "$deps/include/"
  for package in glm tl-expected nlohmann_json CLI11; do cp -r "/usr/share/cmake/$package" "$deps/share/cmake/"; done
  mark_built headers
}
build_zlib() {  # the distribution's sources lack what its own builds need for Windows
  if built zlib; then return 0; fi
  echo "Building zlib for Windows"
  local folder
  folder=$(source_of zlib)
  mkdir -p "$deps/include" "$deps/lib"
  (cd "$folder" && x86_64-w64-mingw32-gcc-posix -O2 -c ./*.c && x86_64-w64-mingw32-ar rcs "$deps/lib/libz.a" ./*.o)
  cp "$folder"/{zlib.h,zconf.h} "$deps/include/"
  mark_built zlib
}
build_dependencies() {
  scripts/install.sh "${packages[@]}"
  copy_headers
  build_zlib
  with_cmake googletest -DBUILD_GMOCK=ON
  with_cmake fmtlib -DFMT_TEST=OFF -DFMT_DOC=OFF
  with_cmake libpng1.6 -DPNG_SHARED=OFF -DPNG_TESTS=OFF
  with_cmake meshoptimizer
  with_cmake pugixml
  with_cmake libzip -DBUILD_TOOLS=OFF -DBUILD_REGRESS=OFF -DBUILD_EXAMPLES=OFF -DBUILD_DOC=OFF -DENABLE_BZIP2=OFF \
    -DENABLE_LZMA=OFF -DENABLE_ZSTD=OFF -DENABLE_OPENSSL=OFF -DENABLE_GNUTLS=OFF -DENABLE_MBEDTLS=OFF -DENABLE_WINDOWS_CRYPTO=OFF
  with_cmake pcre2 -DPCRE2_BUILD_TESTS=OFF -DPCRE2_BUILD_PCRE2GREP=OFF
  with_cmake draco -DDRACO_TESTS=OFF
}

# --- the project -----------------------------------------------------------------------------------------------------
build_project() {
  build_dependencies
  # shellcheck disable=SC2086
  cmake --preset windows-mingw "${launcher[@]}" ${SIGHTLINE_CMAKE_ARGS:-} >/dev/null
  cmake --build --preset windows-mingw -j "$jobs" ${1:+--target "$@"}
}

case ${1:-} in
  deps) build_dependencies ;;
  check) exec scripts/aligned_stack.py "$tree" ;;
  test)
    build_project
    scripts/aligned_stack.py "$tree"
    ctest --preset windows-mingw -j "$jobs" --no-tests=error "${@:2}"
    ;;
  build) build_project "${@:2}" ;;
  "") build_project ;;
  *) echo "windows: unknown word '$1'" >&2; exit 2 ;;
esac
