#!/usr/bin/env bash
# exports.sh LIBRARY: fails when the shared library exports functions or data that are not Sightline's, in C++ or C.
# Weak symbols are left out: instances of the standard library's templates.
set -euo pipefail
case $1 in
  *.dll) names=$(x86_64-w64-mingw32-objdump -p "$1" | sed -n '/Ordinal\/Name/,$ s/^\t\[ *[0-9]*\] //p' | c++filt |
                   sed 's/^\(vtable\|typeinfo\|typeinfo name\) for //') ;;
  *) names=$(nm -D --defined-only -C "$1" | sed -n 's/^[0-9a-f]* [TDBR] //p') ;;
esac
[ -n "$names" ] || { echo "exports: $1 exports nothing" >&2; exit 1; }
if strangers=$(grep -v -e '^sightline::' -e '^sl_[a-z_]*$' <<<"$names"); then
  printf 'exports: not of Sightline: %s\n' "$strangers" >&2
  exit 1
fi
