#!/usr/bin/env bash
# Runs a command with one of two OpenGL drivers of Mesa that need no GPU, and take none where there is one.
#   scripts/with_driver.sh llvmpipe|zink COMMAND [ARGUMENT …]
# zink is OpenGL on Vulkan, here on lavapipe (package mesa-vulkan-drivers). It shares llvmpipe's rasteriser and its
# compiler's last part; shaders, state, memory and synchronisation go another way. Contexts of OSMesa stay llvmpipe's.
# Tests make sure that they got the driver: tests/support/driver.cpp.
set -euo pipefail
driver=${1:-}
case $driver in
  llvmpipe) unset MESA_LOADER_DRIVER_OVERRIDE ;;
  zink) export MESA_LOADER_DRIVER_OVERRIDE=zink ;;
  *) echo "with_driver: expected llvmpipe or zink, found '$driver'" >&2; exit 2 ;;
esac
shift
[ $# -gt 0 ] || { echo "with_driver: expected a command" >&2; exit 2; }
# With LIBGL_ALWAYS_SOFTWARE zink takes no Vulkan device but a CPU's. A vendor's EGL could still come before Mesa's.
export SIGHTLINE_DRIVER=$driver LIBGL_ALWAYS_SOFTWARE=1
mesa_egl=/usr/share/glvnd/egl_vendor.d/50_mesa.json
if [ -e $mesa_egl ]; then export __EGL_VENDOR_LIBRARY_FILENAMES=$mesa_egl; fi
export __GLX_VENDOR_LIBRARY_NAME=mesa
# OSMesa would take zink, too, and crash.
unset GALLIUM_DRIVER
# zink of Mesa 22.3.6 frees textures too early when a thread of its own makes the calls.
export GALLIUM_THREAD=0
# A layer of Vulkan that asks window systems for the preferred GPU, and complains where there is none.
export NODEVICE_SELECT=1
exec "$@"
