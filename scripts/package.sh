#!/usr/bin/env bash
# Builds the Debian packages (docs/guide/packages.md) on Debian 12, as build/packages/debs/*.deb. Installs what is missing
# for that. SIGHTLINE_CMAKE_ARGS holds extra CMake arguments; DEBFULLNAME and DEBEMAIL name the maintainer.
set -euo pipefail
cd "$(dirname "$0")/.."
# Dates in packages are those of the sources.
export SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || stat -c %Y CHANGELOG.md)}
scripts/setup.sh packages
rm -rf build/packages/debs
log=$(cd build/packages && umask 022 && cpack 2>&1) || { printf '%s\n' "$log" >&2; exit 1; }
ls build/packages/debs/*.deb
