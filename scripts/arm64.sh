#!/usr/bin/env bash
# The library and its tools for Linux on 64-bit ARM, built on Debian 12 with its cross compiler, and their tests under
# qemu-user.
#   scripts/arm64.sh                      installs what is missing, fetches dependencies once, then builds everything
#   scripts/arm64.sh deps                 the dependencies alone, into build/arm64-root
#   scripts/arm64.sh build [TARGET …]     dependencies, then these targets
#   scripts/arm64.sh test [ctest arguments …]   builds everything, or what SIGHTLINE_TARGETS names, and runs the tests
#   scripts/arm64.sh packages             the Debian packages, as build/arm64-packages/debs/*.deb, judged by lintian
# SIGHTLINE_JOBS: processes at once (default: all processors). SIGHTLINE_CMAKE_ARGS: more arguments of CMake.
set -euo pipefail
cd "$(dirname "$0")/.."
jobs=${SIGHTLINE_JOBS:-$(nproc)}
root=$PWD/build/arm64-root

# --- dependencies ----------------------------------------------------------------------------------------------------
packages=(libstdc++-12-dev libglm-dev libexpected-dev libfmt-dev libcli11-dev nlohmann-json3-dev libstb-dev
  libmeshoptimizer-dev libdraco-dev libxxhash-dev libpng-dev libpcre2-dev libzip-dev libpugixml-dev libgtest-dev libgmp-dev
  libegl-dev libgl-dev libopengl-dev libegl1 libegl-mesa0 libgl1-mesa-dri libglfw3-dev libimgui-dev fonts-dejavu-core)
# Packages for ARM, with lists of its own: the machine's own packages stay as they are.
apt_arm64() {
  local apt=$root/var/apt
  mkdir -p "$apt"/{lists,archives}/partial
  touch "$apt/status"
  echo "deb [arch=arm64 signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian bookworm main" \
    > "$apt/sources.list"
  apt-get -qq -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o APT::Install-Recommends=false -o APT::Sandbox::User=root \
    -o Dir::Etc::sourcelist="$apt/sources.list" -o Dir::Etc::sourceparts=/dev/null -o Dir::State="$apt" \
    -o Dir::State::lists="$apt/lists" -o Dir::State::status="$apt/status" -o Dir::Cache="$apt" \
    -o Dir::Cache::archives="$apt/archives" "$@"
}
# What dpkg-shlibdeps asks for: which package a library is of, and which of its versions has the symbols.
list_package() {
  local control name
  control=$(mktemp -d)
  dpkg-deb -e "$1" "$control"
  name=$(dpkg-deb -f "$1" Package)
  if [ "$(dpkg-deb -f "$1" Multi-Arch)" = same ]; then name=$name:arm64; fi
  dpkg-deb --fsys-tarfile "$1" | tar -t | sed "s|^\.\(/lib/\)|./usr\1|; s|^\.|$root|; s|/$||" > "$root/var/dpkg/info/$name.list"
  for file in symbols shlibs; do
    if [ -e "$control/$file" ]; then cp "$control/$file" "$root/var/dpkg/info/$name.$file"; fi
  done
  { sed '1a Status: install ok installed' "$control/control"; echo; } >> "$root/var/dpkg/status"
  rm -r "$control"
}
# Unpacks them and all that they need. Folders of / lie in /usr, and links lead to places within the root.
fetch_dependencies() {
  scripts/install.sh g++-aarch64-linux-gnu qemu-user cmake ninja-build python3 debian-archive-keyring
  [ "$(cat "$root/.packages" 2>/dev/null)" != "${packages[*]}" ] || return 0
  echo "Fetching packages for ARM"
  apt_arm64 update
  apt_arm64 install -y --download-only "${packages[@]}"
  rm -rf "$root"/{usr,var/dpkg}
  mkdir -p "$root"/{usr/lib,var/dpkg/info,var/dpkg/updates}
  echo 1 > "$root/var/dpkg/info/format"  # files are named by architecture
  ln -sfn usr/lib "$root/lib"
  for package in "$root"/var/apt/archives/*.deb; do
    dpkg-deb --fsys-tarfile "$package" | tar -x --keep-directory-symlink -C "$root"
    list_package "$package"
  done
  find "$root" -lname '/*' | while read -r link; do ln -sfnr "$root$(readlink "$link")" "$link"; done
  # Draco's package for CMake names its places in full.
  sed -i "s|\"/usr|\"$root/usr|" "$root"/usr/lib/aarch64-linux-gnu/cmake/draco/draco-targets*.cmake
  echo "${packages[*]}" > "$root/.packages"
}

# --- the project -----------------------------------------------------------------------------------------------------
build_preset() {  # PRESET [TARGET …]
  fetch_dependencies
  local launcher=()
  export CCACHE_BASEDIR=${CCACHE_BASEDIR:-$PWD} CCACHE_NOHASHDIR=1  # as scripts/setup.sh: both trees share objects
  if command -v ccache >/dev/null; then launcher=(-DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
  # shellcheck disable=SC2086
  cmake --preset "$1" "${launcher[@]}" ${SIGHTLINE_CMAKE_ARGS:-} >/dev/null
  cmake --build --preset "$1" -j "$jobs" ${2:+--target "${@:2}"}
}
make_packages() {
  local tree=$PWD/build/arm64-packages log
  scripts/install.sh dpkg-dev file help2man lintian
  SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || stat -c %Y CHANGELOG.md)}
  export SOURCE_DATE_EPOCH DEB_HOST_ARCH=arm64
  build_preset arm64-packages
  rm -rf "$tree/debs"
  log=$(cd "$tree" && umask 022 && cpack -D CPACK_DEBIAN_PACKAGE_ARCHITECTURE=arm64 \
    -D "SHLIBDEPS_EXECUTABLE=/usr/bin/dpkg-shlibdeps;--admindir=$root/var/dpkg" 2>&1) || { printf '%s\n' "$log" >&2; exit 1; }
  ls "$tree"/debs/*.deb
  lintian --allow-root --fail-on error,warning "$tree"/debs/*.deb
}

case ${1:-} in
  deps) fetch_dependencies ;;
  test)
    # shellcheck disable=SC2086
    build_preset linux-arm64 ${SIGHTLINE_TARGETS:-}
    ctest --preset linux-arm64 -j "$jobs" --no-tests=error "${@:2}"
    ;;
  packages) make_packages ;;
  build) build_preset linux-arm64 "${@:2}" ;;
  "") build_preset linux-arm64 ;;
  *) echo "arm64: unknown word '$1'" >&2; exit 2 ;;
esac
