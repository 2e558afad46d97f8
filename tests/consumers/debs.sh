#!/usr/bin/env bash
# debs.sh BIN FOLDER: builds the Debian packages, lets lintian judge them, installs them and uses them (use_debs.sh).
# BIN holds the tools of another build, whose image the packaged one's must equal. dpkg installs the packages in an
# overlay of this machine's files, which leaves the machine as it is. Without the right to mount one (root), they are
# unpacked below FOLDER.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
source=$(cd "$here/../.." && pwd)
bin=$1 folder=$2
mkdir -p "$folder"
"$source/scripts/package.sh"
debs=("$source"/build/packages/debs/*.deb)

# Tags of warnings and errors that are not overridden, with reasons, in cmake/debian/.
tags=$(lintian --allow-root --fail-on error,warning "${debs[@]}" 2>&1) || { printf '%s\n' "$tags" >&2; exit 1; }

model=$source/tests/data/small_plant.rvm
"$bin/sightline-render" "$model" --plain --size 320x180 --out "$folder/reference.png"

in_overlay() {
  set -e
  mount -t tmpfs none "$folder/overlay"
  mkdir "$folder"/overlay/{upper,work,root}
  root=$folder/overlay/root
  mount -t overlay overlay -o "lowerdir=/,upperdir=$folder/overlay/upper,workdir=$folder/overlay/work" "$root"
  for path in /dev /proc; do mount --rbind "$path" "$root$path"; done
  mount --bind "$source" "$root$source"
}
export -f in_overlay
export folder source model
mkdir -p "$folder/overlay"
if unshare -m bash -c in_overlay 2>/dev/null; then
  # shellcheck disable=SC2016
  unshare -m bash -ec 'in_overlay; log=$folder/dpkg.log use=$1; shift
    chroot "$root" dpkg -i "$@" >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
    exec chroot "$root" "$use" /usr "$model" "$folder"' debs "$here/use_debs.sh" "${debs[@]}"
else
  echo "debs: no overlay may be mounted here, so the packages are only unpacked"
  rm -rf "$folder/root"
  for deb in "${debs[@]}"; do dpkg-deb -x "$deb" "$folder/root"; done
  "$here/use_debs.sh" "$folder/root/usr" "$model" "$folder"
fi
