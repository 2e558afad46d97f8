#!/usr/bin/env bash
# Runs a program for Windows under Wine: without messages of Wine, with a folder of its own for what Wine keeps, and with
# folders of this machine as drive Z.
#   scripts/wine.sh PROGRAM [argument …]
#   scripts/wine.sh --end                  ends what Wine left running, which keeps the display that it began with
root=$(cd "$(dirname "$0")/.." && pwd)
export WINEDEBUG=${WINEDEBUG:--all} WINEPREFIX=${WINEPREFIX:-$root/build/windows-wine} WINEARCH=win64 LC_ALL=C.UTF-8
# A crash is told by the exit code, not by a debugger's report; Mono and Gecko are not asked for.
export WINEDLLOVERRIDES="winedbg.exe=d;mscoree,mshtml="
if [ "${1:-}" = --end ]; then
  wineserver -k 2>/dev/null
  exit 0
fi
for wine in /usr/lib/wine/wine64 wine64 wine; do
  command -v "$wine" >/dev/null || continue
  if [ ! -e "$WINEPREFIX/system.reg" ]; then  # of the oldest version that is supported
    mkdir -p "$WINEPREFIX"
    "$wine" winecfg.exe -v win10 >/dev/null 2>&1
  fi
  exec "$wine" "$@"
done
echo "wine: not installed" >&2
exit 127
