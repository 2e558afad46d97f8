#!/bin/sh
# installed_headers.sh PREFIX: headers that are installed include only such headers, none of them is internal, and those in
# detail/ are there because public ones include them.
set -eu
cd "$1/include"
bad=$(mktemp)
trap 'rm -f "$bad"' EXIT
find sightline -type f | while read -r header; do
  sed -n 's/^ *# *include "\(sightline\/[^"]*\)".*/\1/p' "$header" | while read -r included; do
    [ -f "$included" ] || echo "$header includes $included, which is not installed" >>"$bad"
  done
  case $header in
    */internal/*) echo "$header: internal headers are not installed" >>"$bad" ;;
    */detail/*) grep -rqF "#include \"$header\"" sightline || echo "$header: no installed header includes it" >>"$bad" ;;
  esac
done
cat "$bad"
[ ! -s "$bad" ]
