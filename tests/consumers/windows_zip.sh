#!/usr/bin/env bash
# windows_zip.sh ARCHIVE FOLDER: builds the examples with what the archive for Windows holds, and nothing else, and runs
# them beside its library; its tools draw, too.
set -euo pipefail
cd "$(dirname "$0")/../.."
archive=$(realpath "$1")
rm -rf "$2"
mkdir -p "$2"
folder=$(realpath "$2")
(cd "$folder" && cmake -E tar xf "$archive")
unpacked=$folder/$(basename "$archive" .zip)
cmake -S tests/consumers/examples -B "$folder/build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_TOOLCHAIN_FILE="$PWD/cmake/toolchains/mingw.cmake" -DSIGHTLINE_WINDOWS_DEPS="$unpacked"
cmake --build "$folder/build"
cp "$unpacked"/bin/*.dll "$folder/build/"
run() { scripts/wine.sh "$@"; }
run "$folder/build/c_cull.exe" | tr -d '\r' | grep -qx 'box 0'
run "$folder/build/cull_only.exe" "$folder/cull_only.png"
run "$folder/build/embed.exe" tests/data/small_plant.rvm "$folder/embed.png"
run "$folder/build/c_embed.exe" tests/data/small_plant.rvm "$folder/c_embed.png"
run "$unpacked/bin/sightline-render.exe" tests/data/small_plant.rvm --out "$folder/render.png" --size 640x360
for file in README.txt licenses/sightline.txt bin/sightline-view.exe include/sightline/sightline.h; do
  [ -s "$unpacked/$file" ] || { echo "windows_zip: $file is missing" >&2; exit 1; }
done
