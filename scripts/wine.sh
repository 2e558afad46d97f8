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
wine=
for found in /usr/lib/wine/wine64 wine64 wine; do
  if [ -z "$wine" ] && command -v "$found" >/dev/null; then wine=$found; fi
done
if [ -z "$wine" ]; then
  echo "wine: not installed" >&2
  exit 127
fi
if [ ! -e "$WINEPREFIX/system.reg" ]; then  # of the oldest version that is supported
  mkdir -p "$WINEPREFIX"
  "$wine" winecfg.exe -v win10 >/dev/null 2>&1
fi
# Wine kills a process whose end takes more than a second, as that of drivers may on a busy machine. Who waits for it
# within Wine has its exit code all the same. That is cmd.exe, where it takes the path and the arguments as they are.
program=$(realpath -q -- "${1:-}") || program=
if [ -f "$program" ] && [[ $program != *" "* && "$*" != *[\&\|\<\>^%\"]* ]]; then
  exec "$wine" cmd.exe /d /c "Z:${program//\//\\}" "${@:2}"
fi
exec "$wine" "$@"
