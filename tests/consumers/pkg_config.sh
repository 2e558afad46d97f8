#!/bin/sh
# pkg_config.sh PREFIX FOLDER: compiles the consumer with what pkg-config says of the library below PREFIX, and runs it.
set -eu
if [ "$1" != /usr ]; then
  PKG_CONFIG_PATH="$(find "$1" -name pkgconfig -type d)${PKG_CONFIG_PATH:+:$PKG_CONFIG_PATH}"
  export PKG_CONFIG_PATH
fi
mkdir -p "$2"
# shellcheck disable=SC2046
"${CXX:-c++}" "$(dirname "$0")/consumer.cpp" -o "$2/consumer" $(pkg-config --cflags --libs sightline-culling)
"$2/consumer"
