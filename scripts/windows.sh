#!/usr/bin/env bash
# The library and its tools for Windows, built on Debian 12 with MinGW-w64, and their tests under Wine.
#   scripts/windows.sh                 installs what is missing, builds dependencies once, then everything, and makes
#                                      build/windows/sightline-VERSION-win64.zip
#   scripts/windows.sh deps            the dependencies alone, into build/windows-deps
#   scripts/windows.sh build [TARGET …]   dependencies, then these targets, without the archive
#   scripts/windows.sh check           objects with wide instructions, for stores that need an aligned stack
#   scripts/windows.sh test [ctest arguments …]   builds everything and the archive, or what SIGHTLINE_TARGETS names; checks
#                                      objects, and runs the tests
#   scripts/windows.sh equal MODEL …   draws models with these tools and with those of build/release: images, ids, depths,
#                                      scene caches are the same bytes, or it fails. Meshes of solids in other files
#                                      differ in the last digits of sines, which MinGW-w64 has of the x87.
# SIGHTLINE_JOBS: processes at once (default: all processors). SIGHTLINE_CMAKE_ARGS: more arguments of CMake.
set -euo pipefail
cd "$(dirname "$0")/.."
jobs=${SIGHTLINE_JOBS:-$(nproc)}
deps=$PWD/build/windows-deps
sources=$PWD/build/windows-sources
tree=$PWD/build/windows-mingw

