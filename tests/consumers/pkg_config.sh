#!/bin/sh
# pkg_config.sh PREFIX FOLDER [c]: compiles the consumer, or the one in C, with what pkg-config says of the library below
# PREFIX, and runs it.
set -eu
if [ "$1" != /usr ]; then
  PKG_CONFIG_PATH="$(find "$1" -name pkgconfig -type d)${PKG_CONFIG_PATH:+:$PKG_CONFIG_PATH}"
  export PKG_CONFIG_PATH
fi
mkdir -p "$2"
here=$(dirname "$0")
# shellcheck disable=SC2046
if [ "${3:-}" = c ]; then
  "${CC:-cc}" -std=c99 -Wall -Wextra -Werror "$here/../bindings/c/c_program.c" -o "$2/consumer" \
    $(pkg-config --cflags --libs sightline-capi)
else
  "${CXX:-c++}" "$here/consumer.cpp" -o "$2/consumer" $(pkg-config --cflags --libs sightline-culling)
fi
"$2/consumer"
