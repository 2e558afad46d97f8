#!/usr/bin/env bash
# use_debs.sh PREFIX MODEL FOLDER: what users of the Debian packages do, which are installed below PREFIX: a tool, whose
# image is FOLDER/reference.png, applications in C++ and C that find the library with CMake and with pkg-config,
# and Python, which draws the same image.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
prefix=$1 model=$2 folder=$3
if [ "$prefix" != /usr ]; then
  libraries=$(dirname "$(find "$prefix" -name 'libsightline.so.*' -type l)")
  export LD_LIBRARY_PATH=$libraries CMAKE_PREFIX_PATH=$prefix
fi

"$prefix/bin/sightline-render" "$model" --plain --size 320x180 --compare "$folder/reference.png"
for tool in "$prefix"/bin/sightline-*; do
  [ -s "$prefix/share/man/man1/${tool##*/}.1.gz" ] || { echo "use_debs: ${tool##*/} has no manual page" >&2; exit 1; }
done

# Desktops start a program that is there, show its icon, and know its types of files.
desktop=$prefix/share/applications/sightline-view.desktop
for file in "$prefix/bin/$(sed -n 's/^Exec=\([^ ]*\).*/\1/p' "$desktop")" \
  "$prefix/share/icons/hicolor/scalable/apps/$(sed -n 's/^Icon=//p' "$desktop").svg"; do
  [ -s "$file" ] || { echo "use_debs: no $file" >&2; exit 1; }
done
for type in $(sed -n 's/^MimeType=//p' "$desktop" | tr ';' ' '); do
  grep -q "type=\"$type\"" "$prefix/share/mime/packages/sightline.xml" || { echo "use_debs: unknown $type" >&2; exit 1; }
done

rm -rf "$folder/cmake"
cmake -S "$here/package" -B "$folder/cmake" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCONSUMER_DRAWS=ON >/dev/null
cmake --build "$folder/cmake" >/dev/null
"$folder/cmake/consumer" "$model" "$folder/cmake/image.png"
# (Not grep -q: it leaves before ldd has finished, which then fails.)
ldd "$folder/cmake/consumer" | grep 'libsightline\.so' >/dev/null || { echo "use_debs: not the shared library" >&2; exit 1; }

"$here/pkg_config.sh" "$prefix" "$folder/pkg_config"

if [ -e "$prefix/include/sightline/sightline.h" ]; then
  rm -rf "$folder/c_cmake"
  cmake -S "$here/c_package" -B "$folder/c_cmake" -G Ninja -DCONSUMER_LINKS_SHARED=ON >/dev/null
  cmake --build "$folder/c_cmake" >/dev/null
  "$folder/c_cmake/consumer"
  "$here/pkg_config.sh" "$prefix" "$folder/c_pkg_config" c
fi

if [ -e "$prefix/lib/python3/dist-packages/sightline" ]; then
  if [ "$prefix" != /usr ]; then export PYTHONPATH=$prefix/lib/python3/dist-packages; fi
  (cd / && /usr/bin/python3 - "$model" "$folder/reference.png") <<'END'
import sys, sightline
scene = sightline.Scene()
scene.import_file(sys.argv[1])
assert (sightline.render(scene, width=320, height=180) == sightline.read_png(sys.argv[2])).all()
END
fi