# --- what is installed -----------------------------------------------------------------------------------------------
packages=(g++-mingw-w64-x86-64-posix binutils cmake ninja-build dpkg-dev wine wine64 xvfb xauth python3 debian-archive-keyring
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
libraries=(zlib googletest fmtlib libpng1.6 meshoptimizer pugixml libzip pcre2 draco glfw3 imgui)
source_of() { echo "$sources/$1"-[0-9]*/; }  # the folder of a source package
# All at once: two of these programs would be in each other's way.
fetch_sources() {
  local missing=() library
  for library in "${libraries[@]}"; do [ -d "$(source_of "$library")" ] || missing+=("$library"); done
  if [ ${#missing[@]} = 0 ]; then return 0; fi
  { apt_sources update; apt_sources source "${missing[@]}"; } >&2
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
# An archive of sources that need no configuration, where the distribution's sources lack what their own builds need for
# Windows: lib/libLIBRARY.a. Headers are copied by the caller.
archive() {  # LIBRARY compiler source …
  local library=$1 compiler=$2 objects
  shift 2
  objects=$(mktemp -d)
  for source in "$@"; do
    "x86_64-w64-mingw32-$compiler-posix" -O2 -fno-ipa-ra -fno-ipa-stack-alignment -I. -I"$deps/include" -c "$source" -o "$objects/$(basename "$source").o"
  done
  mkdir -p "$deps/include" "$deps/lib"
  x86_64-w64-mingw32-ar rcs "$deps/lib/lib$library.a" "$objects"/*.o
  rm -r "$objects"
}
build_zlib() {
  if built zlib; then return 0; fi
  echo "Building zlib for Windows"
  local folder
  folder=$(source_of zlib)
  (cd "$folder" && archive z gcc ./*.c)
  cp "$folder"/{zlib.h,zconf.h} "$deps/include/"
  mark_built zlib
}
build_imgui() {
  if built imgui; then return 0; fi
  echo "Building imgui for Windows"
  local folder
  folder=$(source_of imgui)
  (cd "$folder" && archive imgui g++ ./imgui*.cpp backends/imgui_impl_{glfw,opengl3}.cpp misc/cpp/imgui_stdlib.cpp)
  mkdir -p "$deps/include/imgui/backends"
  cp "$folder"/*.h "$folder/misc/cpp/imgui_stdlib.h" "$deps/include/imgui/"
  cp "$folder"/backends/imgui_impl_{glfw,opengl3}.h "$deps/include/imgui/backends/"
  mark_built imgui
}
build_dependencies() {
  scripts/install.sh "${packages[@]}"
  fetch_sources
  copy_headers
  build_zlib
  # Configuring takes one processor: they are made beside each other.
  local builds=()
  beside() { "$@" & builds+=($!); }
  beside with_cmake googletest -DBUILD_GMOCK=ON
  beside with_cmake fmtlib -DFMT_TEST=OFF -DFMT_DOC=OFF
  beside with_cmake libpng1.6 -DPNG_SHARED=OFF -DPNG_TESTS=OFF
  beside with_cmake meshoptimizer
  beside with_cmake pugixml
  beside with_cmake libzip -DBUILD_TOOLS=OFF -DBUILD_REGRESS=OFF -DBUILD_EXAMPLES=OFF -DBUILD_DOC=OFF -DENABLE_BZIP2=OFF \
    -DENABLE_LZMA=OFF -DENABLE_ZSTD=OFF -DENABLE_OPENSSL=OFF -DENABLE_GNUTLS=OFF -DENABLE_MBEDTLS=OFF -DENABLE_WINDOWS_CRYPTO=OFF
  beside with_cmake pcre2 -DPCRE2_BUILD_TESTS=OFF -DPCRE2_BUILD_PCRE2GREP=OFF
  beside with_cmake draco -DDRACO_TESTS=OFF
  with_cmake glfw3 -DGLFW_BUILD_DOCS=OFF -DGLFW_BUILD_TESTS=OFF -DGLFW_BUILD_EXAMPLES=OFF
  build_imgui
  for build in "${builds[@]}"; do wait "$build"; done
}

# --- the project -----------------------------------------------------------------------------------------------------
build_project() {
  build_dependencies
  # shellcheck disable=SC2086
  cmake --preset windows-mingw "${launcher[@]}" ${SIGHTLINE_CMAKE_ARGS:-} >/dev/null
  cmake --build --preset windows-mingw -j "$jobs" ${1:+--target "$@"}
}

# What people get: programs, the DLL, and all that a program of theirs is built with.
make_archive() {
  local version name stage
  version=$(sed -n 's/^project(sightline VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
  name=sightline-$version-win64
  stage=$PWD/build/windows/$name
  rm -rf "$stage" "$stage.zip"
  for component in library development tools; do
    cmake --install "$tree" --prefix "$stage" --component "$component" --strip >/dev/null
  done
  rm -r "$stage/lib/pkgconfig"  # whose dependencies would have to be packages of pkg-config, too
  cp -r "$deps"/include/{glm,tl,GL,KHR} "$stage/include/"
  mkdir -p "$stage/licenses"
  cp -r "$deps"/share/cmake/{glm,tl-expected} "$stage/lib/cmake/"
  cp LICENSE "$stage/licenses/sightline.txt"
  for folder in "$sources"/*/debian; do
    cp "$folder/copyright" "$stage/licenses/$(basename "$(dirname "$folder")").txt"
  done
  for package in libglm-dev libexpected-dev nlohmann-json3-dev libcli11-dev libstb-dev libxxhash-dev libgl-dev gcc-mingw-w64-base mingw-w64-common; do
    cp "/usr/share/doc/$package/copyright" "$stage/licenses/$package.txt"
  done
  sed "s/@PROJECT_VERSION@/$version/; s/$/\r/" packaging/windows/README.txt.in > "$stage/README.txt"
  (cd build/windows && cmake -E tar cf "$name.zip" --format=zip "$name")
  ls -l "$stage.zip"
}

# Runs a program of Wine, or several, beside a display of their own. Wine's server keeps the display that it began with,
# and ends with all programs that it runs: two runs of this script wait for each other.
with_display() {
  mkdir -p build
  exec 9> build/windows.lock
  flock 9
  scripts/wine.sh --end
  xvfb-run -a -s "-screen 0 1280x1024x24" "$@"
  scripts/wine.sh --end
}
tool() {  # linux|windows NAME argument …
  if [ "$1" = linux ]; then "build/release/bin/sightline-$2" "${@:3}"; else scripts/wine.sh "$tree/bin/sightline-$2.exe" "${@:3}"; fi
}
compare_models() {
  local folder=build/windows/equal failed=0
  mkdir -p "$folder"
  for model in "$@"; do
    for system in linux windows; do
      for look in --plain --edge-lines=0.4; do
        tool $system render "$model" --size 640x360 --renderer gl $look --out "$folder/$system.$look.png" \
          --ids "$folder/$system.$look.ids.png" --depth "$folder/$system.$look.pfm"
      done
      tool $system convert "$model" "$folder/$system.slc"
    done >/dev/null
    for file in "$folder"/linux.*; do
      cmp -s "$file" "${file/linux./windows.}" || { echo "$model: ${file##*/linux.} differs"; failed=1; }
    done
    echo "$model: compared"
    rm "$folder"/*
  done
  return $failed
}

case ${1:-} in
  deps) build_dependencies ;;
  check) exec scripts/aligned_stack.py "$tree" ;;
  test)
    # shellcheck disable=SC2086
    build_project ${SIGHTLINE_TARGETS:-}
    scripts/aligned_stack.py "$tree"
    [ -n "${SIGHTLINE_TARGETS:-}" ] || make_archive
    # The first program makes Wine's folder.
    with_display sh -c 'scripts/wine.sh cmd.exe /c exit; exec "$@"' - \
      ctest --preset windows-mingw -j "$jobs" --no-tests=error "${@:2}"
    ;;
  build) build_project "${@:2}" ;;
  equal) with_display "$0" equal-here "${@:2}" ;;
  equal-here) compare_models "${@:2}" ;;
  "")
    build_project
    make_archive
    ;;
  *) echo "windows: unknown word '$1'" >&2; exit 2 ;;
esac
