#!/usr/bin/env bash
# Runs a program for Windows under Wine: without messages of Wine, with a folder of its own for what Wine keeps, without
# a display, and with folders of this machine as drive Z.
#   scripts/wine.sh PROGRAM [argument …]
root=$(cd "$(dirname "$0")/.." && pwd)
export WINEDEBUG=${WINEDEBUG:--all} WINEPREFIX=${WINEPREFIX:-$root/build/windows-wine} WINEARCH=win64 LC_ALL=C.UTF-8
unset DISPLAY WAYLAND_DISPLAY
for wine in /usr/lib/wine/wine64 wine64 wine; do
  if command -v "$wine" >/dev/null; then exec "$wine" "$@"; fi
done
echo "wine: not installed" >&2
exit 127
